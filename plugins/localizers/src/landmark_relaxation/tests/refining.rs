//! Poses beyond the size of a cell, and what keeps wrong ones from being believed.

use super::super::fit::{Fit, FitLimits};
use super::super::matching::is_one;
use super::super::refinement::{RefinementSettings, refine};
use super::super::traced_beams::TracedBeams;
use super::panoramas::both;
use super::*;
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use std::f64::consts::PI;

const SETTINGS: RefinementSettings =
    RefinementSettings { range_deviation_m: 0.015, map_deviation_m: 0.01, turn_deviation: 0.03 };
const LIMITS: FitLimits =
    FitLimits { explained: 0.5, sure: 0.7, sure_matches: 5, through: 0.15, judged: 0.5, alike: 0.05 };

/// From one pose to another: meters, degrees.
fn off(found: &Pose2, truth: &Pose2) -> [f64; 2] {
    let way_m = (found.translation.vector - truth.translation.vector).norm();
    [way_m, wrap_angle(found.rotation.angle() - truth.rotation.angle()).abs().to_degrees()]
}

#[test]
fn exact_beams_lead_back_to_the_exact_pose_also_in_a_turned_map() {
    for origin in [[0.0; 3], [7.0, -2.0, -0.8]] {
        let known = knowledge(&room(origin));
        for mount in [Pose2::identity(), pose2(0.15, -0.1, 0.2)] {
            let truth = known.grid.map_from_grid() * pose2(2.31, 1.73, 0.4);
            let beams = TracedBeams::of(&both(&known, &truth, &mount), 360);
            for (x, y, deg) in [(0.03, -0.03, 3.0), (-0.06, 0.05, -4.0), (0.0, 0.0, 0.0)] {
                let start = truth * pose2(x, y, f64::to_radians(deg));
                let refined = refine(&known, &beams, &start, &SETTINGS);
                let [way_m, turn_deg] = off(&refined.map_from_base, &truth);
                assert!(way_m < 2e-3 && turn_deg < 0.1, "{way_m} m, {turn_deg} degrees");
                let fit = Fit::of(&beams.compare(&known, &refined.map_from_base, &refined.turns_rad));
                assert!(fit.explained() > 0.97 && fit.is_within(&LIMITS), "{fit:?}");
            }
        }
    }
}

#[test]
fn a_turn_that_the_odometer_misjudged_is_found() {
    let known = knowledge(&room([0.0; 3]));
    let truth = pose2(2.31, 1.73, 0.4);
    for error_deg in [4.0, -4.0] {
        let mut sightings = both(&known, &truth, &Pose2::identity());
        sightings[0].odom_from_base *= Pose2::rotation(f64::to_radians(error_deg));
        let beams = TracedBeams::of(&sightings, 360);
        let refined = refine(&known, &beams, &(truth * pose2(0.03, 0.02, 0.02)), &SETTINGS);
        let [way_m, turn_deg] = off(&refined.map_from_base, &truth);
        assert!(way_m < 3e-3 && turn_deg < 0.1, "{way_m} m, {turn_deg} degrees");
        let found_deg = refined.turns_rad[0].to_degrees();
        assert!((found_deg + error_deg).abs() < 0.3, "{found_deg}");
        assert_eq!(refined.turns_rad[1], 0.0);
    }
}

