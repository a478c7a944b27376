//! Files: what was written comes back, and whatever else is there is never taken for a model.

use super::*;
use std::path::PathBuf;

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-landmark-model-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn small() -> (Grid, LandmarkModel, [u8; 32]) {
    let grid = random_map(20, 12, 4);
    let (model, print) = (model_of(&grid), fingerprint(&grid, &SETTINGS));
    (grid, model, print)
}

#[test]
fn a_model_comes_back_as_it_was_and_nothing_is_left_beside_it() {
    let folder = folder("whole");
    let path = folder.join("office.landmark_model");
    let (_, model, print) = small();
    for _ in 0..2 {
        save_model(&path, &model, &print).unwrap();
        assert!(load_model(&path, &print).unwrap() == model);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn files_that_are_cut_off_anywhere_or_changed_anywhere_are_refused() {
    let folder = folder("damaged");
    let path = folder.join("office.landmark_model");
    let (_, model, print) = small();
    save_model(&path, &model, &print).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for n in 0..whole.len() {
        std::fs::write(&path, &whole[..n]).unwrap();
        assert!(load_model(&path, &print).is_err(), "{n} of {} bytes", whole.len());
    }
    for n in 0..whole.len() {
        let mut flipped = whole.clone();
        flipped[n] ^= 1 << (n % 8);
        std::fs::write(&path, &flipped).unwrap();
        assert!(load_model(&path, &print).is_err(), "byte {n}");
    }
    std::fs::write(&path, [whole.as_slice(), b"more"].concat()).unwrap();
    assert!(load_model(&path, &print).is_err());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn files_whose_checksum_is_right_must_hold_together_as_well() {
    let folder = folder("unsound");
    let path = folder.join("office.landmark_model");
    let (_, model, print) = small();
    save_model(&path, &model, &print).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut n_refused = 0;
    for k in 0..3000 {
        let mut bent = whole[..whole.len() - 4].to_vec();
        // Behind the fingerprint; sizes and counts most of all.
        let at = if k % 3 == 0 { 44 + k % 16 } else { rng.random_range(44..bent.len()) };
        bent[at] = rng.random();
        let sum = crc32fast::hash(&bent);
        bent.extend(sum.to_le_bytes());
        std::fs::write(&path, &bent).unwrap();
        match load_model(&path, &print) {
            Err(_) => n_refused += 1,
            // A look may be exchanged for another: then it still can be used.
            Ok(odd) => {
                let looks = [LookKind::Wall, LookKind::HidesLeft].map(|kind| Look {
                    kind,
                    distance_m: 1.0,
                    extent_m: 1.0,
                });
                Filter::default().pass(&odd, &looks, &Similarity { distance_m: 2.0, extent_m: 2.0 });
                assert!(odd.n_landmarks() >= odd.n_cells());
            }
        }
    }
    assert!(n_refused > 1500, "{n_refused}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn models_of_other_maps_other_settings_and_other_versions_are_told_apart() {
    let folder = folder("stale");
    let path = folder.join("office.landmark_model");
    let (grid, model, print) = small();
    save_model(&path, &model, &print).unwrap();
    let mut changed = grid.clone();
    changed.cells.make_mut()[17] = if grid.cells[17] > 0.0 { -5.0 } else { 5.0 };
    assert!(matches!(load_model(&path, &fingerprint(&changed, &SETTINGS)), Err(ModelFileError::Stale)));
    // Log-odds of the same class are the same map.
    let mut surer = grid.clone();
    surer.cells.make_mut().iter_mut().for_each(|cell| *cell *= 0.9);
    assert_eq!(fingerprint(&surer, &SETTINGS), print);
    let landmarks = SETTINGS.landmarks;
    let others = [
        ModelSettings { n_rays: 181, ..SETTINGS },
        ModelSettings { range_m: 4.5, ..SETTINGS },
        ModelSettings { landmarks: LandmarkSettings { wall_m: 0.31, ..landmarks }, ..SETTINGS },
        ModelSettings { landmarks: LandmarkSettings { corner_m: 0.16, ..landmarks }, ..SETTINGS },
        ModelSettings { landmarks: LandmarkSettings { discontinuity_m: 0.21, ..landmarks }, ..SETTINGS },
        ModelSettings { landmarks: LandmarkSettings { least_readings: 6, ..landmarks }, ..SETTINGS },
        ModelSettings { landmarks: LandmarkSettings { range_deviation_m: 0.02, ..landmarks }, ..SETTINGS },
        ModelSettings { landmarks: LandmarkSettings { spares_grazed_walls: false, ..landmarks }, ..SETTINGS },
        ModelSettings {
            landmarks: LandmarkSettings { wall_fit: crate::landmarks::WallFit::Hough, ..landmarks },
            ..SETTINGS
        },
    ];
    for other in others {
        assert!(
            matches!(load_model(&path, &fingerprint(&grid, &other)), Err(ModelFileError::Stale)),
            "{other:?}"
        );
    }
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[8] = 77;
    std::fs::write(&path, &bytes).unwrap();
    assert!(matches!(load_model(&path, &print), Err(ModelFileError::Version { found: 77 })));
    std::fs::write(&path, "image: office.png\nresolution: 0.05\n").unwrap();
    assert!(matches!(load_model(&path, &print), Err(ModelFileError::Foreign)));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn places_that_cannot_be_written_or_read_are_errors() {
    let folder = folder("shut");
    let (_, model, print) = small();
    assert!(save_model(&folder.join("nowhere/office.landmark_model"), &model, &print).is_err());
    // Where a folder stands no file can be put, and nothing is left beside it.
    std::fs::create_dir(folder.join("office.landmark_model")).unwrap();
    assert!(save_model(&folder.join("office.landmark_model"), &model, &print).is_err());
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    assert!(load_model(&folder.join("office.landmark_model"), &print).is_err());
    assert!(load_model(&folder.join("none"), &print).is_err());
    std::fs::remove_dir_all(&folder).unwrap();
}
