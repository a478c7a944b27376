use super::*;
use crate::frames::pose2;

fn saved() -> SavedState {
    SavedState {
        plugin: "ekf_line_slam".into(),
        version: "0.1.0".into(),
        map_from_base: pose2(1.5, -2.25, 0.7),
        covariance: Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0),
        is_lost: true,
        bytes: (0..=255).collect(),
    }
}

/// A file of this test's own.
fn file(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo_saved_state_{}_{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder.join("office.state")
}

fn read(path: &Path, bytes: &[u8]) -> Result<SavedState, StateFault> {
    std::fs::write(path, bytes).unwrap();
    SavedState::read(path, "ekf_line_slam")
}

/// The same with a sum that fits.
fn summed(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(bytes.len() - 4);
    Seal::close(bytes)
}

#[test]
fn what_was_written_is_read_to_the_bit_and_in_place_of_what_was_there() {
    let path = file("whole");
    for state in [SavedState { bytes: Vec::new(), is_lost: false, ..saved() }, saved()] {
        state.write(&path).unwrap();
        assert_eq!(SavedState::read(&path, "ekf_line_slam"), Ok(state));
    }
    let others = std::fs::read_dir(path.parent().unwrap()).unwrap().count();
    assert_eq!(others, 1, "no part is left behind");
}

#[test]
fn a_write_that_fails_leaves_what_was_there() {
    let path = file("kept");
    saved().write(&path).unwrap();
    let in_the_way = path.with_added_extension(format!("{}.part", std::process::id()));
    std::fs::create_dir_all(in_the_way.join("full")).unwrap();
    SavedState { is_lost: false, ..saved() }.write(&path).unwrap_err();
    assert_eq!(SavedState::read(&path, "ekf_line_slam"), Ok(saved()));
}

#[test]
fn what_is_no_state_is_told_from_what_is_broken_and_whose_it_is() {
    let path = file("broken");
    let missing = SavedState::read(&path, "ekf_line_slam").unwrap_err();
    assert!(matches!(&missing, StateFault::File { path: told, .. } if *told == path), "{missing}");
    let bytes = saved().to_bytes();
    assert_eq!(read(&path, b"something else"), Err(StateFault::Foreign { path: path.clone() }));
    assert_eq!(read(&path, b""), Err(StateFault::Foreign { path: path.clone() }));
    for n in 12..bytes.len() {
        assert_eq!(read(&path, &bytes[..n]), Err(StateFault::Damaged { path: path.clone() }), "{n}");
    }
    for at in 12..bytes.len() {
        let mut flipped = bytes.clone();
        flipped[at] ^= 4;
        assert_eq!(read(&path, &flipped), Err(StateFault::Damaged { path: path.clone() }), "{at}");
    }
    let mut newer = bytes.clone();
    newer[8] = 2;
    assert_eq!(read(&path, &summed(newer)), Err(StateFault::Version { path: path.clone(), found: 2 }));
    let mut longer = bytes.clone();
    longer.push(0);
    assert_eq!(read(&path, &summed(longer)), Err(StateFault::Damaged { path: path.clone() }));
    let other = SavedState::read(&path, "graph_slam");
    assert!(matches!(other, Err(StateFault::Damaged { .. })));
    std::fs::write(&path, &bytes).unwrap();
    let other = SavedState::read(&path, "graph_slam").unwrap_err().to_string();
    assert!(other.ends_with("was saved by `ekf_line_slam`, and [slam] is `graph_slam`"), "{other}");
}

#[test]
fn a_sum_that_fits_does_not_make_numbers_of_what_is_none() {
    let path = file("odd");
    for state in [
        SavedState { map_from_base: pose2(f64::NAN, 0.0, 0.0), ..saved() },
        SavedState { covariance: Matrix3::from_element(f64::INFINITY), ..saved() },
    ] {
        assert_eq!(read(&path, &state.to_bytes()), Err(StateFault::Damaged { path: path.clone() }));
    }
    let bytes = saved().to_bytes();
    let cosine = 8 + 4 + 4 + 13 + 4 + 5 + 16;
    let mut stretched = bytes.clone();
    stretched[cosine..cosine + 8].copy_from_slice(&2.0_f64.to_le_bytes());
    assert_eq!(read(&path, &summed(stretched)), Err(StateFault::Damaged { path: path.clone() }));
    let n_at = bytes.len() - 4 - 256 - 8;
    let mut huge = bytes;
    huge[n_at..n_at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    assert_eq!(read(&path, &summed(huge)), Err(StateFault::Damaged { path }));
}
