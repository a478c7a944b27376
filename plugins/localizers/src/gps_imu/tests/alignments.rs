//! The heading from the way between fixes.

use rand::RngExt as _;
use rumbo_core::rng;

use super::*;
use crate::gps_imu::alignment::Alignment;
use crate::gps_imu::seen_fix::SeenFix;

fn seen(at_m: Vector2<f64>, error_m: f64) -> SeenFix {
    let fix = PositionFix { position_m: [at_m.x, at_m.y, 0.0], deviation_m: [error_m / 3f64.sqrt(); 3] };
    SeenFix::new(&fix, &Pose3::identity(), &Pose2::identity(), None)
}

/// Positions of the odometer on a bent way.
fn way() -> Vec<Pose2> {
    (0..40).map(|k| Twist::new(1.0, 0.04).integrate(f64::from(k))).collect()
}

#[test]
fn without_errors_it_is_exact_and_without_a_way_there_is_none() {
    for yaw_rad in [-3.0, -1.0, 0.0, 1.5, 3.1] {
        let map_from_odom = pose2(7.0, -3.0, yaw_rad);
        let mut alignment = Alignment::default();
        for (k, odom_from_base) in way().iter().enumerate() {
            assert_eq!(alignment.pose(odom_from_base).is_some(), k >= 3);
            alignment
                .take_fix(&seen((map_from_odom * odom_from_base).translation.vector, 1.0), odom_from_base);
        }
        let end = way()[39];
        let (pose, _) = alignment.pose(&end).unwrap();
        assert!((pose.to_homogeneous() - (map_from_odom * end).to_homogeneous()).norm() < 1e-9);
    }
    let mut standing = Alignment::default();
    (0..5).for_each(|_| standing.take_fix(&seen(Vector2::new(1.0, 2.0), 1.0), &Pose2::identity()));
    assert_eq!(standing.pose(&Pose2::identity()), None);
}

#[test]
fn its_covariance_is_that_of_many_ways_with_errors() {
    let (map_from_odom, mut rng) = (pose2(7.0, -3.0, 2.0), rng::stream(4, "alignment"));
    let (end, n) = (way()[39], 4000);
    let truth = map_from_odom * end;
    let (mut sum, mut claimed) = (Matrix3::zeros(), Matrix3::zeros());
    for _ in 0..n {
        let mut alignment = Alignment::default();
        for odom_from_base in way() {
            let mut error_m = || 3.0 * (2.0 * rng.random::<f64>() - 1.0);
            let error_m = Vector2::new(error_m(), error_m());
            let at_m = (map_from_odom * odom_from_base).translation.vector + error_m;
            alignment.take_fix(&seen(at_m, 3.0), &odom_from_base);
        }
        let (pose, covariance) = alignment.pose(&end).unwrap();
        let off_m = pose.translation.vector - truth.translation.vector;
        let off = nalgebra::Vector3::new(
            off_m.x,
            off_m.y,
            wrap_angle(pose.rotation.angle() - truth.rotation.angle()),
        );
        sum += off * off.transpose() / f64::from(n);
        claimed += covariance / f64::from(n);
    }
    for (row, col) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let scale = (claimed[(row, row)] * claimed[(col, col)]).sqrt();
        assert!((sum[(row, col)] - claimed[(row, col)]).abs() < 0.08 * scale, "{row} {col}: {sum} {claimed}");
    }
}

/// No sensor of the yaw, and nobody says where the robot is: after some way the Kalman filter knows.
#[test]
fn a_robot_without_a_measured_yaw_finds_its_heading_on_the_way() {
    let params =
        GpsImuParams { fusion: Fusion::Ekf, heading: HeadingSource::Odometry, ..GpsImuParams::default() };
    let mut localizer = started(&params, &Prior::Unknown);
    let (start, mut rng) = (pose2(4.0, 5.0, -2.0), rng::stream(4, "way"));
    let mut statuses = Vec::new();
    for k in 0..1200 {
        let seconds = 0.1 * f64::from(k);
        let odom_from_base = Twist::new(0.5, 0.03).integrate(seconds);
        let truth = start * odom_from_base;
        let mut seen = vec![odometry(seconds, odom_from_base)];
        if k % 10 == 0 {
            let mut error_m = || 3.0 * (2.0 * rng.random::<f64>() - 1.0);
            let error_m = Vector2::new(error_m(), error_m());
            seen.push(fix(seconds, truth.translation.vector + error_m, 3.0));
        }
        let estimate = update(localizer.as_mut(), seconds, &seen).unwrap();
        statuses.push(estimate.status);
        if k == 1199 {
            let off_rad = wrap_angle(estimate.pose2().rotation.angle() - truth.rotation.angle());
            let deviation_rad = estimate.covariance2()[(2, 2)].sqrt();
            assert!(off_rad.abs() < 0.1 && off_rad.abs() < 3.0 * deviation_rad, "{off_rad} {deviation_rad}");
            assert!(apart_m(&estimate, &truth) < 1.5, "{}", apart_m(&estimate, &truth));
        }
    }
    let first = statuses.iter().position(|status| *status == Status::Tracking).unwrap();
    // Fixes of 1.7 m tell 20 degrees after some meters, not at once.
    assert!((50..500).contains(&first), "{first}");
    assert!(statuses[..first].iter().all(|status| *status == Status::Lost));
    assert!(statuses[first..].iter().all(|status| *status == Status::Tracking));
}
