//! The pose together with errors of the odometer and of the map.

use super::super::dead_reckoning::Way;
use super::super::joint::Joint;
use super::super::landmark_errors::LandmarkErrors;
use super::super::mapped_marks::{MappedMark, MappedMarks};
use super::super::sighting::{Sighting, offset_variances};
use super::*;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector2, Vector3};
use rumbo_core::frames::{Point2, wrap_angle};
use std::f64::consts::PI;

const ERRORS: LandmarkErrors = LandmarkErrors { range_m: 0.015, map_m: 0.0144, map_rad: 0.0035 };
const MOUNT: [f64; 3] = [0.2, -0.1, 0.3];

fn mount() -> Pose2 {
    pose2(MOUNT[0], MOUNT[1], MOUNT[2])
}

fn variances(x: f64, y: f64, yaw: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(x * x, y * y, yaw * yaw))
}

/// Sightings from `truth` of the surroundings as the map has them from `believed`, whose places are registered.
fn sightings(joint: &mut Joint, believed: &Pose2, truth: &Pose2, scan: u64) -> Vec<Sighting> {
    let map_from_a = believed * mount();
    let a_from_b = map_from_a.inverse() * truth * mount();
    let known = surroundings().into_iter().map(|mark| predicted(&mark, &map_from_a));
    known
        .map(|known| {
            let relation = Relation { known, seen: predicted(&known, &a_from_b), off_m: 0.0 };
            let [x, y] = known.position();
            let ends = [[x - 0.5 * y, y + 0.5 * x], [x + 0.5 * y, y - 0.5 * x]];
            let mapped = MappedMark::of(&known, ends, &map_from_a);
            let (slot, pivot) = joint.slot_of(mapped, scan, &ERRORS);
            Sighting::new(&relation, mapped, pivot, slot, &ERRORS)
        })
        .collect()
}

