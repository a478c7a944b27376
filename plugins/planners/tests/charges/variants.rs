//! The published variants: FC-A8 and section 6.3.

use super::scene::{Scene, has_arrived};
use super::warehouse::{grid_of_starts, runs};
use rumbo_core::frames::Point2;
use rumbo_planners::fictitious_charges::{
    ChargeParams, ChargePlacement, ChargeSide, FictitiousChargesParams,
};
use rumbo_planners::field_descent::{AttractionForm, StepKind};
use rumbo_planners::potential_field::PotentialFieldParams;
use std::ops::RangeInclusive;

fn stuck_starts() -> Vec<Point2> {
    runs().into_iter().filter(|run| !run.plain_arrived).map(|run| run.start).collect()
}

fn with(charge: ChargeParams) -> FictitiousChargesParams {
    FictitiousChargesParams { charge, ..FictitiousChargesParams::default() }
}

fn n_arrived(params: &FictitiousChargesParams, starts: &[Point2]) -> usize {
    let scene = Scene::warehouse();
    starts.iter().filter(|start| has_arrived(&scene.charged(params, **start))).count()
}

fn quadratic(xi: f64, range_m: Option<f64>, goal_capture_m: f64) -> FictitiousChargesParams {
    let charge = ChargeParams { range_m, ..ChargeParams::default() };
    FictitiousChargesParams {
        form: AttractionForm::Quadratic,
        xi,
        goal_capture_m,
        charge,
        ..FictitiousChargesParams::default()
    }
}

/// FC-A8.
#[test]
fn the_quadratic_form_needs_both_additions() {
    let starts: Vec<Point2> = runs().iter().map(|run| run.start).collect();
    assert_eq!(n_arrived(&quadratic(0.05, Some(4.0), 1.0), &starts), 16);
    assert_eq!(n_arrived(&quadratic(0.05, None, 1.0), &starts), 3);
    assert_eq!(n_arrived(&quadratic(0.05, Some(4.0), 0.0), &starts), 0);
}

#[test]
fn the_quadratic_form_of_full_strength_frees_no_stuck_start() {
    let plain = PotentialFieldParams {
        form: AttractionForm::Quadratic,
        goal_capture_m: 1.0,
        ..PotentialFieldParams::default()
    };
    let (scene, charged) = (Scene::warehouse(), quadratic(1.0, None, 1.0));
    let (mut n_plain, mut n_charged) = (0, 0);
    for start in grid_of_starts() {
        let is_free = has_arrived(&scene.plain(&plain, start));
        let is_freed = has_arrived(&scene.charged(&charged, start));
        assert_eq!(is_free, is_freed, "{start}");
        n_plain += usize::from(is_free);
        n_charged += usize::from(is_freed);
    }
    assert_eq!((n_plain, n_charged), (132, 132));
}

#[test]
fn literal_placement_frees_all_stuck_starts() {
    let params = with(ChargeParams { placement: ChargePlacement::Literal, ..ChargeParams::default() });
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    for start in stuck_starts() {
        let walk = Scene::warehouse().charged(&params, start);
        assert!(has_arrived(&walk), "{start}: {:?}", walk.end);
        shortest = shortest.min(walk.length_m);
        longest = longest.max(walk.length_m);
    }
    assert!((shortest - 14.5).abs() < 0.15 && (longest - 42.4).abs() < 0.15, "{shortest} {longest}");
}

#[test]
fn other_distances_and_fixed_sides_free_all_stuck_starts() {
    for distance_m in [0.5, 2.0] {
        assert_eq!(
            n_arrived(&with(ChargeParams { distance_m, ..ChargeParams::default() }), &stuck_starts()),
            13
        );
    }
    for side in [ChargeSide::Left, ChargeSide::Right] {
        assert_eq!(n_arrived(&with(ChargeParams { side, ..ChargeParams::default() }), &stuck_starts()), 13);
    }
}

#[test]
fn random_sides_free_all_stuck_starts_with_more_charges() {
    let params = with(ChargeParams { side: ChargeSide::Random, ..ChargeParams::default() });
    let scene = Scene::warehouse();
    let (mut most_charges, mut n_arrived, mut n_runs) = (0, 0, 0);
    for seed in 0..8 {
        for start in stuck_starts() {
            let walk = scene.charged_by(&params, start, seed);
            n_arrived += usize::from(has_arrived(&walk));
            n_runs += 1;
            most_charges = most_charges.max(walk.charges.len());
        }
    }
    assert!(n_arrived == n_runs, "{n_arrived} of {n_runs}");
    assert!(most_charges > 3, "{most_charges}");
}

#[test]
fn weaker_charges_need_more_of_them() {
    let expected: [(f64, RangeInclusive<usize>); 5] =
        [(1.0, 5..=10), (2.0, 4..=7), (4.0, 3..=3), (16.0, 2..=2), (32.0, 1..=2)];
    for (strength, n_charges) in expected {
        let params = with(ChargeParams { strength, ..ChargeParams::default() });
        for start in stuck_starts().into_iter().take(4) {
            let walk = Scene::warehouse().charged(&params, start);
            assert!(has_arrived(&walk), "{strength} {start}: {:?}", walk.end);
            assert!(n_charges.contains(&walk.charges.len()), "{strength} {start}: {}", walk.charges.len());
        }
    }
}

#[test]
fn other_steps_arrive_where_the_force_of_a_minimum_is_twice_the_step() {
    for step_m in [0.01, 0.05, 0.10] {
        let params = FictitiousChargesParams {
            step_m,
            minimum_force: 2.0 * step_m,
            ..FictitiousChargesParams::default()
        };
        assert_eq!(n_arrived(&params, &stuck_starts()[..4]), 4, "{step_m}");
    }
}

#[test]
fn adaptive_steps_arrive_from_every_start_in_fewer_steps() {
    let adaptive = FictitiousChargesParams { step: StepKind::Adaptive, ..FictitiousChargesParams::default() };
    let scene = Scene::warehouse();
    let (mut n_adaptive, mut n_constant) = (0, 0);
    for run in runs() {
        let walk = scene.charged(&adaptive, run.start);
        assert!(has_arrived(&walk), "{}: {:?}", run.start, walk.end);
        assert!(walk.clearance_m >= 0.80, "{}: {}", run.start, walk.clearance_m);
        assert!(walk.length_m < 1.3 * run.length_m, "{}: {} {}", run.start, walk.length_m, run.length_m);
        n_adaptive += walk.points.len();
        n_constant += scene.charged(&FictitiousChargesParams::default(), run.start).points.len();
    }
    assert!(3 * n_adaptive < n_constant, "{n_adaptive} {n_constant}");
}

/// Charges move the place of rest where the attraction fades, too: with an unlimited range, nine starts arrive.
#[test]
fn the_combined_form_arrives_from_every_start_with_charges_of_limited_range() {
    let combined = |range_m: Option<f64>| FictitiousChargesParams {
        form: AttractionForm::Combined,
        charge: ChargeParams { range_m, ..ChargeParams::default() },
        ..FictitiousChargesParams::default()
    };
    let starts: Vec<Point2> = runs().iter().map(|run| run.start).collect();
    assert_eq!(n_arrived(&combined(Some(4.0)), &starts), 16);
    assert_eq!(n_arrived(&combined(None), &starts), 9);
}
