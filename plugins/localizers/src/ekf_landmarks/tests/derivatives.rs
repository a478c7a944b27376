//! Jacobians against central differences.

use super::*;

const STEP: f64 = 1e-6;

#[test]
fn what_is_expected_of_a_mark_changes_as_differences_say() {
    let mut rng = rng::stream(11, "jacobians");
    for _ in 0..500 {
        let mut number = |most: f64| rng.random_range(-most..most);
        let (pose, camera) =
            (pose2(number(5.0), number(5.0), number(3.1)), pose2(number(0.5), number(0.5), number(3.1)));
        let at = Point2::new(number(5.0), number(5.0));
        let of = |dx: f64, dy: f64, dyaw: f64, mx: f64, my: f64| {
            let Pose2 { translation, rotation } = pose;
            let moved = pose2(translation.x + dx, translation.y + dy, rotation.angle() + dyaw);
            expect(&moved, &camera, &Point2::new(at.x + mx, at.y + my)).unwrap().expected
        };
        let here = expect(&pose, &camera, &at).unwrap();
        if here.expected.x < 0.2 {
            continue;
        }
        let slope = |plus: Vector2<f64>, minus: Vector2<f64>| {
            Vector2::new(plus.x - minus.x, wrap_angle(plus.y - minus.y)) / (2.0 * STEP)
        };
        for axis in 0..5 {
            let d = |k: usize, sign: f64| if k == axis { sign * STEP } else { 0.0 };
            let side = |s: f64| of(d(0, s), d(1, s), d(2, s), d(3, s), d(4, s));
            let numeric = slope(side(1.0), side(-1.0));
            let analytic = if axis < 3 {
                here.by_pose.column(axis).into_owned()
            } else {
                here.by_mark.column(axis - 3).into_owned()
            };
            assert!((numeric - analytic).amax() < 1e-6, "axis {axis}: {numeric} {analytic}");
        }
    }
}

#[test]
fn a_way_of_the_odometer_changes_as_differences_say() {
    let mut rng = rng::stream(12, "jacobians");
    for _ in 0..500 {
        let mut number = |most: f64| rng.random_range(-most..most);
        let state = State::new(number(5.0), number(5.0), number(3.1), number(0.2), number(0.2));
        let step = pose2(number(0.5), number(0.2), number(1.0));
        let analytic = motion::by_state(&state, &step);
        for axis in 0..motion::N_STATES {
            let mut d = State::zeros();
            d[axis] = STEP;
            let (plus, minus) = (motion::moved(&(state + d), &step), motion::moved(&(state - d), &step));
            let numeric = (plus - minus) / (2.0 * STEP);
            assert!((numeric - analytic.column(axis)).amax() < 1e-8, "axis {axis}");
        }
    }
}

#[test]
fn a_robot_whose_wheels_are_larger_goes_farther_on_the_same_arc() {
    // An odometer that counts 10 % too little of way and turn alike sees a smaller copy of the same arc.
    let (way_m, turn_rad) = (2.0, 0.8);
    let told = rumbo_core::frames::Twist::new(way_m / 1.1, turn_rad / 1.1).integrate(1.0);
    let there = motion::pose_of(&motion::moved(&State::new(0.0, 0.0, 0.0, 0.1, 0.1), &told));
    let truth = rumbo_core::frames::Twist::new(way_m, turn_rad).integrate(1.0);
    // The chord of an arc is shorter than the arc, a little more so the more it bends.
    assert!((there.translation.vector - truth.translation.vector).norm() < 0.011);
    assert!((there.rotation.angle() - turn_rad).abs() < 1e-12);
    let direction = |pose: &Pose2| pose.translation.y.atan2(pose.translation.x);
    assert!((direction(&there) - direction(&truth)).abs() < 1e-12);
}
