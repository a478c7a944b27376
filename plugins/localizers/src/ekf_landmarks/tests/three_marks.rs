//! Fixes from three marks or more.

use super::super::fix::locate;
use super::*;

const DEVIATIONS: [f64; 2] = [0.05, 0.01];

fn sightings(
    truth: &Pose2,
    marks: &[KnownMark],
    deviations: [f64; 2],
    rng: &mut Rng,
) -> Vec<(Sighting, KnownMark)> {
    let camera = pose2(0.1, 0.02, -0.4);
    marks.iter().map(|mark| (seen(truth, &camera, mark, deviations, rng), *mark)).collect()
}

fn off(found: &Pose2, truth: &Pose2) -> Vector3<f64> {
    let way = found.translation.vector - truth.translation.vector;
    Vector3::new(way.x, way.y, wrap_angle(found.rotation.angle() - truth.rotation.angle()))
}

#[test]
fn exact_sightings_give_the_exact_pose_wherever_the_robot_looks() {
    let (mut rng, marks) = (rng::stream(31, "fix"), [mark(3.0, 1.0), mark(-2.0, 4.0), mark(0.5, -3.0)]);
    for k in 0..32 {
        let truth = pose2(0.3, 0.2, wrap_angle(f64::from(k) * 0.2));
        let mut seen = sightings(&truth, &marks, [0.0; 2], &mut rng);
        for (sighting, _) in &mut seen {
            sighting.noise = Matrix2::from_diagonal(&Vector2::new(0.0025, 0.0001));
        }
        assert!(off(&locate(&seen).unwrap().map_from_base, &truth).amax() < 1e-9, "{k}");
    }
}

#[test]
fn errors_of_fixes_are_as_large_as_they_say() {
    let (mut rng, marks) =
        (rng::stream(32, "fix"), [mark(3.0, 1.0), mark(2.0, 4.0), mark(5.5, -3.0), mark(4.0, 2.0)]);
    let truth = pose2(0.3, 0.2, 2.0);
    let (mut sum, mut n_none) = (0.0, 0);
    for _ in 0..2000 {
        match locate(&sightings(&truth, &marks, DEVIATIONS, &mut rng)) {
            Some(fix) => {
                let error = off(&fix.map_from_base, &truth);
                sum += error.dot(&(fix.covariance.try_inverse().unwrap() * error));
            }
            None => n_none += 1,
        }
    }
    let mean = sum / f64::from(2000 - n_none);
    assert!((2.7..3.3).contains(&mean) && n_none <= 10, "{mean}, {n_none} without a fix");
}

#[test]
fn two_marks_marks_in_one_place_and_contradictions_are_no_fix() {
    let mut rng = rng::stream(33, "fix");
    let truth = pose2(0.3, 0.2, 2.0);
    let marks = [mark(3.0, 1.0), mark(2.0, 4.0), mark(5.5, -3.0)];
    assert!(locate(&sightings(&truth, &marks[..2], DEVIATIONS, &mut rng)).is_none());
    assert!(locate(&sightings(&truth, &[marks[0]; 3], [1e-12; 2], &mut rng)).is_none());
    let mut mixed_up = sightings(&truth, &marks, DEVIATIONS, &mut rng);
    assert!(locate(&mixed_up).is_some());
    (mixed_up[0].1, mixed_up[1].1) = (mixed_up[1].1, mixed_up[0].1);
    assert!(locate(&mixed_up).is_none());
}
