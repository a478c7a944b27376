//! FC-A10 and FC-A12: what is no map, no goal, no number; the same bytes for the same input.

use super::queries::{map, request};
use rumbo_core::frames::Point2;
use rumbo_core::map::{Line, Lines, Map};
use rumbo_core::messages::{Obstacle, Path};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, PlanError, PlanRequest};
use rumbo_core::time::Time;
use rumbo_planners::fictitious_charges::{ChargeParams, ChargeSide, FictitiousChargesParams};
use rumbo_planners::field_descent::MapSource;
use rumbo_planners::potential_field::PotentialFieldParams;

fn on_lines() -> FictitiousChargesParams {
    FictitiousChargesParams { map: MapSource::Lines, ..FictitiousChargesParams::default() }
}

fn plan(request: &PlanRequest) -> Result<Path, PlanError> {
    on_lines().build(&BuildContext::bare("planner")).unwrap().plan(request)
}

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

fn lines(lines: Vec<Line>) -> Map {
    Map { lines: Some(Lines { lines: lines.into() }), ..Map::default() }
}

#[test]
fn goals_and_starts_on_a_line_are_named() {
    let on_goal = plan(&request(&map(), p(2.0, 2.0), p(20.0, 16.0)));
    assert!(matches!(on_goal, Err(PlanError::GoalOccupied { .. })), "{on_goal:?}");
    let on_start = plan(&request(&map(), p(20.0, 16.0), p(20.0, 25.0)));
    assert!(matches!(on_start, Err(PlanError::StartOccupied { .. })), "{on_start:?}");
}

#[test]
fn an_empty_map_has_a_straight_path_and_no_map_is_named() {
    let path = plan(&request(&lines(Vec::new()), p(2.0, 2.0), p(20.0, 16.0))).unwrap();
    assert_eq!(path.points().len(), 2);
    assert_eq!((path.points()[0].position, path.end().position), (p(2.0, 2.0), p(20.0, 16.0)));
    let no_map = plan(&request(&Map::default(), p(2.0, 2.0), p(20.0, 16.0)));
    assert!(matches!(no_map, Err(PlanError::MissingLayer { layer: "lines" })), "{no_map:?}");
}

#[test]
fn a_line_that_is_not_finite_is_named() {
    let wrong = Line { from: [1.0, f64::NAN], to: [2.0, 2.0], ..Line::default() };
    let answer = plan(&request(&lines(vec![wrong]), p(2.0, 2.0), p(20.0, 16.0)));
    assert_eq!(answer, Err(PlanError::NotFinite { what: "a line of the map" }));
    let mut request = request(&map(), p(2.0, 2.0), p(20.0, 16.5));
    request.goal.position.x = f64::NAN;
    assert_eq!(plan(&request), Err(PlanError::NotFinite { what: "the goal's position" }));
}

#[test]
fn goals_that_are_pushed_away_are_told_with_the_distance_that_they_need() {
    // 0.8 m from the north wall: the balance is at 1 m.
    let asked = request(&map(), p(2.0, 2.0), p(12.0, 29.2));
    let published = FictitiousChargesParams { attempts: 1, ..on_lines() };
    let answer = published.build(&BuildContext::bare("planner")).unwrap().plan(&asked);
    let Err(PlanError::GoalTooClose { found_m, needed_m, .. }) = answer else { panic!("{answer:?}") };
    assert!((found_m - 0.8).abs() < 1e-9 && (needed_m - 1.0).abs() < 1e-6, "{found_m} {needed_m}");
    // Smaller walks get there, and nearer, but not nearer than the clearance.
    plan(&asked).unwrap();
    plan(&request(&map(), p(2.0, 2.0), p(12.0, 29.69))).unwrap();
    let answer = plan(&request(&map(), p(2.0, 2.0), p(12.0, 29.75)));
    let Err(PlanError::GoalTooClose { needed_m, .. }) = answer else { panic!("{answer:?}") };
    assert!((needed_m - 0.3).abs() < 1e-9, "{needed_m}");
}

/// 100,000 lines around the way of a robot.
#[test]
fn a_hundred_thousand_lines_are_planned_through() {
    let line = |k: u32| {
        let (col, row) = (f64::from(k % 400), f64::from(k / 400));
        let from = [3.0 * col - 600.0, 3.0 * row + 1.6];
        Line { from, to: [from[0] + 0.02, from[1]], ..Line::default() }
    };
    let map = lines((0..100_000).map(line).collect());
    let params = FictitiousChargesParams { eta: 0.05, influence_distance_m: 1.0, ..on_lines() };
    let mut planner = params.build(&BuildContext::bare("planner")).unwrap();
    let path = planner.plan(&request(&map, p(0.0, 0.0), p(31.5, 30.0))).unwrap();
    assert!(path.length_m() < 46.0, "{}", path.length_m());
}

