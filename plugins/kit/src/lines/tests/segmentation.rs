//! Breaks, splits, merging, circles, and scans that no device should give.

use super::circle;
use crate::lines::{BeamFan, LineExtractor, LineSettings, SensedLine};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::wrap_angle;

/// Ranges in a rectangular room around the robot, walls `[east, north, west, south]`, beams from `first_rad` on.
fn room(walls_m: [f64; 4], first_rad: f64, step_rad: f64, n: usize) -> Vec<f64> {
    let range = |k: usize| {
        let (sin, cos) = (first_rad + step_rad * k as f64).sin_cos();
        let across = if cos > 0.0 { walls_m[0] / cos } else { -walls_m[2] / cos };
        let along = if sin > 0.0 { walls_m[1] / sin } else { -walls_m[3] / sin };
        across.abs().min(along.abs())
    };
    (0..n).map(range).collect()
}

fn lines(fan: &BeamFan, ranges_m: &[f64]) -> Vec<SensedLine> {
    LineExtractor::new(LineSettings::default()).extract(fan, ranges_m.iter().copied()).to_vec()
}

#[test]
fn a_closed_room_has_its_four_walls_wherever_the_circle_begins() {
    for first_deg in [-180.0, -170.0, -97.5, -45.0, 0.0, 33.0] {
        let fan = BeamFan { first_bearing_rad: f64::to_radians(first_deg), ..circle() };
        for n in [720, 721] {
            let ranges = room([4.0, 3.0, 5.0, 2.0], fan.first_bearing_rad, fan.bearing_step_rad, n);
            let found = lines(&fan, &ranges);
            assert_eq!(found.len(), 4, "{first_deg}: {found:?}");
            for line in &found {
                let wall =
                    [4.0, 3.0, 5.0, 2.0].into_iter().any(|wall_m| (line.distance_m - wall_m).abs() < 1e-9);
                assert!(wall, "{line:?}");
                assert!(line.n_points > 80, "a wall is not cut where the circle begins: {line:?}");
            }
        }
    }
}

#[test]
fn a_clockwise_scan_has_the_same_lines() {
    let fan = BeamFan { first_bearing_rad: -2.0, max_range_m: 30.0, ..circle() };
    let ranges = room([4.0, 3.0, 5.0, 2.0], -2.0, fan.bearing_step_rad, 450);
    let forward = lines(&fan, &ranges);
    let last = fan.first_bearing_rad + 449.0 * fan.bearing_step_rad;
    let back = BeamFan { first_bearing_rad: last, bearing_step_rad: -fan.bearing_step_rad, ..fan };
    let mut reversed = lines(&back, &ranges.iter().rev().copied().collect::<Vec<_>>());
    reversed.reverse();
    assert_eq!(forward.len(), reversed.len());
    for (one, other) in forward.iter().zip(&reversed) {
        assert!((one.distance_m - other.distance_m).abs() < 1e-9 && one.n_points == other.n_points);
        assert!(
            (one.ends_m[0][0] - other.ends_m[0][0]).abs() < 1e-9,
            "ends stay right and left: {one:?} {other:?}"
        );
    }
}

#[test]
fn a_jump_of_the_range_and_a_beam_without_return_part_a_wall() {
    let fan = BeamFan { first_bearing_rad: -1.0, max_range_m: 30.0, ..circle() };
    let wall = room([4.0, 30.0, 30.0, 30.0], -1.0, fan.bearing_step_rad, 229);
    assert_eq!(lines(&fan, &wall).len(), 1);
    let mut jump = wall.clone();
    jump[100..].iter_mut().for_each(|range| *range *= 0.9);
    let found = lines(&fan, &jump);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(found[0].n_points, 98, "one reading less at each end");
    // 0.5 degrees at 4 m: 2.1 m are a break, 0.2 m are none but split.
    for none in [f64::INFINITY, f64::NAN, 0.0, -1.0, 31.0] {
        let mut holes = wall.clone();
        // A board in front of the wall, between two beams that say nothing.
        holes[100] = none;
        holes[129] = none;
        holes[101..129].iter_mut().for_each(|range| *range -= 0.6);
        assert_eq!(lines(&fan, &holes).len(), 3, "{none}");
    }
}

