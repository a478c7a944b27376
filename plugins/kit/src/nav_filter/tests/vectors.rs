//! The specification's vectors, and derivatives by differences.

use super::*;
use model::{ACCEL_BIAS, GYRO_BIAS, carried};

const STATES: &str = include_str!("../../../tests/data/slam2d_nav_state_propagation.json");
const UPDATES: &str = include_str!("../../../tests/data/slam2d_nav_filter_updates.json");
const FRAMES: &str = include_str!("../../../tests/data/slam2d_frames.json");

fn euler(x: &[f64]) -> EulerState {
    let part = |at: usize| Vector3::new(x[at], x[at + 1], x[at + 2]);
    EulerState { angles_rad: part(0), position_m: part(3), velocity_m_s: part(6) }
}

fn nine(state: &EulerState) -> SVector<f64, 9> {
    let mut x = SVector::<f64, 9>::zeros();
    x.fixed_rows_mut::<3>(0).copy_from(&state.angles_rad);
    x.fixed_rows_mut::<3>(3).copy_from(&state.position_m);
    x.fixed_rows_mut::<3>(6).copy_from(&state.velocity_m_s);
    x
}

fn sample_of(case: &Value) -> (ImuSample, f64) {
    let sample = ImuSample {
        rates_rad_s: vector3(&case["omega_body"]),
        forces_m_s2: vector3(&case["accel_body_specific_force"]),
    };
    (sample, case["dt"].as_f64().unwrap())
}

fn apart(found: &SVector<f64, 9>, expected: &SVector<f64, 9>) -> f64 {
    let off = found - expected;
    (0..9).map(|k| if k < 3 { wrap_angle(off[k]).abs() } else { off[k].abs() }).fold(0.0, f64::max)
}

#[test]
fn the_source_s_equations_step_as_specified() {
    let cases = json(STATES);
    for case in cases["cases"].as_array().unwrap() {
        let (sample, dt) = sample_of(case);
        let before = euler(&numbers(&case["state_rpy_p_v"]));
        let next = before.propagate(&sample, dt).unwrap();
        let expected = SVector::<f64, 9>::from_vec(numbers(&case["next_second_order"]));
        assert!(apart(&nine(&next), &expected) < 1e-10, "{case}");
        let rotation: SMatrix<f64, 3, 3> = fixed(&case["R_body_to_nav"]);
        assert!((before.nav_from_body() - rotation).amax() < 1e-10);
        let rates: SMatrix<f64, 3, 3> = fixed(&case["E"]);
        assert!((before.angle_rates().unwrap() - rates).amax() < 1e-10);
    }
}

#[test]
fn the_quaternion_form_turns_as_specified_and_moves_alike() {
    let cases = json(STATES);
    for case in cases["cases"].as_array().unwrap() {
        let (sample, dt) = sample_of(case);
        let before = euler(&numbers(&case["state_rpy_p_v"]));
        let [roll, pitch, yaw] = before.angles_rad.into();
        let state = NavState {
            nav_from_body: UnitQuaternion::from_euler_angles(roll, pitch, yaw),
            position_m: before.position_m,
            velocity_m_s: before.velocity_m_s,
            ..NavState::default()
        };
        let next = propagate(&state, &sample, dt);
        let xyzw = numbers(&case["attitude_quaternion_xyzw_after_exponential_map"]);
        let sign = if xyzw[3] * next.nav_from_body.w < 0.0 { -1.0 } else { 1.0 };
        for (found, expected) in next.nav_from_body.coords.iter().zip(&xyzw) {
            assert!((found * sign - expected).abs() < 1e-10, "{case}");
        }
        let expected = numbers(&case["next_second_order"]);
        let moved = next.position_m.iter().chain(next.velocity_m_s.iter());
        assert!(moved.zip(&expected[3..]).all(|(found, expected)| (found - expected).abs() < 1e-10));
        // The exact solution with constant inputs is near: the rest is of second order in the step.
        let exact = numbers(&case["ode_reference_next"]);
        let moved = next.position_m.iter().chain(next.velocity_m_s.iter());
        assert!(moved.zip(&exact[3..]).all(|(found, exact)| (found - exact).abs() < 30.0 * dt * dt));
    }
}

