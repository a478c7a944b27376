//! The published runs in the warehouse: FC-A3 to FC-A7.

use super::scene::{Scene, has_arrived};
use super::warehouse::{goal, grid_of_starts, runs};
use rumbo_core::frames::Point2;
use rumbo_kit::potential::{Obstacles, Piece};
use rumbo_planners::fictitious_charges::{ChargeForceKind, ChargeParams, FictitiousChargesParams};
use rumbo_planners::field_descent::descent::End;
use rumbo_planners::potential_field::PotentialFieldParams;

/// FC-A3.
#[test]
fn plain_descent_is_stuck_from_thirteen_of_sixteen_starts() {
    let (scene, params) = (Scene::warehouse(), PotentialFieldParams::default());
    let mut n_arrived = 0;
    for run in runs() {
        let walk = scene.plain(&params, run.start);
        let end = *walk.points.last().unwrap();
        assert_eq!(has_arrived(&walk), run.plain_arrived, "{}", run.start);
        assert!((end - run.plain_end).norm() < 0.05, "{}: {end} {}", run.start, run.plain_end);
        assert!((walk.length_m - run.plain_length_m).abs() < 0.05, "{}: {}", run.start, walk.length_m);
        if !has_arrived(&walk) {
            assert!(matches!(walk.end, End::Minimum { force } if force < 0.04), "{:?}", walk.end);
            let minima = [Point2::new(20.0, 15.0), Point2::new(20.0, 19.0)];
            assert!(minima.iter().any(|minimum| (end - minimum).norm() < 0.9), "{end}");
        }
        n_arrived += usize::from(has_arrived(&walk));
    }
    assert_eq!(n_arrived, 3);
}

/// FC-A4.
#[test]
fn with_charges_all_sixteen_starts_arrive_as_published() {
    let (scene, params) = (Scene::warehouse(), FictitiousChargesParams::default());
    for run in runs() {
        let walk = scene.charged(&params, run.start);
        assert!(has_arrived(&walk), "{}: {:?}", run.start, walk.end);
        assert!((walk.length_m - run.length_m).abs() < 0.1, "{}: {}", run.start, walk.length_m);
        assert!(
            (walk.clearance_m.min(2.0) - run.clearance_m).abs() < 0.02,
            "{}: {}",
            run.start,
            walk.clearance_m
        );
        assert_eq!(walk.charges.len(), run.charges.len(), "{}", run.start);
        for (found, published) in walk.charges.iter().zip(&run.charges) {
            assert!((found.at - published).norm() < 0.05, "{}: {} {published}", run.start, found.at);
        }
    }
}

/// FC-A4: one whole way, every 25th step.
#[test]
fn the_published_way_is_walked_step_by_step() {
    let walk = Scene::warehouse().charged(&FictitiousChargesParams::default(), Point2::new(18.0, 6.0));
    let text = include_str!("../data/potential/fc_path_S2.csv");
    let mut n_points = 0;
    for line in text.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|word| word.trim().parse().unwrap()).collect();
        let Some(found) = walk.points.get(v[0] as usize) else {
            panic!("step {} of {}", v[0], walk.points.len());
        };
        // Printed with four digits; zigzags amplify differences of rounding.
        assert!((found - Point2::new(v[1], v[2])).norm() < 0.02, "step {}: {found}", v[0]);
        n_points += 1;
    }
    assert!(n_points > 50);
}

/// FC-A5.
#[test]
fn with_charges_all_starts_of_a_grid_arrive() {
    let scene = Scene::warehouse();
    let obstacles = Obstacles::new(&scene.groups, 2.0).unwrap();
    let starts = grid_of_starts();
    assert_eq!(starts.len(), 268);
    let (mut n_plain, mut by_charges) = (0, [0; 4]);
    for start in starts {
        n_plain += usize::from(has_arrived(&scene.plain(&PotentialFieldParams::default(), start)));
        let walk = scene.charged(&FictitiousChargesParams::default(), start);
        assert!(has_arrived(&walk), "{start}: {:?}", walk.end);
        by_charges[walk.charges.len()] += 1;
        if obstacles.clearance_m(start) > 0.9 {
            assert!(walk.clearance_m >= 0.90, "{start}: {}", walk.clearance_m);
        }
    }
    assert_eq!((n_plain, by_charges), (128, [128, 6, 131, 3]));
}

/// FC-A6.
#[test]
fn mirrored_starts_have_mirrored_ways() {
    let scene = Scene::warehouse();
    let mirrored = |p: Point2| Point2::new(40.0 - p.x, p.y);
    let mut other = Scene::warehouse();
    for piece in other.groups.iter_mut().flatten() {
        *piece = Piece::between(mirrored(piece.from), mirrored(piece.to));
    }
    let params = FictitiousChargesParams::default();
    for run in runs().into_iter().filter(|run| run.start.x != goal().x) {
        let (one, two) = (scene.charged(&params, run.start), other.charged(&params, mirrored(run.start)));
        assert_eq!(one.points.len(), two.points.len(), "{}", run.start);
        for (a, b) in one.points.iter().zip(&two.points) {
            assert!((mirrored(*a) - b).norm() < 1e-6, "{}: {a} {b}", run.start);
        }
    }
}

/// FC-A7.
#[test]
fn with_the_printed_force_only_free_starts_arrive() {
    let charge = ChargeParams { force: ChargeForceKind::Printed, ..ChargeParams::default() };
    let params = FictitiousChargesParams { charge, ..FictitiousChargesParams::default() };
    let scene = Scene::warehouse();
    let mut n_arrived = 0;
    for run in runs() {
        let walk = scene.charged(&params, run.start);
        assert_eq!(has_arrived(&walk), run.plain_arrived, "{}: {:?}", run.start, walk.end);
        assert!(!matches!(walk.end, End::GivenUp | End::StartInObstacle), "{:?}", walk.end);
        n_arrived += usize::from(has_arrived(&walk));
    }
    assert_eq!(n_arrived, 3);
}
