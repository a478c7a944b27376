use super::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A small log with every message.
fn small_log() -> String {
    let ranges = vec!["99"; 180].join(" ");
    let robot =
        "ROBOTLASER1 0 -1.5 3.0 0.01 50.0 0.1 0 3 1 60 2 3 7 8 9 1 2 0.1 3 4 0.2 0.3 -0.4 0 0 0 4.5 x 700\n";
    format!(
        "PARAM a b c 0\n{}{}VERTEX2 1 2 3 0.1\n{robot}EDGE2 0 1 1.5 0.5 0.1 1 0 1 2 0 0\nO 1 2 0.5 5.125\n\
         L 1 2 0.5 1 2 0.5 {ranges} 5.25\n{}",
        odom(0.0, 1.0),
        flaser(8, "1.5"),
        odom(1.0, 6.0)
    )
}

#[test]
fn a_log_cut_at_any_byte_is_read_up_to_the_cut() {
    let text = small_log();
    let (whole, ..) = read(text.as_bytes());
    let first_line = text.find('\n').unwrap();
    for cut in first_line + 1..text.len() {
        let (records, faults, tally) = read(&text.as_bytes()[..cut]);
        let n_whole_lines = text[..cut].matches('\n').count();
        assert_eq!(records[..n_whole_lines], whole[..n_whole_lines], "cut at {cut}");
        assert_eq!(faults, [], "cut at {cut}");
        let is_between_lines = text[..cut].ends_with('\n');
        let is_half = records.len() == n_whole_lines && !is_between_lines;
        let damage = tally.damage;
        assert_eq!(damage.is_some(), is_half, "cut at {cut}: {damage:?}");
        if let Some(damage) = damage {
            assert!(damage.is_truncated && damage.line == n_whole_lines as u64 + 1, "cut at {cut}: {damage}");
        }
        // Half a line that still is one says the same but for its last words.
        if records.len() > n_whole_lines {
            let stamp = |record: &LogRecord| match &record.told {
                Told::Scan(scan) => Some(scan.stamp),
                Told::Odometry(odometry) => Some(odometry.stamp),
                _ => None,
            };
            let (half, full) = (&records[n_whole_lines], &whole[n_whole_lines]);
            assert_eq!((half.line, stamp(half)), (full.line, stamp(full)), "cut at {cut}");
        }
    }
}

#[test]
fn a_gzip_stream_cut_at_any_byte_is_read_up_to_the_cut_and_the_cut_is_told() {
    let text: String = (0..400).map(|k| flaser(11 + k % 7, &format!("{k}.{k}"))).collect();
    let (whole, ..) = read(text.as_bytes());
    let packed = gzip(text.as_bytes());
    let mut n_before = 0;
    for cut in 3..packed.len() {
        let file = TempFile::new(&packed[..cut]);
        let Ok(mut reader) = LogReader::open(&file.0, BeamOverride::default()) else {
            assert!(n_before == 0, "cut at {cut}");
            continue;
        };
        let records: Vec<LogRecord> = reader.by_ref().filter_map(Result::ok).collect();
        let n = records.len();
        assert!(n >= n_before && n <= whole.len(), "cut at {cut}");
        let sure = n.saturating_sub(1);
        assert_eq!(records[..sure], whole[..sure], "cut at {cut}");
        let damage = reader.tally().damage.clone().unwrap();
        assert!(damage.is_truncated && damage.line >= n as u64, "cut at {cut}: {damage}");
        assert!(damage.to_string().contains("the gzip stream ends early"), "{damage}");
        n_before = n;
    }
    assert!(n_before >= whole.len() - 1, "{n_before}");
}

#[test]
fn flipped_bits_never_panic_and_cost_no_more_than_their_lines() {
    let text = small_log().into_bytes();
    let (n_whole, packed) = (read(&text).0.len(), gzip(&text));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for round in 0..1000 {
        let mut bytes = if round % 4 == 0 { packed.clone() } else { text.clone() };
        let n_flips = rng.random_range(1..4);
        for _ in 0..n_flips {
            let at = rng.random_range(0..bytes.len());
            bytes[at] ^= 1 << rng.random_range(0..8);
        }
        let file = TempFile::new(&bytes);
        let Ok(reader) = LogReader::open(&file.0, BeamOverride::default()) else { continue };
        let n = reader.filter_map(Result::ok).count();
        // A line can be lost or cut in two; line ends can be lost, too.
        assert!(round % 4 == 0 || n + 2 * n_flips >= n_whole, "round {round}: {n} of {n_whole}");
        if let Ok(timeline) = Timeline::open(&file.0, BeamOverride::default()) {
            let stamps: Vec<_> = timeline.map(|moment| moment.stamp).collect();
            assert!(stamps.is_sorted(), "round {round}");
        }
        let _ = read_poses(&file.0);
    }
}

#[test]
fn a_changed_gzip_stream_is_told_as_damage() {
    let text: String = (0..3000).map(|k| flaser(20, &format!("{k}.5"))).collect();
    let mut packed = gzip(text.as_bytes());
    let middle = packed.len() - 3;
    packed[middle] ^= 0x55;
    let (records, _, tally) = read(&packed);
    assert_eq!(records.len(), 3000, "the check sum stands at the end");
    assert!(!tally.damage.unwrap().is_truncated);
}
