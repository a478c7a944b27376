//! Derivatives against differences.

use nalgebra::{Matrix4, Vector4};

use super::*;
use crate::gps_imu::motion::{
    State, antenna_by_state, antenna_m, measured_yaw_by_state, measured_yaw_rad, moved, moved_by_state,
    new_errors,
};

const STEP: f64 = 1e-6;

fn states() -> Vec<State> {
    vec![
        Vector4::new(0.0, 0.0, 0.0, 0.0),
        Vector4::new(3.0, -2.0, 2.9, 0.3),
        Vector4::new(-100.0, 50.0, -1.7, -0.2),
    ]
}

/// How `of` changes with each part of the state, by differences, one a column.
fn differences<const N: usize>(
    state: &State,
    of: impl Fn(&State) -> nalgebra::SVector<f64, N>,
) -> nalgebra::SMatrix<f64, N, 4> {
    let mut columns = nalgebra::SMatrix::<f64, N, 4>::zeros();
    for k in 0..4 {
        let mut by = State::zeros();
        by[k] = STEP;
        columns.set_column(k, &((of(&(state + by)) - of(&(state - by))) / (2.0 * STEP)));
    }
    columns
}

#[test]
fn the_derivatives_of_the_motion_and_of_the_measurements_are_those_of_differences() {
    for state in states() {
        for step in [pose2(0.06, 0.0, 0.0), pose2(0.3, -0.1, 0.4), pose2(0.0, 0.0, -1.0)] {
            let expected = differences(&state, |state| moved(state, &step));
            assert!((moved_by_state(&state, &step) - expected).norm() < 1e-8, "{state} {step}");
        }
        for lever_m in [Vector2::zeros(), Vector2::new(0.4, -0.2), Vector2::new(-1.5, 3.0)] {
            let expected = differences(&state, |state| antenna_m(state, &lever_m));
            assert!((antenna_by_state(&state, &lever_m) - expected).norm() < 1e-7, "{state} {lever_m}");
        }
        let expected = differences(&state, |state| nalgebra::Vector1::new(measured_yaw_rad(state)));
        assert!((measured_yaw_by_state() - expected).norm() < 1e-8);
    }
}

/// One step with an error of one deviation in distance, direction or turn, against the covariance of that error alone.
#[test]
fn what_a_step_adds_is_what_its_errors_do() {
    let state = Vector4::new(1.0, 2.0, 0.8, 0.1);
    let (length_m, turn_rad) = (0.5, 0.2);
    let step = pose2(length_m, 0.0, turn_rad);
    let bent = |by_rad: f64| {
        // Half of a heading error that grows on the way acts on the way.
        let direction = nalgebra::Rotation2::new(by_rad / 2.0) * Vector2::new(length_m, 0.0);
        moved(&state, &pose2(direction.x, direction.y, turn_rad + by_rad))
    };
    let small = 1e-5;
    let errors: [(usize, f64, State); 3] = [
        (0, length_m, moved(&state, &pose2(length_m * (1.0 + small), 0.0, turn_rad))),
        (1, length_m, bent(small * length_m)),
        (2, turn_rad, bent(small * turn_rad)),
    ];
    for (which, amount, with_error) in errors {
        let effect = (with_error - moved(&state, &step)) / small;
        let mut noise = [0.0; 3];
        noise[which] = 0.03;
        let expected: Matrix4<f64> = effect * effect.transpose() * 0.03f64.powi(2) / amount;
        let found = new_errors(&state, &step, noise);
        assert!((found - expected).norm() < 1e-5 * expected.norm(), "{which}: {found} {expected}");
    }
}
