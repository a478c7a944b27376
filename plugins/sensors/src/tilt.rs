//! How an inertial sensor says that its robot is tilted.

use nalgebra::{UnitQuaternion, Vector3};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::Imu;

/// The base's attitude by a device on this mount; none where it has none.
pub fn world_from_base(base_from_imu: &Pose3, imu: &Imu) -> Option<UnitQuaternion<f64>> {
    let [roll_rad, pitch_rad, yaw_rad] = imu.attitude_rad?;
    let world_from_imu = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, yaw_rad);
    Some(world_from_imu * base_from_imu.rotation.inverse())
}

/// Roll and pitch only: yaw is the odometer's business.
pub fn without_yaw(world_from_base: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let ahead = world_from_base * Vector3::x();
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), ahead.y.atan2(ahead.x));
    yaw.inverse() * world_from_base
}
