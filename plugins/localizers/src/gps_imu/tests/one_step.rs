//! Single steps of the filters against the equations written out, and against batch solutions.

use rumbo_core::time::Span;

use super::*;
use crate::gps_imu::ekf::{Ekf, EkfSettings};
use crate::gps_imu::mean3::Mean3;
use crate::gps_imu::pulled::{Pulled, PulledSettings, Taken};
use crate::gps_imu::seen_fix::SeenFix;

const SETTINGS: PulledSettings = PulledSettings { step_noise: 0.02, gate: 3.0, reset_after: 3 };
const EKF: EkfSettings = EkfSettings { bias_deviation_rad: 0.1, bias_walk_rad: 0.0, reset_after: 3 };

fn seen(x_m: f64, y_m: f64, error_m: f64) -> SeenFix {
    let fix = PositionFix { position_m: [x_m, y_m, 0.0], deviation_m: [error_m / 3f64.sqrt(); 3] };
    SeenFix::new(&fix, &Pose3::identity(), &Pose2::identity(), None)
}

/// The equations of the specification, section 6.5, with its numbers.
#[test]
fn a_step_and_a_fix_do_what_the_equations_say() {
    let mut pulled = Pulled::new(SETTINGS, Some((Vector2::new(1.0, 2.0), 0.25)));
    let yaw_rad = 2.0;
    pulled.advance(&pose2(0.3, 0.1, 0.5), yaw_rad);
    let (sin, cos) = yaw_rad.sin_cos();
    let expected_m = Vector2::new(1.0 + cos * 0.3 - sin * 0.1, 2.0 + sin * 0.3 + cos * 0.1);
    let expected_m2 = 0.25 + 0.02 * 0.02 * (0.09 + 0.01) + 1e-7;
    let (position_m, variance_m2) = pulled.position().unwrap();
    assert!((position_m - expected_m).norm() < 1e-12 && (variance_m2 - expected_m2).abs() < 1e-12);
    assert_eq!(pulled.take_fix(&seen(3.0, 1.0, 5.0), yaw_rad), Taken::Used);
    let gain = expected_m2 / (expected_m2 + 25.0 / 3.0);
    let expected_m = expected_m + (Vector2::new(3.0, 1.0) - expected_m) * gain;
    let (position_m, variance_m2) = pulled.position().unwrap();
    assert!((position_m - expected_m).norm() < 1e-12);
    assert!((variance_m2 - (1.0 - gain) * expected_m2).abs() < 1e-12);
}

#[test]
fn a_fix_beyond_three_deviations_along_an_axis_is_refused_until_too_many_say_the_same() {
    let most_m = 3.0 * (0.25f64 + 25.0 / 3.0).sqrt();
    let pulled = || Pulled::new(SETTINGS, Some((Vector2::zeros(), 0.25)));
    for (x_m, y_m, expected) in [
        (most_m - 1e-6, -most_m + 1e-6, Taken::Used),
        (most_m + 1e-6, 0.0, Taken::Refused),
        (0.0, -most_m - 1e-6, Taken::Refused),
        (f64::NAN, 0.0, Taken::Used),
    ] {
        if x_m.is_finite() {
            assert_eq!(pulled().take_fix(&seen(x_m, y_m, 5.0), 0.0), expected, "{x_m} {y_m}");
        }
    }
    let mut pulled = pulled();
    let far = seen(100.0, 0.0, 5.0);
    for expected in [Taken::Refused, Taken::Refused, Taken::Refused, Taken::Placed, Taken::Used] {
        assert_eq!(pulled.take_fix(&far, 0.0), expected);
    }
    // A good one in between begins the count anew.
    let mut pulled = Pulled::new(SETTINGS, Some((Vector2::zeros(), 0.25)));
    for x_m in [100.0, 100.0, 0.0, 100.0, 100.0, 100.0] {
        assert_ne!(pulled.take_fix(&seen(x_m, 0.0, 5.0), 0.0), Taken::Placed);
    }
}

#[test]
fn three_fixes_make_a_mean_and_fewer_do_not() {
    let outage = Span::from_secs(5.0);
    let mut mean = Mean3::new(None, 1.2, outage);
    assert_eq!(mean.position(Time::ZERO), None);
    let at = |seconds: f64| Time::from_secs(seconds);
    let fix_m = |k: f64| Vector2::new(k, -2.0 * k);
    let variance_m2 = 25.0 / 3.0;
    mean.take_fix(at(0.0), fix_m(0.0), variance_m2);
    mean.take_fix(at(1.0), fix_m(6.0), variance_m2);
    assert_eq!(mean.position(at(1.0)), Some((fix_m(6.0), variance_m2)), "the current one alone");
    mean.take_fix(at(2.0), fix_m(3.0), variance_m2);
    let (position_m, found_m2) = mean.position(at(2.0)).unwrap();
    // A ninth of the square of the bound, as the specification has it.
    assert!((position_m - fix_m(3.0)).norm() < 1e-12 && (found_m2 - 25.0 / 9.0).abs() < 1e-12);
    mean.take_fix(at(3.0), fix_m(9.0), variance_m2);
    assert!((mean.position(at(3.0)).unwrap().0 - fix_m(6.0)).norm() < 1e-12, "the oldest is gone");
    // The robot may have gone on since.
    let (_, later_m2) = mean.position(at(5.0)).unwrap();
    assert!((later_m2 - 25.0 / 9.0 - 2.4f64.powi(2)).abs() < 1e-12);
    mean.take_fix(at(8.1), fix_m(20.0), variance_m2);
    assert_eq!(mean.position(at(8.1)).unwrap(), (fix_m(20.0), variance_m2), "after an outage");
    let start = Mean3::new(Some((fix_m(1.0), 0.01)), 1.2, outage);
    assert_eq!(start.position(at(3.0)), Some((fix_m(1.0), 0.01)));
}

