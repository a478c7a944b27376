//! Against the numbers of the specification, a slow twin in double precision, and finite differences.

mod scenes;
mod shapes;
mod surfaces;
mod twin;
mod vectors;

use super::*;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2};
use scenes::Scene;
use twin::Twin;

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    let scale = expected.abs().max(1.0);
    assert!((found - expected).abs() <= tolerance * scale, "{what}: {found}, expected {expected}");
}

#[test]
fn the_fast_sums_are_those_of_the_slow_twin_also_on_a_turned_level_far_from_the_origin() {
    for (origin, n_points) in [([0.0, 0.0, 0.0], 361), ([-3.0, 2.0, 0.7], 37), ([900.0, -700.0, -2.0], 16)] {
        let scene = Scene::random(11, origin, n_points);
        let level = scene.level();
        let twin = Twin::of(&scene);
        let map_from_level = level.level_from_map().inverse();
        for k in 0..40 {
            let t = f64::from(k);
            let level_from_base = pose2(0.3 + 0.11 * t, 4.0 - 0.1 * t, 0.37 * t);
            let pose = map_from_level * level_from_base;
            let (fast, slow) =
                (linearize(&level, &scene.points, &pose), twin.linearize(&scene.points, &pose));
            assert!(fast.n_used.abs_diff(slow.n_used) <= 1, "{fast:?} {slow:?}");
            if fast.n_used != slow.n_used {
                continue;
            }
            assert_eq!(fast.n_known, slow.n_known);
            let (size, length) = (slow.hessian.amax(), slow.descent.amax());
            assert!((fast.hessian - slow.hessian).amax() < 3e-4 * size, "{} {}", fast.hessian, slow.hessian);
            assert!((fast.descent - slow.descent).amax() < 1e-3 * length + 1e-3 * size.sqrt());
            close(fast.cost, slow.cost, 1e-4, "cost");
            close(fast.shortfall, slow.shortfall, 1e-4, "shortfall");
            close(fast.weight, slow.weight, 1e-6, "weight");
        }
    }
}

#[test]
fn the_descent_is_minus_half_the_gradient_of_the_sum_of_squares() {
    let scene = Scene::random(5, [0.0; 3], 120);
    let twin = Twin::of(&scene);
    let pose = pose2(2.1, 1.9, 0.4);
    let middle = twin.linearize(&scene.points, &pose);
    for axis in 0..3 {
        let mut step = Vector3::zeros();
        step[axis] = 1e-7;
        let at = |sign: f64| {
            let step = step * sign;
            let moved = pose2(2.1 + step.x, 1.9 + step.y, 0.4 + step.z);
            twin.linearize(&scene.points, &moved).cost
        };
        let slope = (at(1.0) - at(-1.0)) / 2e-7;
        close(slope, -2.0 * middle.descent[axis], 1e-3, "slope");
    }
}

#[test]
fn points_beside_the_level_or_that_are_no_numbers_add_nothing() {
    let mut scene = Scene::random(3, [0.0; 3], 40);
    let pose = pose2(2.0, 2.0, 0.0);
    let before = linearize(&scene.level(), &scene.points, &pose);
    for (x, y) in [(1e6, 0.0), (-50.0, 3.0), (3e38, -3e38), (f32::NAN, 0.0), (0.0, f32::INFINITY)] {
        scene.points.push(x, y, 1.0);
    }
    scene.points.push(0.0, 0.0, f32::NAN);
    assert_eq!(scene.points.len(), 43);
    let after = linearize(&scene.level(), &scene.points, &pose);
    assert_eq!(before.n_used, after.n_used);
    assert!((after.cost - before.cost).abs() < 1e-4 && after.hessian.iter().all(|v| v.is_finite()));
    let nowhere = linearize(&scene.level(), &scene.points, &pose2(1e5, 0.0, 0.0));
    assert_eq!((nowhere.n_used, nowhere.mean_cost()), (0, 1.0));
}

#[test]
fn a_match_finds_the_pose_that_the_scan_was_made_from() {
    let room = Scene::room(0.05);
    for k in 0..20 {
        let t = f64::from(k) * 0.3;
        let truth = pose2(0.4 * t.cos(), 0.3 * t.sin(), t);
        let points = room.seen_from(&truth, 361);
        let start = truth * pose2(0.1 * (3.0 * t).sin(), 0.1 * t.cos(), 0.05 * (2.0 * t).cos());
        let found = match_scan(&[room.level()], &points, &start, None, &MatchSettings::default()).unwrap();
        let error = truth.inverse() * found.map_from_base;
        assert!(error.translation.vector.norm() < 0.012, "{t}: {error}");
        assert!(error.rotation.angle().abs() < 0.006, "{t}: {error}");
        assert!(found.end.mean_cost() < found.start.mean_cost());
        assert_eq!(MatchGate::default().judge(&found, &start), MatchStatus::Ok);
        let deviations = found.covariance.diagonal().map(f64::sqrt);
        assert!(deviations.x > 0.004 && deviations.x < 0.03 && deviations.z < 0.02, "{deviations}");
    }
}