fn vector(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

#[test]
fn changes_of_what_is_expected_are_those_of_finite_differences() {
    let pose = pose2(0.3, 0.2, 0.4);
    let mut joint = Joint::new(&pose, &variances(0.1, 0.1, 0.1));
    let all = sightings(&mut joint, &pose, &pose2(0.32, 0.17, 0.43), 1);
    for sighting in &all {
        let (at, offset) = (vector(&pose), Vector2::new(0.013, -0.008));
        let found = sighting.residual(&at, &offset, &mount());
        let step = 1e-6;
        let expected_at =
            |pose: Vector3<f64>, offset: Vector2<f64>| -sighting.residual(&pose, &offset, &mount()).off;
        for k in 0..3 {
            let moved = Vector3::ith(k, step);
            let change = (expected_at(at + moved, offset) - expected_at(at - moved, offset)) / (2.0 * step);
            assert!((change - found.by_pose.column(k)).norm() < 1e-6, "{k} {change} {found:?}");
        }
        for k in 0..2 {
            let moved = Vector2::ith(k, step);
            let change = (expected_at(at, offset + moved) - expected_at(at, offset - moved)) / (2.0 * step);
            assert!((change - found.by_offset.column(k)).norm() < 1e-6, "{k} {change} {found:?}");
        }
    }
}

#[test]
fn errors_of_a_way_are_those_of_finite_differences_and_of_a_bent_way_in_many_steps() {
    let (start, way) = (pose2(1.0, -2.0, 0.7), pose2(0.4, 0.02, 0.1));
    let along = (start.rotation * way.translation.vector).xy();
    let told = Way { along, turn_rad: 0.1 };
    let step = 1e-6;
    for k in 0..3 {
        let moved = |by: f64| {
            let at = vector(&start) + Vector3::ith(k, by);
            vector(&(pose2(at.x, at.y, at.z) * way))
        };
        let change = (moved(step) - moved(-step)) / (2.0 * step);
        assert!((change - told.by_pose().column(k)).norm() < 1e-8, "{k}: {change}");
    }
    // A straight way of which the odometer does not see that it bends by 0.01 radians a meter.
    let (bend, n) = (0.01, 10_000);
    let mut bent = start;
    for _ in 0..n {
        bent *= pose2(0.4 / f64::from(n), 0.0, bend * 0.4 / f64::from(n));
    }
    let straight = Way { along: (start.rotation * Vector2::new(0.4, 0.0)).xy(), turn_rad: 0.0 };
    let expected =
        vector(&(start * pose2(0.4, 0.0, 0.0))) + straight.by_errors() * Vector3::new(0.0, bend, 0.0);
    assert!((vector(&bent) - expected).norm() < 1e-5, "{bent} {expected}");
}

/// The same estimate in another form: Gauss and Newton on the sum of squares of prior and sightings.
fn by_information(
    sightings: &[Sighting],
    start: &Pose2,
    covariance: &Matrix3<f64>,
    n: usize,
) -> (Vector3<f64>, Matrix3<f64>) {
    let prior_of = |mapped: &MappedMark| offset_variances(mapped, &ERRORS).map(|v| 1.0 / v);
    let mut prior = DMatrix::zeros(3 + 2 * n, 3 + 2 * n);
    prior.fixed_view_mut::<3, 3>(0, 0).copy_from(&covariance.try_inverse().unwrap());
    for sighting in sightings {
        let at = 3 + 2 * sighting.slot.unwrap();
        prior.fixed_view_mut::<2, 2>(at, at).copy_from(&Matrix2::from_diagonal(&prior_of(&sighting.mapped)));
    }
    let begin = vector(start);
    let mut state = DVector::zeros(3 + 2 * n);
    state.fixed_rows_mut::<3>(0).copy_from(&begin);
    let first = state.clone();
    let mut information = prior.clone();
    for _ in 0..20 {
        information = prior.clone();
        let mut pull = &prior * (&first - &state);
        for sighting in sightings {
            let at = 3 + 2 * sighting.slot.unwrap();
            let offset = state.fixed_rows::<2>(at).into_owned();
            let residual = sighting.residual(&state.fixed_rows::<3>(0).into_owned(), &offset, &mount());
            let mut row = DMatrix::zeros(2, 3 + 2 * n);
            row.fixed_view_mut::<2, 3>(0, 0).copy_from(&residual.by_pose);
            row.fixed_view_mut::<2, 2>(0, at).copy_from(&residual.by_offset);
            let inverse = sighting.covariance.try_inverse().unwrap();
            information += row.transpose() * inverse * &row;
            pull += row.transpose() * inverse * residual.off;
        }
        state += information.clone().try_inverse().unwrap() * pull;
    }
    let covariance = information.try_inverse().unwrap().fixed_view::<3, 3>(0, 0).into_owned();
    (state.fixed_rows::<3>(0).into_owned(), covariance)
}

#[test]
fn the_estimate_is_the_one_in_information_form() {
    let (believed, truth) = (pose2(0.0, 0.0, 0.1), pose2(0.01, -0.015, 0.105));
    let covariance = variances(0.02, 0.03, 0.01);
    let mut joint = Joint::new(&believed, &covariance);
    let all = sightings(&mut joint, &believed, &truth, 1);
    let posterior = joint.posterior(&all, &vector(&believed), &mount()).unwrap();
    assert_eq!(posterior.n_possible, all.len());
    let (pose, expected) = by_information(&all, &believed, &covariance, joint.marks().all().len());
    assert!((posterior.pose() - pose).norm() < 1e-9, "{} {pose}", posterior.pose());
    joint.accept(posterior);
    assert!((joint.pose_covariance() - expected).norm() < 1e-9 * expected.norm(), "{expected}");
}

#[test]
fn exact_landmarks_give_the_exact_pose_also_through_an_outlier() {
    for truth in [pose2(0.05, 0.04, 0.03), pose2(-0.05, 0.02, -0.04)] {
        let believed = pose2(0.0, 0.0, 0.0);
        let mut joint = Joint::new(&believed, &variances(10.0, 10.0, 1.0));
        let mut all = sightings(&mut joint, &believed, &truth, 1);
        let mut start = vector(&believed);
        for _ in 0..3 {
            start = joint.posterior(&all, &start, &mount()).unwrap().pose();
        }
        assert!((start - vector(&truth)).norm() < 1e-5, "{start}");
        let mut joint = Joint::new(&believed, &variances(0.1, 0.1, 0.05));
        all = sightings(&mut joint, &believed, &truth, 1);
        all.last_mut().unwrap().seen.distance_m += 0.25;
        let robust = joint.posterior(&all, &vector(&believed), &mount()).unwrap().pose();
        assert!((robust - vector(&truth)).xy().norm() < 0.015, "{robust}");
    }
}

#[test]
fn a_map_that_is_off_does_not_get_better_by_looking_at_it_again() {
    let truth = pose2(0.0, 0.0, 0.0);
    let mut joint = Joint::new(&truth, &variances(0.3, 0.3, 0.1));
    let mut deviations = Vec::new();
    for scan in 1..=200 {
        let all = sightings(&mut joint, &truth, &truth, scan);
        let posterior = joint.posterior(&all, &vector(&joint.map_from_base()), &mount()).unwrap();
        joint.accept(posterior);
        deviations.push(joint.pose_covariance().diagonal().map(f64::sqrt));
    }
    assert_eq!(joint.marks().all().len(), surroundings().len(), "every place is known again");
    // Three walls and four points, each off by 1.44 cm: with three and four to a direction no better than half of that.
    let last = deviations[199];
    assert!(last.x > 0.0144 / 3.0 && last.y > 0.0144 / 3.0 && last.x < 0.0144, "{last}");
    assert!((deviations[199] - deviations[99]).norm() < 0.02 * last.norm(), "{} {last}", deviations[99]);
}

#[test]
fn parallel_walls_help_across_them_only() {
    let start = pose2(0.0, 0.0, 0.0);
    let mut joint = Joint::new(&start, &variances(0.2, 0.2, 0.05));
    let all: Vec<Sighting> = [wall(1.0, 90.0), wall(1.0, -90.0)]
        .into_iter()
        .map(|known| {
            let relation = Relation { known, seen: known, off_m: 0.0 };
            let side = known.bearing_rad.sin();
            let mapped = MappedMark::of(&known, [[-2.0, side], [2.0, side]], &start);
            let (slot, pivot) = joint.slot_of(mapped, 1, &ERRORS);
            Sighting::new(&relation, mapped, pivot, slot, &ERRORS)
        })
        .collect();
    let posterior = joint.posterior(&all, &Vector3::zeros(), &Pose2::identity()).unwrap();
    joint.accept(posterior);
    let [x, y, yaw] = [0, 1, 2].map(|k| joint.pose_covariance()[(k, k)].sqrt());
    assert!((x - 0.2).abs() < 1e-9 && y < 0.0144 && yaw < 0.005, "{x} {y} {yaw}");
}

#[test]
fn errors_of_the_odometer_that_stay_are_learned() {
    let noise = [0.05, 0.05, 0.05];
    let mut joint = Joint::new(&Pose2::identity(), &variances(0.005, 0.005, 0.002));
    let (seen, truth_step) = (pose2(0.1, 0.0, 0.0), pose2(0.104, 0.0, 0.003));
    let mut truth = Pose2::identity();
    for scan in 1..=20 {
        truth *= truth_step;
        joint.carry(&seen, noise);
        let believed = joint.map_from_base();
        let all = sightings(&mut joint, &believed, &truth, scan);
        let posterior = joint.posterior(&all, &vector(&believed), &mount()).unwrap();
        joint.accept(posterior);
    }
    // A meter in the dark, for which the odometer alone would be 4 cm and 2 degrees off.
    let (mut far, mut told) = (truth, Pose2::identity());
    for _ in 0..10 {
        far *= truth_step;
        told *= seen;
    }
    let (found, covariance) = joint.carried(&told, noise);
    let off = vector(&found) - vector(&far);
    let off = Vector3::new(off.x, off.y, wrap_angle(off.z));
    assert!(off.xy().norm() < 0.02 && off.z.abs() < 0.01, "{off}");
    let nees = off.dot(&(covariance.try_inverse().unwrap() * off));
    assert!(nees < 9.0, "{nees}");
    // Looking ahead and going there are the same.
    joint.carry(&told, noise);
    assert!((joint.pose_covariance() - covariance).norm() < 1e-15);
    assert!((vector(&joint.map_from_base()) - vector(&found)).norm() < 1e-12);
}

#[test]
fn a_wall_goes_on_much_as_it_was_and_the_next_is_unknown() {
    let start = pose2(0.0, 0.0, 0.0);
    let mut joint = Joint::new(&start, &variances(1e-4, 1e-4, 1e-5));
    let piece = |x: f64, side: f64| MappedMark {
        is_wall: true,
        place: Point2::new(x, side),
        normal_rad: side.signum() * PI / 2.0,
        reach_m: 3.5,
    };
    // The pose is known, and the wall to the left is 1 cm farther than the map has it.
    let (known, seen) = (wall(1.0, 90.0), wall(1.01, 90.0));
    let (slot, pivot) = joint.slot_of(piece(0.0, 1.0), 1, &ERRORS);
    let sighting =
        Sighting::new(&Relation { known, seen, off_m: 0.0 }, piece(0.0, 1.0), pivot, slot, &ERRORS);
    let mut posterior = None;
    for _ in 0..30 {
        let found = joint.posterior(&[sighting], &Vector3::zeros(), &Pose2::identity()).unwrap();
        joint.accept(found.clone());
        posterior = Some(found);
    }
    assert_eq!(posterior.unwrap().n_possible, 1);
    let beside = joint.slot_of(piece(6.9, 1.0), 2, &ERRORS).0.unwrap();
    let across = joint.slot_of(piece(0.0, -1.0), 2, &ERRORS).0.unwrap();
    let offset = |joint: &Joint, idx: usize| joint.marks().all()[idx].offset.x;
    assert!((offset(&joint, beside) - 0.0095).abs() < 5e-4, "{}", offset(&joint, beside));
    assert_eq!(offset(&joint, across), 0.0);
    let deviation = |joint: &Joint, idx: usize| joint.offset_variance(idx).sqrt();
    assert!(deviation(&joint, beside) < 0.4 * ERRORS.map_m, "{}", deviation(&joint, beside));
    assert!((deviation(&joint, across) - ERRORS.map_m).abs() < 1e-12);
}

#[test]
fn places_are_known_again_and_the_oldest_make_room() {
    let mut marks = MappedMarks::default();
    let point = |k: usize| MappedMark {
        is_wall: false,
        place: Point2::new(k as f64, 0.0),
        normal_rad: 0.0,
        reach_m: 0.02,
    };
    use super::super::mapped_marks::Slot;
    for k in 0..MappedMarks::MOST {
        assert_eq!(marks.find_or_add(point(k), k as u64), Slot::Added(k));
    }
    let near = MappedMark { place: Point2::new(3.05, 0.0), ..point(0) };
    assert_eq!(marks.find_or_add(near, 100), Slot::Known(3));
    assert_eq!(marks.find_or_add(point(500), 100), Slot::Replaced(0));
    assert_eq!(marks.find_or_add(point(501), 100), Slot::Replaced(1));
    assert_eq!(marks.find_or_add(point(502), 100), Slot::Replaced(2));
    assert_eq!(marks.find_or_add(point(503), 100), Slot::Replaced(4), "3 was seen just now");
    let mut full = MappedMarks::default();
    (0..MappedMarks::MOST).for_each(|k| assert_eq!(full.find_or_add(point(k), 7), Slot::Added(k)));
    assert_eq!(full.find_or_add(point(500), 7), Slot::Full);
}

#[test]
fn pieces_of_one_wall_are_one_place_and_the_next_wall_is_another() {
    let mut marks = MappedMarks::default();
    let wall = |along: f64, across: f64, turn: f64| MappedMark {
        is_wall: true,
        place: Point2::new(2.0 + across, along),
        normal_rad: turn,
        reach_m: 0.5,
    };
    use super::super::mapped_marks::Slot;
    assert_eq!(marks.find_or_add(wall(0.0, 0.0, 0.0), 1), Slot::Added(0));
    assert_eq!(marks.find_or_add(wall(1.1, 0.01, 0.02), 1), Slot::Known(0), "goes on");
    assert_eq!(marks.find_or_add(wall(2.2, 0.0, 0.0), 1), Slot::Known(0), "and on");
    assert_eq!(marks.find_or_add(wall(5.5, 0.0, 0.0), 1), Slot::Added(1), "beyond a door");
    assert_eq!(marks.find_or_add(wall(0.0, 0.05, 0.0), 1), Slot::Added(2), "a cell behind");
    assert_eq!(marks.find_or_add(wall(0.0, 0.0, PI), 1), Slot::Added(3), "its other side");
}