/// The belief after a fix and a yaw is that of least squares over everything at once.
#[test]
fn the_first_fix_with_a_measured_yaw_is_what_least_squares_make_of_both() {
    let mount = Pose3::translation(0.6, -0.3, 1.0);
    let fix = PositionFix { position_m: [10.0, 5.0, 0.0], deviation_m: [2.0, 3.0, 1.0] };
    let fix = SeenFix::new(&fix, &mount, &Pose2::identity(), None);
    let (yaw_rad, variance_rad2) = (0.7, 0.01f64.powi(2));
    let ekf = Ekf::at_fix(EKF, &fix, yaw_rad, variance_rad2);
    // Nothing known but the bias; then both measurements, in the form of information.
    let mut information = nalgebra::Matrix4::<f64>::zeros();
    information[(3, 3)] = 1.0 / 0.1f64.powi(2);
    let by_fix = motion::antenna_by_state(&ekf.mean, &fix.lever_now_m);
    let inverse = nalgebra::Matrix2::from_diagonal(&fix.variance_m2.map(|variance| 1.0 / variance));
    information += by_fix.transpose() * inverse * by_fix;
    let by_yaw = motion::measured_yaw_by_state();
    information += by_yaw.transpose() * by_yaw / variance_rad2;
    let expected = information.try_inverse().unwrap();
    assert!((ekf.covariance - expected).norm() < 1e-9 * expected.norm(), "{} {expected}", ekf.covariance);
    let antenna = ekf.pose() * nalgebra::Point2::new(0.6, -0.3);
    assert!((antenna.coords - Vector2::new(10.0, 5.0)).norm() < 1e-12);
}

#[test]
fn updates_are_those_of_information_and_their_order_does_not_matter() {
    let begin = || {
        let mut ekf = Ekf::at(EKF, &pose2(1.0, 2.0, 0.4), &Matrix3::from_diagonal(&[0.5, 0.4, 0.02].into()));
        ekf.advance(&pose2(0.5, 0.0, 0.1), [0.05, 0.02, 0.05]);
        ekf
    };
    // Without a lever both measurements are linear.
    let fix = seen(1.6, 2.1, 2.0);
    let (mut one, mut other, before) = (begin(), begin(), begin());
    assert_eq!((one.take_fix(&fix), one.take_yaw(0.45, 0.01)), (Taken::Used, Taken::Used));
    assert_eq!((other.take_yaw(0.45, 0.01), other.take_fix(&fix)), (Taken::Used, Taken::Used));
    assert!((one.mean - other.mean).norm() < 1e-12 && (one.covariance - other.covariance).norm() < 1e-12);
    let mut information = before.covariance.try_inverse().unwrap();
    let by_fix = motion::antenna_by_state(&before.mean, &fix.lever_now_m);
    let by_yaw = motion::measured_yaw_by_state();
    let fix_information = by_fix.transpose() / fix.variance_m2.x;
    let mut right = fix_information * (fix.antenna_m - before.mean.xy());
    right += by_yaw.transpose() * ((0.45 - before.mean[2] - before.mean[3]) / 0.01);
    information += fix_information * by_fix + by_yaw.transpose() * by_yaw / 0.01;
    let expected = information.try_inverse().unwrap();
    assert!((one.covariance - expected).norm() < 1e-10);
    assert!((one.mean - before.mean - expected * right).norm() < 1e-10);
}

#[test]
fn what_does_not_fit_is_refused_until_too_many_say_the_same() {
    let mut ekf = Ekf::at(EKF, &Pose2::identity(), &(Matrix3::identity() * 0.01));
    let far = seen(50.0, 0.0, 1.0);
    for expected in [Taken::Refused, Taken::Refused, Taken::Refused, Taken::Placed, Taken::Used] {
        assert_eq!(ekf.take_fix(&far), expected);
    }
    assert!((ekf.mean[0] - 50.0).abs() < 0.1 && ekf.covariance[(0, 0)] < 0.4);
    for expected in [Taken::Refused, Taken::Refused, Taken::Refused, Taken::Placed, Taken::Used] {
        assert_eq!(ekf.take_yaw(2.0, 1e-4), expected);
    }
    // The yaw of the robot is what it was: the unit was restarted, not the robot turned.
    assert!(ekf.mean[2].abs() < 0.05 && (ekf.mean[3] - 2.0).abs() < 0.05, "{}", ekf.mean);
}

#[test]
fn angles_are_compared_over_the_wrap() {
    let covariance = Matrix3::identity() * 0.01;
    for side in [-1.0, 1.0] {
        let mut ekf = Ekf::at(EKF, &pose2(0.0, 0.0, side * 3.1), &covariance);
        assert_eq!(ekf.take_yaw(side * -3.1, 0.01), Taken::Used);
        let moved_rad = wrap_angle(ekf.mean[2] - side * 3.1) * side;
        assert!(moved_rad > 0.0 && moved_rad < 0.1, "{moved_rad}");
        ekf.advance(&pose2(0.0, 0.0, side * 0.5), [0.0; 3]);
        assert!(ekf.mean[2].abs() <= std::f64::consts::PI);
    }
}