/// FC-A12.
#[test]
fn the_same_input_gives_the_same_bytes_and_chance_comes_from_the_seed() {
    let request = request(&map(), p(20.0, 4.0), p(20.0, 25.0));
    let charge = ChargeParams { side: ChargeSide::Random, ..ChargeParams::default() };
    let params = FictitiousChargesParams { charge, straighten: false, ..on_lines() };
    let plan = |seed: u64| {
        let context = BuildContext { seed, ..BuildContext::bare("planner") };
        let mut planner = params.build(&context).unwrap();
        let first = planner.plan(&request).unwrap();
        // Asked again, the same planner draws the same sides.
        assert_eq!(planner.plan(&request).unwrap(), first);
        first
    };
    let lengths: Vec<u64> = (0..12).map(|seed| plan(seed).length_m().to_bits()).collect();
    let again: Vec<u64> = (0..12).map(|seed| plan(seed).length_m().to_bits()).collect();
    assert_eq!(lengths, again);
    assert!(lengths.iter().any(|length| *length != lengths[0]));
}

/// Section 7, item 7: what was found on the way counts, and charges do not outlive their plan.
#[test]
fn obstacles_found_on_the_way_are_driven_around() {
    let mut planner = on_lines().build(&BuildContext::bare("planner")).unwrap();
    let mut request = request(&map(), p(12.5, 4.0), p(12.5, 25.0));
    let free = planner.plan(&request).unwrap();
    request.obstacles.push(Obstacle { position: p(12.6, 12.0), radius_m: 0.4, stamp: Time::ZERO });
    let around = planner.plan(&request).unwrap();
    let distance_m = |path: &Path| {
        let legs = path.points().windows(2);
        let nearest = |leg: &[rumbo_core::messages::PathPoint]| {
            (0..=1000)
                .map(|k| leg[0].position + (leg[1].position - leg[0].position) * (f64::from(k) / 1000.0))
                .map(|at| (at - p(12.6, 12.0)).norm() - 0.4)
                .fold(f64::INFINITY, f64::min)
        };
        legs.map(nearest).fold(f64::INFINITY, f64::min)
    };
    assert!(distance_m(&free) < 0.0 && distance_m(&around) >= 0.3 - 1e-3, "{}", distance_m(&around));
    request.obstacles.clear();
    assert_eq!(planner.plan(&request).unwrap(), free);
}

#[test]
fn failures_say_where_and_list_the_charges() {
    let plain = PotentialFieldParams { map: MapSource::Lines, ..PotentialFieldParams::default() };
    let mut planner = plain.build(&BuildContext::bare("planner")).unwrap();
    let request = request(&map(), p(20.0, 4.0), p(20.0, 25.0));
    let answer = planner.plan(&request);
    let Err(PlanError::Stuck { place, reason }) = answer else { panic!("{answer:?}") };
    assert!((place - p(20.0, 15.0)).norm() < 0.05 && reason.contains("local minimum"), "{place} {reason}");
    let mut planner = FictitiousChargesParams { max_charges: 1, attempts: 1, ..on_lines() }
        .build(&BuildContext::bare("planner"))
        .unwrap();
    let answer = planner.plan(&request);
    let Err(PlanError::Stuck { reason, .. }) = answer else { panic!("{answer:?}") };
    assert!(reason.contains("max_charges = 1") && reason.contains("(20.71, 15.69)"), "{reason}");
    let mut planner = FictitiousChargesParams { max_steps: 100, attempts: 3, ..on_lines() }
        .build(&BuildContext::bare("planner"))
        .unwrap();
    let answer = planner.plan(&request);
    let Err(PlanError::Stuck { reason, .. }) = answer else { panic!("{answer:?}") };
    assert!(reason.contains("max_steps = 100") && reason.contains("none of 3 attempts"), "{reason}");
}

#[test]
fn a_search_that_nobody_waits_for_is_given_up() {
    let request = request(&map(), p(20.0, 4.0), p(20.0, 25.0));
    request.give_up.raise();
    assert_eq!(plan(&request), Err(PlanError::GivenUp));
}