#[test]
fn along_a_corridor_the_pose_stays_the_priors_and_the_covariance_says_so() {
    let corridor = Scene::corridor(0.05);
    let truth = pose2(0.0, 0.1, 0.05);
    let points = corridor.seen_from(&truth, 181);
    let prior = PosePrior {
        map_from_base: pose2(0.3, 0.05, 0.02),
        information: Matrix3::from_diagonal(&Vector3::new(100.0, 100.0, 400.0)),
        residual_variance: 0.15,
    };
    for prior in [None, Some(&prior)] {
        let start = pose2(0.3, 0.05, 0.02);
        let found =
            match_scan(&[corridor.level()], &points, &start, prior, &MatchSettings::default()).unwrap();
        assert_eq!(found.seen.blind_axes(), BlindAxes { x: true, y: false, yaw: false });
        assert!((found.map_from_base.translation.x - 0.3).abs() < 0.01, "{}", found.map_from_base);
        assert!((found.map_from_base.translation.y - 0.1).abs() < 0.02, "{}", found.map_from_base);
        assert_eq!(MatchGate::default().judge(&found, &start), MatchStatus::Degenerate);
        assert!(found.covariance[(0, 0)] > 0.9 && found.covariance[(1, 1)] < 0.001, "{}", found.covariance);
        assert!(found.seen.blind_deviation_m(&Matrix3::identity()) > 0.99);
    }
}

#[test]
fn the_sampled_covariance_is_finite_symmetric_and_positive() {
    let room = Scene::room(0.05);
    let points = room.seen_from(&pose2(0.1, 0.2, 0.3), 181);
    let settings = CovarianceSettings { rule: CovarianceRule::Sampled, ..CovarianceSettings::default() };
    let (mean, covariance) = settings.sampled(&room.level(), &points, &pose2(0.1, 0.2, 0.3));
    assert!((mean.translation.x - 0.1).abs() < 0.02 && covariance == covariance.transpose());
    assert!(covariance.cholesky().is_some());
}

#[test]
fn what_is_not_to_be_believed_is_said() {
    let room = Scene::room(0.05);
    let truth = Pose2::identity();
    let points = room.seen_from(&truth, 181);
    let gate = MatchGate::default();
    let settings = MatchSettings::default();
    let run = |points: &ScanPoints, start: &Pose2| {
        let found = match_scan(&[room.level()], points, start, None, &settings).unwrap();
        gate.judge(&found, start)
    };
    assert_eq!(run(&room.seen_from(&truth, 20), &truth), MatchStatus::TooFewPoints);
    assert_eq!(run(&ScanPoints::default(), &truth), MatchStatus::TooFewPoints);
    assert_eq!(run(&points, &pose2(100.0, 0.0, 0.0)), MatchStatus::LowOverlap);
    let found = match_scan(&[room.level()], &points, &truth, None, &settings).unwrap();
    assert_eq!(gate.judge(&found, &pose2(0.6, 0.0, 0.0)), MatchStatus::Diverged);
    assert_eq!(gate.judge(&found, &pose2(0.0, 0.0, 0.4)), MatchStatus::Diverged);
    let strict = MatchGate { max_mean_cost: 1e-6, ..gate };
    assert_eq!(strict.judge(&found, &truth), MatchStatus::Diverged);
    assert!(match_scan::<GridLevel<'_>>(&[], &points, &truth, None, &settings).is_none());
}

#[test]
fn new_ground_is_no_misfit() {
    let mut scene = Scene::room(0.1);
    let pose = pose2(0.3, -0.4, 0.2);
    let mut points = scene.seen_from(&pose, 200);
    for row in 0..scene.size.height {
        for col in 104..scene.size.width {
            let idx = scene.size.index(col, row);
            scene.cells[idx] = 0.0;
        }
    }
    let known = linearize(&scene.level(), &points, &pose);
    assert_eq!(known.n_known, known.n_used);
    close(known.known_cost(), known.mean_cost(), 1e-9, "all is known");
    for k in 0..100 {
        let beyond = pose.inverse() * rumbo_core::frames::Point2::new(5.0, -4.0 + 0.08 * f64::from(k));
        points.push(beyond.x as f32, beyond.y as f32, 1.0);
    }
    let both = linearize(&scene.level(), &points, &pose);
    assert_eq!((both.n_used - known.n_used, both.n_known), (100, known.n_known));
    close(both.known_cost(), known.known_cost(), 1e-5, "with new ground");
    assert!(both.mean_cost() > known.mean_cost() + 0.02, "{} {}", both.mean_cost(), known.mean_cost());
    assert_eq!(linearize(&scene.level(), &ScanPoints::default(), &pose).known_cost(), 1.0);
}

#[test]
fn a_good_start_needs_fewer_levels() {
    let scenes = [0.05, 0.1, 0.2].map(Scene::room);
    let levels: Vec<GridLevel<'_>> = scenes.iter().map(Scene::level).collect();
    for (reach_m, n) in [(0.0, 1), (0.05, 1), (0.06, 2), (0.1, 2), (0.15, 3), (0.3, 3), (f64::INFINITY, 3)] {
        assert_eq!(levels_within(&levels, reach_m).len(), n, "{reach_m} m");
    }
    assert!(levels_within::<GridLevel<'_>>(&[], 1.0).is_empty());
}