#[test]
fn steps_are_those_of_the_gradient_by_finite_differences() {
    // Near the truth all weights are about one: the mean of the squares must have its minimum where refinement ends.
    let known = knowledge(&room([0.0; 3]));
    let truth = pose2(2.31, 1.73, 0.4);
    let mut sightings = both(&known, &truth, &Pose2::identity());
    for (idx, range) in sightings.iter_mut().flat_map(|s| &mut s.ranges_m).enumerate() {
        *range += 0.01 * (idx as f64 * 12.9898).sin();
    }
    let beams = TracedBeams::of(&sightings, 360);
    let refined = refine(&known, &beams, &truth, &SETTINGS);
    let cost = |pose: &Pose2| -> f64 {
        let comparisons = beams.compare(&known, pose, &refined.turns_rad);
        let squares = comparisons.iter().filter_map(|c| {
            let super::super::sighting::Beam::Hit(range_m) = c.beam else { return None };
            let [nx, ny] = c.normal?;
            let off_m = (range_m - c.expected_m) * (nx * c.direction[0] + ny * c.direction[1]);
            (off_m.abs() < 0.1).then_some((1.0 - (1.0 - (off_m / 0.1).powi(2)).powi(3)) / 6.0)
        });
        squares.sum()
    };
    let least = cost(&refined.map_from_base);
    for (x, y, turn) in [(0.02, 0.0, 0.0), (0.0, 0.02, 0.0), (0.0, 0.0, 0.01)] {
        for side in [1.0, -1.0] {
            let beside = refined.map_from_base * pose2(side * x, side * y, side * turn);
            assert!(cost(&beside) > least, "{x} {y} {turn} {side}");
        }
    }
}

#[test]
fn a_place_with_the_wrong_heading_or_elsewhere_does_not_fit() {
    let known = knowledge(&room([0.0; 3]));
    let truth = pose2(2.31, 1.73, 0.4);
    let beams = TracedBeams::of(&both(&known, &truth, &Pose2::identity()), 360);
    for wrong in [pose2(2.31, 1.73, 0.4 + PI), pose2(1.2, 1.0, 0.4), pose2(4.0, 2.0, -1.0)] {
        let refined = refine(&known, &beams, &wrong, &SETTINGS);
        let fit = Fit::of(&beams.compare(&known, &refined.map_from_base, &refined.turns_rad));
        let is_back = is_one(&refined.map_from_base, &truth);
        assert!(is_back || !fit.is_within(&LIMITS), "{wrong}: {fit:?}");
    }
}

#[test]
fn without_readings_a_pose_stays_as_unsure_as_it_was_and_is_not_believed() {
    let known = knowledge(&room([0.0; 3]));
    let pose = pose2(2.31, 1.73, 0.4);
    let mut sightings = both(&known, &pose, &Pose2::identity());
    for silent in [f64::NAN, f64::INFINITY] {
        sightings.iter_mut().for_each(|sighting| sighting.ranges_m.fill(silent));
        let beams = TracedBeams::of(&sightings, 360);
        let refined = refine(&known, &beams, &pose, &SETTINGS);
        assert!(off(&refined.map_from_base, &pose)[0] < 1e-12);
        assert!((refined.covariance[(0, 0)] - 0.01).abs() < 1e-9);
        let fit = Fit::of(&beams.compare(&known, &pose, &refined.turns_rad));
        assert!(!fit.is_within(&LIMITS), "{fit:?}");
    }
    let nothing = refine(&known, &TracedBeams::of(&[], 360), &pose, &SETTINGS);
    assert!(nothing.turns_rad.is_empty() && nothing.covariance.iter().all(|part| part.is_finite()));
}

#[test]
fn a_scan_in_what_nobody_knows_is_not_judged() {
    let mut grid = room([0.0; 3]);
    let truth = pose2(2.31, 1.73, 0.4);
    let seen = both(&knowledge(&grid), &truth, &Pose2::identity());
    // All but a piece of one wall was never seen.
    for (idx, cell) in grid.cells.make_mut().iter_mut().enumerate() {
        if *cell > 0.0 && !(idx < 102 && idx > 40 && idx < 60) {
            *cell = 0.0;
        }
    }
    let known = knowledge(&grid);
    let beams = TracedBeams::of(&seen, 360);
    let fit = Fit::of(&beams.compare(&known, &truth, &[0.0; 2]));
    assert!(fit.n_judged > 10 && fit.explained() > 0.9 && !fit.is_within(&LIMITS), "{fit:?}");
}
