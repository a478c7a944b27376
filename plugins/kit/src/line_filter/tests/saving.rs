//! A saved filter goes on to the bit, and damage is named.

use super::{seen, sure};
use crate::line_filter::*;
use rumbo_core::time::Time;

fn grown() -> LineFilter {
    let (robot, covariance) = sure();
    let mut filter = LineFilter::building(FilterSettings::default(), robot, &covariance);
    for k in 0..4 {
        filter.predict(0.1);
        filter.read_wheels([0.01, 0.012]);
        let lines = [
            seen(5.0, 0.0, [-2.0, 2.0]),
            seen(4.0, 2.0, [-1.0, 1.5]),
            seen(6.0, -2.0 + f64::from(k), [0.0, 1.0]),
        ];
        filter.read_lines(&lines, &Mount::default());
    }
    assert!(filter.walls().len() >= 2);
    filter
}

fn saved() -> SavedFilter {
    SavedFilter {
        start: Time(5),
        now: Some(Time(700)),
        odom_from_base: [1.0, -2.0, 0.5],
        odometry_stamp: Some(Time(650)),
        filter: grown(),
    }
}

#[test]
fn a_saved_filter_goes_on_as_if_nothing_had_been() {
    let saved = saved();
    let bytes = saved.to_bytes();
    let mut back = SavedFilter::from_bytes(&bytes, FilterSettings::default()).unwrap();
    assert_eq!((back.start, back.now), (saved.start, saved.now));
    assert_eq!((back.odom_from_base, back.odometry_stamp), (saved.odom_from_base, saved.odometry_stamp));
    assert_eq!(back.filter.state(), saved.filter.state());
    assert_eq!(back.to_bytes(), bytes);
    let mut filter = saved.filter;
    for filter in [&mut filter, &mut back.filter] {
        filter.predict(0.1);
        filter.read_lines(&[seen(5.0, 0.0, [-2.0, 2.0]), seen(6.0, 0.9, [0.0, 1.0])], &Mount::default());
    }
    assert_eq!(back.filter.state(), filter.state());
    assert_eq!(back.filter.layer(), filter.layer());
}

fn fault(bytes: &[u8]) -> SavedFault {
    SavedFilter::from_bytes(bytes, FilterSettings::default()).unwrap_err()
}

/// The same bytes with a right check sum.
fn summed(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let sum = crc32fast::hash(&bytes[..body]);
    bytes[body..].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn every_damage_is_refused() {
    let bytes = saved().to_bytes();
    assert_eq!(fault(b""), SavedFault::Foreign);
    assert_eq!(fault(b"something else"), SavedFault::Foreign);
    for cut in [9, 12, 15, 100, bytes.len() / 2, bytes.len() - 1] {
        assert_eq!(fault(&bytes[..cut]), SavedFault::Damaged, "{cut}");
    }
    for at in (12..bytes.len()).step_by(7) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 0x10;
        assert_eq!(fault(&flipped), SavedFault::Damaged, "{at}");
    }
    let mut newer = bytes.clone();
    newer[8] = 3;
    assert_eq!(fault(&summed(newer)), SavedFault::Version { found: 3 });
    let mut longer = bytes.clone();
    longer.extend([0; 8]);
    assert_eq!(fault(&summed(longer)), SavedFault::Damaged);
    // Numbers of walls that nobody has room for.
    let mut huge = bytes.clone();
    huge[84..92].copy_from_slice(&i64::MAX.to_le_bytes());
    assert_eq!(fault(&summed(huge)), SavedFault::Damaged);
}

#[test]
fn whole_bytes_with_impossible_numbers_are_refused() {
    let mut saved = saved();
    saved.filter.state.robot[0] = f64::NAN;
    assert!(matches!(fault(&saved.to_bytes()), SavedFault::Impossible { .. }));
    let mut saved = self::saved();
    saved.filter.state.covariance.view_mut()[(6, 6)] = -1.0;
    assert!(matches!(fault(&saved.to_bytes()), SavedFault::Impossible { .. }));
}