#[test]
fn a_bend_splits_and_small_pieces_are_dropped() {
    let fan = BeamFan { first_bearing_rad: -1.0, max_range_m: 30.0, ..circle() };
    // A corner at (4, 1).
    let mut corner = room([4.0, 1.0, 9.0, 9.0], -1.0, fan.bearing_step_rad, 229);
    let found = lines(&fan, &corner);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!((found[0].normal_rad).abs() < 1e-9 && (found[1].distance_m - 1.0).abs() < 1e-9);
    // Eleven readings of it alone: nine without the ends.
    let n = corner.len();
    corner[11..n].iter_mut().for_each(|range| *range = f64::NAN);
    assert!(lines(&fan, &corner).is_empty());
}

#[test]
fn a_wall_that_chance_has_split_is_merged_again() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let fan = BeamFan { first_bearing_rad: -1.0, max_range_m: 30.0, ..circle() };
    let exact = room([4.0, 30.0, 30.0, 30.0], -1.0, fan.bearing_step_rad, 229);
    let mut n_whole = 0;
    for _ in 0..50 {
        // Uniform within 3 cm: residuals stay below the limit, distances from a chord between two bad ends do not.
        let noisy: Vec<f64> = exact.iter().map(|range| range + rng.random_range(-0.045..0.045)).collect();
        let strict = LineSettings { split_m: 0.08, ..LineSettings::default() };
        let mut extractor = LineExtractor::new(strict);
        n_whole += usize::from(extractor.extract(&fan, noisy.into_iter()).len() == 1);
    }
    assert_eq!(n_whole, 50);
}

#[test]
fn a_spiral_is_split_without_recursion() {
    // No piece of it is straight, and its splits are lopsided.
    let n = 4000;
    let fan = BeamFan { first_bearing_rad: 0.0, bearing_step_rad: 1e-3, min_range_m: 0.0, max_range_m: 1e9 };
    let spiral: Vec<f64> = (0..n).map(|k| 1.0 + 1e-3 * f64::from(k)).collect();
    for line in lines(&fan, &spiral) {
        assert!(line.n_points < 1000);
    }
}

#[test]
fn scans_that_no_device_should_give_have_no_lines() {
    let scans = [
        vec![],
        vec![1.0],
        vec![f64::INFINITY; 720],
        vec![f64::NAN; 720],
        vec![-1.0; 720],
        vec![1e30; 720],
        vec![0.0; 720],
    ];
    for scan in &scans {
        assert!(lines(&circle(), scan).is_empty(), "{:?}", scan.first());
        let far = BeamFan { max_range_m: f64::INFINITY, ..circle() };
        for line in lines(&far, scan) {
            assert!(line.distance_m.is_finite());
        }
    }
    let nowhere = BeamFan { bearing_step_rad: f64::NAN, ..circle() };
    assert!(lines(&nowhere, &[1.0; 720]).is_empty());
    let still = BeamFan { bearing_step_rad: 0.0, ..circle() };
    assert!(lines(&still, &[1.0; 720]).is_empty(), "all beams look the same way");
    let coarse = BeamFan { bearing_step_rad: 0.3, ..circle() };
    assert!(lines(&coarse, &room([4.0, 3.0, 5.0, 2.0], -3.1, 0.3, 21)).len() <= 4);
}

#[test]
fn random_scans_give_sane_lines() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    let mut extractor = LineExtractor::new(LineSettings::default());
    for _ in 0..300 {
        let n = rng.random_range(0..800);
        let scale = rng.random_range(0.1..20.0);
        let scan: Vec<f64> = (0..n)
            .map(|k| if rng.random_bool(0.01) { f64::NAN } else { scale + 0.3 * f64::from(k / 40).sin() })
            .collect();
        for line in extractor.extract(&circle(), scan.into_iter()) {
            let [rho2, both, phi2] = line.covariance;
            assert!(rho2 > 0.0 && phi2 > 0.0 && both * both < rho2 * phi2, "{line:?}");
            assert!(line.distance_m >= 0.0 && line.n_points >= 10 && line.rms_m <= 0.045, "{line:?}");
            assert!(wrap_angle(line.normal_rad).abs() <= std::f64::consts::PI);
            for [x, y] in line.ends_m {
                let off = x * line.normal_rad.cos() + y * line.normal_rad.sin() - line.distance_m;
                assert!(off.abs() < 1e-9, "ends are on the line");
            }
        }
    }
}