#[test]
fn what_the_specification_refuses_is_refused() {
    let steep = EulerState {
        angles_rad: Vector3::new(0.0, std::f64::consts::FRAC_PI_2, 0.0),
        position_m: Vector3::zeros(),
        velocity_m_s: Vector3::zeros(),
    };
    assert!(steep.propagate(&ImuSample::default(), 0.01).is_err());
    let none = EulerState { angles_rad: Vector3::new(0.0, f64::NAN, 0.0), ..steep };
    assert!(none.angle_rates().is_err());
    let state = NavState { velocity_m_s: Vector3::x(), ..NavState::default() };
    assert_eq!(propagate(&state, &at_rest(&state.nav_from_body), 0.0), state);
}

/// Errors before and after, by small changes of every state.
#[test]
fn the_jacobian_is_that_of_the_step() {
    let state = NavState {
        nav_from_body: UnitQuaternion::from_euler_angles(0.4, -1.0, 2.0),
        position_m: Vector3::new(1.0, 2.0, 3.0),
        velocity_m_s: Vector3::new(0.5, -0.4, 0.3),
        gyro_bias_rad_s: Vector3::new(0.01, -0.02, 0.03),
        accel_bias_m_s2: Vector3::new(0.1, 0.2, -0.1),
    };
    for (rate, dt) in [(0.3, 0.01), (2.0, 0.1), (1e-5, 0.005)] {
        let sample = ImuSample {
            rates_rad_s: Vector3::new(rate, -rate, 2.0 * rate),
            forces_m_s2: Vector3::new(1.0, -2.0, 9.0),
        };
        let (f, next) = (jacobian(&state, &sample, dt), propagate(&state, &sample, dt));
        let step = 1e-6;
        for col in 0..15 {
            let mut errors = SVector::<f64, 15>::zeros();
            errors[col] = step;
            let plus = next.minus(&propagate(&state.plus(&errors), &sample, dt));
            let minus = next.minus(&propagate(&state.plus(&-errors), &sample, dt));
            let column = (plus - minus) / (2.0 * step);
            assert!((column - f.column(col)).amax() < 1e-8, "column {col} at {dt} s");
        }
    }
}

#[test]
fn noise_and_covariance_grow_as_specified() {
    let updates = json(UPDATES);
    let given = &updates["propagation"];
    let before = euler(&numbers(&updates["prior"]["x"]));
    let number = |key: &str| given[key].as_f64().unwrap();
    let (gyro, accel, dt) = (number("gyro_noise_rad_s"), number("accel_noise_m_s2"), number("dt"));
    let gain = before.noise_gain(dt).unwrap();
    assert!((gain - fixed::<9, 6>(&given["G_noise"])).amax() < 1e-9);
    let mut variances = SMatrix::<f64, 6, 6>::zeros();
    (0..3).for_each(|k| variances[(k, k)] = gyro * gyro);
    (3..6).for_each(|k| variances[(k, k)] = accel * accel);
    let q = gain * variances * gain.transpose();
    assert!((q - fixed::<9, 9>(&given["Q"])).amax() < 1e-9);
    // The filter's own, in the body's angles: position and velocity agree to the last digit, angles by their rates.
    let own = noise(dt, [gyro, accel], [0.0; 2]);
    assert!((own.fixed_view::<6, 6>(3, 3) - q.fixed_view::<6, 6>(3, 3)).amax() < 1e-15);
    let rates = before.angle_rates().unwrap();
    let angles = rates * own.fixed_view::<3, 3>(0, 0) * rates.transpose();
    assert!((angles - q.fixed_view::<3, 3>(0, 0)).amax() < 1e-15);
}

