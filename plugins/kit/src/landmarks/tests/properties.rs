//! What holds for every scan.

use super::*;
use rumbo_core::frames::wrap_angle;

/// Ranges of all kinds: surfaces, noise, and what is no reading.
fn wild(rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let mut range = 2.0;
    let spread = [0.0, 0.02, 0.3][rng.random_range(0..3)];
    let share = [0.0, 0.05, 0.5][rng.random_range(0..3)];
    (0..rng.random_range(0..400))
        .map(|_| {
            range = (range + spread * normal(rng)).clamp(0.06, 7.9);
            if rng.random::<f64>() < 0.02 {
                range = rng.random_range(0.1..7.9);
            }
            let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 8.0, 1e300, 0.01];
            if rng.random::<f64>() < share { odd[rng.random_range(0..odd.len())] } else { range }
        })
        .collect()
}

fn all_settings() -> [LandmarkSettings; 3] {
    let as_printed = LandmarkSettings { spares_grazed_walls: false, ..with_hough() };
    [LandmarkSettings::default(), with_hough(), as_printed]
}

#[test]
fn landmarks_of_any_scan_are_finite_and_within_reach() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(71);
    for _ in 0..300 {
        let ranges = wild(&mut rng);
        for settings in all_settings() {
            for mark in extract(settings, &half_turn(0.5), &ranges) {
                assert!((0.0..8.0).contains(&mark.distance_m), "{mark:?}");
                assert!((-PI..PI).contains(&mark.bearing_rad), "{mark:?}");
                assert!(mark.extent_m().is_none_or(|p| p.is_finite() && p > 0.0), "{mark:?}");
                assert!(mark.beams[0] <= mark.beams[1] && (mark.beams[1] as usize) < ranges.len());
                if let LandmarkKind::Wall { unit_covariance: [dd, da, aa], .. } = mark.kind {
                    assert!(dd > 0.0 && aa > 0.0 && dd * aa - da * da > -1e-12 * dd * aa, "{mark:?}");
                }
            }
        }
    }
}

#[test]
fn scans_of_nothing_and_of_impossible_shape_have_no_landmarks() {
    for ranges in [vec![], vec![f64::NAN; 50], vec![f64::INFINITY; 50], vec![8.0; 361], vec![1.0]] {
        assert!(extract(LandmarkSettings::default(), &half_turn(0.5), &ranges).is_empty());
    }
    let odd = BeamFan { bearing_step_rad: f64::NAN, ..half_turn(0.5) };
    assert!(extract(LandmarkSettings::default(), &odd, &[1.0; 100]).is_empty());
}

#[test]
fn a_turned_scanner_sees_the_same_landmarks_turned() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(72);
    for _ in 0..100 {
        // Without a ripple, equally far corners of an even arc would be told apart by rounding.
        let ranges: Vec<f64> = wild(&mut rng).into_iter().map(|r| r + 0.002 * rng.random::<f64>()).collect();
        let turn = f64::from(rng.random_range(-200..200)) * 0.5_f64.to_radians();
        let fan = half_turn(0.5);
        let turned = BeamFan { first_bearing_rad: fan.first_bearing_rad + turn, ..fan };
        let (a, b) = (
            extract(LandmarkSettings::default(), &fan, &ranges),
            extract(LandmarkSettings::default(), &turned, &ranges),
        );
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!((a.distance_m - b.distance_m).abs() < 1e-9 && a.letter() == b.letter());
            assert!(wrap_angle(b.bearing_rad - a.bearing_rad - turn).abs() < 1e-7);
        }
    }
}

#[test]
fn readings_that_are_none_at_the_ends_change_nothing() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(73);
    for settings in all_settings() {
        let ranges = wild(&mut rng);
        let mut longer = ranges.clone();
        longer.extend([f64::NAN, f64::INFINITY, 0.0]);
        assert_eq!(extract(settings, &half_turn(0.5), &ranges), extract(settings, &half_turn(0.5), &longer));
    }
}

#[test]
fn a_scan_told_clockwise_has_the_same_landmarks() {
    let fan = half_turn(0.5);
    let mut ranges = scan(&room(0.3), &fan, 361);
    let found = extract(LandmarkSettings::default(), &fan, &ranges);
    ranges.reverse();
    let clockwise = BeamFan { first_bearing_rad: FRAC_PI_2, bearing_step_rad: -fan.bearing_step_rad, ..fan };
    let back = extract(LandmarkSettings::default(), &clockwise, &ranges);
    assert_eq!(found.len(), back.len());
    for (a, b) in found.iter().zip(&back) {
        assert!((a.distance_m - b.distance_m).abs() < 1e-9 && (a.bearing_rad - b.bearing_rad).abs() < 1e-9);
        assert_eq!((a.letter(), a.beams), (b.letter(), b.beams));
    }
}

#[test]
fn a_used_extractor_answers_as_a_new_one_and_its_memory_does_not_grow() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(74);
    for settings in all_settings() {
        let scans: Vec<Vec<f64>> = (0..20).map(|_| wild(&mut rng)).collect();
        let mut extractor = Extractor::new(settings);
        for ranges in &scans {
            extractor.extract(&half_turn(0.5), ranges.iter().copied());
        }
        let before = extractor.capacities();
        for ranges in &scans {
            let found = extractor.extract(&half_turn(0.5), ranges.iter().copied()).to_vec();
            assert_eq!(found, extract(settings, &half_turn(0.5), ranges));
        }
        assert_eq!(extractor.capacities(), before);
    }
}
