use rumbo_core::stages::WheelMotion;
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::{TestWorld, given};

#[test]
fn the_report_starts_at_zero_and_carries_the_speed() {
    let params = WheelEncodersParams { position_step_m: 0.00254, ..WheelEncodersParams::default() };
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (mut world, mut out, trace) =
        (TestWorld::with_wall(1.0), Observations::default(), Trace::unwatched());
    for (tick, rolled_m) in [(0, 5.0), (1, 5.05), (2, 5.10)] {
        world.wheels = WheelMotion { rolled_m: [rolled_m, rolled_m, 0.0, 0.0], ..WheelMotion::default() };
        sensor.poll(&mut Cx { now: Time(tick * 50_000_000), trace: &trace }, &mut world, &mut out).unwrap();
    }
    let reports: Vec<Odometry> = given(&out)
        .iter()
        .map(|observation| match observation.data {
            Data::Odometry(odometry) => odometry,
            _ => Odometry::default(),
        })
        .collect();
    assert_eq!(reports[0].odom_from_base.translation.x, 0.0);
    assert_eq!(reports[0].twist, Twist::ZERO);
    assert!((reports[2].odom_from_base.translation.x - 39.0 * 0.00254).abs() < 1e-12, "0.1 m is 39.4 steps");
    assert!((reports[2].twist.forward_m_s - 1.0).abs() < 1e-9);
    assert_eq!(reports[2].noise, [0.02, 0.5f64.to_radians(), 0.02]);
}

#[test]
fn each_wheel_s_speed_has_the_noise_it_is_said_to_have() {
    let params = WheelEncodersParams { speed_noise_m_s: 0.02, ..WheelEncodersParams::default() };
    let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
    let (mut world, mut out, trace) =
        (TestWorld::with_wall(1.0), Observations::default(), Trace::unwatched());
    for tick in 0..20_000 {
        let rolled_m = 0.05 * tick as f64;
        world.wheels = WheelMotion { rolled_m: [rolled_m, rolled_m, 0.0, 0.0], ..WheelMotion::default() };
        sensor.poll(&mut Cx { now: Time(tick * 50_000_000), trace: &trace }, &mut world, &mut out).unwrap();
    }
    let twists: Vec<Twist> = given(&out)
        .iter()
        .skip(1)
        .map(|observation| match observation.data {
            Data::Odometry(odometry) => odometry.twist,
            _ => Twist::ZERO,
        })
        .collect();
    let track_m = match BuildContext::bare("sensor").robot.drive {
        rumbo_core::robot::Drive::Differential { track_m } => track_m,
        _ => f64::NAN,
    };
    for side in [-1.0, 1.0] {
        let error = |twist: &Twist| twist.forward_m_s + side * twist.turn_rad_s * track_m / 2.0 - 1.0;
        let variance = twists.iter().map(|twist| error(twist).powi(2)).sum::<f64>() / twists.len() as f64;
        assert!((variance.sqrt() - 0.02).abs() < 4e-4, "{}", variance.sqrt());
    }
}

#[test]
fn two_polls_at_one_time_keep_the_speed() {
    let mut sensor = WheelEncodersParams::default().build(&BuildContext::bare("sensor")).unwrap();
    let (mut world, mut out, trace) =
        (TestWorld::with_wall(1.0), Observations::default(), Trace::unwatched());
    for _ in 0..2 {
        sensor.poll(&mut Cx { now: Time(7), trace: &trace }, &mut world, &mut out).unwrap();
    }
    let Data::Odometry(odometry) = given(&out)[1].data else { panic!() };
    assert!(odometry.twist.is_finite());
}

#[test]
fn a_wheel_that_is_no_number_is_an_error_and_leaves_the_odometer_as_it_was() {
    let mut sensor = WheelEncodersParams::default().build(&BuildContext::bare("sensor")).unwrap();
    let (mut world, mut out, trace) =
        (TestWorld::with_wall(1.0), Observations::default(), Trace::unwatched());
    for (tick, rolled_m) in [(0, 5.0), (1, f64::NAN), (2, f64::INFINITY), (3, 5.10)] {
        world.wheels = WheelMotion { rolled_m: [rolled_m, rolled_m, 0.0, 0.0], ..WheelMotion::default() };
        let polled = sensor.poll(&mut Cx { now: Time(tick), trace: &trace }, &mut world, &mut out);
        assert_eq!(polled.is_ok(), rolled_m.is_finite(), "{polled:?}");
    }
    let Data::Odometry(odometry) = given(&out)[1].data else { panic!() };
    assert!((odometry.odom_from_base.translation.x - 0.1).abs() < 1e-9);
}

#[test]
fn impossible_steps_are_named() {
    let bad = WheelEncodersParams {
        wheel_step_m: -1.0,
        heading_step_deg: f64::NAN,
        ..WheelEncodersParams::default()
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["wheel_step_m", "heading_step_deg"]);
}