/// The specification's covariance is of Euler angles; ours of the body's. One is the other by the rates, before and after.
#[test]
fn the_covariance_of_a_step_is_the_specified_one_in_other_angles() {
    let (updates, states) = (json(UPDATES), json(STATES));
    let before = euler(&numbers(&updates["prior"]["x"]));
    let case = states["cases"]
        .as_array()
        .unwrap()
        .iter()
        .find(|case| numbers(&case["state_rpy_p_v"]) == numbers(&updates["prior"]["x"]));
    let (sample, dt) = sample_of(case.unwrap());
    let [roll, pitch, yaw] = before.angles_rad.into();
    let state = NavState {
        nav_from_body: UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        position_m: before.position_m,
        velocity_m_s: before.velocity_m_s,
        ..NavState::default()
    };
    let p = SMatrix::<f64, 9, 9>::from_diagonal(&SVector::from_vec(numbers(&updates["prior"]["P_diag"])));
    let to_body = |euler: &EulerState| {
        let mut to = SMatrix::<f64, 9, 9>::identity();
        let inverse = euler.angle_rates().unwrap().try_inverse().unwrap();
        to.fixed_view_mut::<3, 3>(0, 0).copy_from(&inverse);
        to
    };
    let into = to_body(&before);
    let mut own = Covariance::identity() * 1e-12;
    own.fixed_view_mut::<9, 9>(0, 0).copy_from(&(into * p * into.transpose()));
    let f = jacobian(&state, &sample, dt);
    let devices = [
        updates["propagation"]["gyro_noise_rad_s"].as_f64().unwrap(),
        updates["propagation"]["accel_noise_m_s2"].as_f64().unwrap(),
    ];
    let next = carried(&f, &own) + noise(dt, devices, [0.0; 2]);
    assert!((carried(&f, &own) - f * own * f.transpose()).amax() < 1e-15);
    let after = before.propagate(&sample, dt).unwrap();
    let back = to_body(&after).try_inverse().unwrap();
    let found = back * next.fixed_view::<9, 9>(0, 0) * back.transpose();
    let expected: SMatrix<f64, 9, 9> = fixed(&updates["propagation"]["P_next"]);
    // The specification's step of the angles is of first order: they differ by the square of 0.3 rad/s in 0.01 s.
    assert!((found - expected).amax() < 1e-6, "{}", (found - expected).amax());
}

/// Covariance of the state, what is measured of it, covariance of the measurement, state, measurement.
type Posed = (SMatrix<f64, 9, 9>, SMatrix<f64, 3, 9>, Matrix3<f64>, SVector<f64, 9>, Vector3<f64>);

fn specified_pose() -> Posed {
    let updates = json(UPDATES);
    let p = SMatrix::<f64, 9, 9>::from_diagonal(&SVector::from_vec(numbers(&updates["prior"]["P_diag"])));
    let x = SVector::<f64, 9>::from_vec(numbers(&updates["prior"]["x"]));
    let mut c = SMatrix::<f64, 3, 9>::zeros();
    (c[(0, 3)], c[(1, 4)], c[(2, 2)]) = (1.0, 1.0, 1.0);
    let measured = &updates["pose2d_measurement"];
    let innovation = vector3(&measured["xi"]) - c * x;
    (p, c, fixed(&measured["R"]), x, innovation)
}

#[test]
fn covariance_intersection_is_as_specified_and_without_weight_changes_nothing() {
    let (p, c, r, x, innovation) = specified_pose();
    let updates = json(UPDATES);
    let given = &updates["covariance_intersection"];
    let at_best = serde_json::json!({
        "omega": given["omega_minimising_trace_of_pose_block"],
        "x": given["at_that_omega"]["x"],
        "P_diag": given["at_that_omega"]["P_diag"],
    });
    for case in given["cases"].as_array().unwrap().iter().chain([&at_best]) {
        let omega = case["omega"].as_f64().unwrap();
        let whole = intersect(&p, &c, &r, &innovation, omega).unwrap();
        let expected = SVector::<f64, 9>::from_vec(numbers(&case["x"]));
        assert!((x + whole.change - expected).amax() < 1e-9, "{omega}");
        let diagonal = SVector::<f64, 9>::from_vec(numbers(&case["P_diag"]));
        assert!((whole.covariance.diagonal() - diagonal).amax() < 1e-8 * diagonal.amax().max(1.0), "{omega}");
        let pose = intersect_pose(&p, &c, &r, &innovation, omega).unwrap();
        assert!((c * pose.covariance * c.transpose() - c * whole.covariance * c.transpose()).amax() < 1e-9);
        assert!((pose.change - whole.change).amax() < 1e-9);
        assert!((pose.covariance[(0, 0)] - p[(0, 0)]).abs() < 1e-15, "roll has nothing to do with the pose");
        if let Some(trace) = case["trace_P"].as_f64() {
            assert!((whole.covariance.trace() - trace).abs() < 1e-9);
        }
    }
    let nothing = intersect_pose(&p, &c, &r, &innovation, 0.0).unwrap();
    assert!(nothing.change.amax() == 0.0 && (nothing.covariance - p).amax() < 1e-15);
    let best = best_omega(&(c * p * c.transpose()), &r).unwrap();
    let expected = given["omega_minimising_trace_of_pose_block"].as_f64().unwrap();
    assert!((best - expected).abs() < 1e-6, "{best}");
    for bad in [1.0, -0.1, f64::NAN] {
        assert!(intersect(&p, &c, &r, &innovation, bad).is_none());
    }
}

/// A slow twin: every weight by hundredths.
#[test]
fn the_best_weight_is_the_best_of_all() {
    let trace = |a: &Matrix3<f64>, b: &Matrix3<f64>, omega: f64| {
        (a.try_inverse().unwrap() * (1.0 - omega) + b.try_inverse().unwrap() * omega)
            .try_inverse()
            .unwrap()
            .trace()
    };
    for (a, b) in [
        (Vector3::new(0.01, 0.04, 0.02), Vector3::new(0.04, 0.01, 0.02)),
        (Vector3::new(1.0, 0.001, 0.5), Vector3::new(0.3, 0.2, 0.01)),
        (Vector3::new(1e-6, 1e-6, 1e-6), Vector3::new(1.0, 1.0, 1.0)),
    ] {
        let (a, b) = (Matrix3::from_diagonal(&a), Matrix3::from_diagonal(&b));
        let found = best_omega(&a, &b).unwrap();
        let least = (1..100).map(|k| trace(&a, &b, f64::from(k) / 100.0)).fold(f64::INFINITY, f64::min);
        assert!(trace(&a, &b, found) <= least + 1e-12, "{found}");
    }
    assert!(best_omega(&Matrix3::zeros(), &Matrix3::identity()).is_none());
}

#[test]
fn an_independent_aid_updates_as_specified() {
    let (p, c, r, x, _) = specified_pose();
    let updates = json(UPDATES);
    let given = &updates["kalman_update_for_independent_aid"];
    let innovation = vector3(&given["innovation"]);
    let updated = joseph(&p, &c, &r, &innovation).unwrap();
    assert!((updated.mahalanobis2 - given["mahalanobis_squared"].as_f64().unwrap()).abs() < 1e-9);
    assert!((CHI2_95[2] - given["chi2_gate_95_3dof"].as_f64().unwrap()).abs() < 1e-9);
    assert!((x + updated.change - SVector::<f64, 9>::from_vec(numbers(&given["x"]))).amax() < 1e-9);
    let diagonal = SVector::<f64, 9>::from_vec(numbers(&given["P_diag"]));
    assert!((updated.covariance.diagonal() - diagonal).amax() < 1e-9);
    // The same in the form that Joseph's product is written in.
    let gain = p * c.transpose() * (c * p * c.transpose() + r).try_inverse().unwrap();
    let rest = SMatrix::<f64, 9, 9>::identity() - gain * c;
    let long = rest * p * rest.transpose() + gain * r * gain.transpose();
    assert!((long - updated.covariance).amax() < 1e-15);
    assert!(joseph(&p, &c, &(-p.fixed_view::<3, 3>(3, 3).into_owned() * 9.0), &innovation).is_none());
}

#[test]
fn gravity_levels_as_specified() {
    let updates = json(UPDATES);
    let given = &updates["gravity_levelling"];
    let forces = vector3(&given["accel"]);
    assert!((forces.norm() - given["norm"].as_f64().unwrap()).abs() < 1e-9);
    let [roll, pitch] = leveled_angles(&forces);
    assert!((roll - given["roll"].as_f64().unwrap()).abs() < 1e-9);
    assert!((pitch - given["pitch"].as_f64().unwrap()).abs() < 1e-9);
}

#[test]
fn frames_chain_as_specified() {
    let frames = json(FRAMES);
    let pose = |value: &Value| {
        let numbers = numbers(value);
        pose2(numbers[0], numbers[1], numbers[2])
    };
    for case in frames["map_to_odom_cases"].as_array().unwrap() {
        let found =
            map_from_odom(&pose(&case["map_to_base_footprint"]), &pose(&case["odom_to_base_footprint"]));
        let expected = pose(&case["map_to_odom"]);
        assert!((found.translation.vector - expected.translation.vector).norm() < 1e-10);
        assert!(found.rotation.angle_to(&expected.rotation).abs() < 1e-10);
    }
    let given = &frames["point_chain"];
    let tilt = numbers(&given["roll_pitch_of_base_link_in_base_stabilized"]);
    let chain = FrameChain {
        odom_from_footprint: pose(&given["base_footprint_pose_in_map"]),
        height_m: given["height_of_base_stabilized_above_base_footprint"].as_f64().unwrap(),
        stabilized_from_base: UnitQuaternion::from_euler_angles(tilt[0], tilt[1], 0.0),
    };
    let at = |key: &str| Point3::from(vector3(&given[key]));
    let in_base = at("point_in_base_link");
    assert!((chain.stabilized_from_base * in_base - at("point_in_base_stabilized")).norm() < 1e-10);
    assert!((chain.footprint_from_base() * in_base - at("point_in_base_footprint")).norm() < 1e-10);
    assert!((chain.odom_from_base() * in_base - at("point_in_map")).norm() < 1e-10);
    let again = FrameChain::of(&chain.odom_from_base());
    assert!((again.height_m - chain.height_m).abs() < 1e-12);
    assert!(again.stabilized_from_base.angle_to(&chain.stabilized_from_base) < 1e-9);
}

#[test]
fn aids_depend_on_the_errors_as_they_say() {
    let state = NavState {
        nav_from_body: UnitQuaternion::from_euler_angles(0.5, -0.7, 2.0),
        velocity_m_s: Vector3::new(0.8, -0.4, 0.2),
        ..NavState::default()
    };
    let forces = state.nav_from_body.inverse() * Vector3::z() * GRAVITY_M_S2;
    let step = 1e-6;
    for col in 0..15 {
        let mut errors = SVector::<f64, 15>::zeros();
        errors[col] = step;
        let (plus, minus) = (state.plus(&errors), state.plus(&-errors));
        let sliding = aids::no_sliding(&state, 0.1, 0.1);
        let by = |s: &NavState| aids::no_sliding(s, 0.1, 0.1).innovation;
        assert!(((by(&minus) - by(&plus)) / (2.0 * step) - sliding.h.column(col)).amax() < 1e-7);
        let measured = nalgebra::Vector2::new(0.3, 0.1);
        let r = nalgebra::Matrix2::identity();
        let by = |s: &NavState| aids::floor_velocity(s, &measured, &r).innovation;
        let floor = aids::floor_velocity(&state, &measured, &r);
        assert!(((by(&minus) - by(&plus)) / (2.0 * step) - floor.h.column(col)).amax() < 1e-7);
        // With biases of the forces left aside: those are found by velocities.
        if col < GYRO_BIAS.min(ACCEL_BIAS) {
            let leveling = |s: &NavState| aids::leveling(s, &forces, 0.05).unwrap();
            let up = |s: &NavState| s.nav_from_body.inverse() * Vector3::z();
            let moved = (up(&plus) - up(&minus)).norm() / (2.0 * step);
            assert!((leveling(&state).h.column(col).norm() - moved).abs() < 1e-6, "{col}");
        }
    }
}
