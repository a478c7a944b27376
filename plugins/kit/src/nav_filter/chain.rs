//! The frames between the odometer's and the body's: `odom` → `base_footprint` → `base_stabilized` → `base_link` (REP-105
//! with the two frames in the middle of Kohlbrecher et al. 2011).

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rumbo_core::frames::{Pose2, Pose3, flatten, lift};

/// A pose in space, link by link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameChain {
    /// Place and yaw on the floor.
    pub odom_from_footprint: Pose2,
    /// How high the body is over that, meters.
    pub height_m: f64,
    /// Roll and pitch, without yaw.
    pub stabilized_from_base: UnitQuaternion<f64>,
}

impl FrameChain {
    /// The links of a pose.
    pub fn of(odom_from_base: &Pose3) -> FrameChain {
        let odom_from_footprint = flatten(odom_from_base);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), odom_from_footprint.rotation.angle());
        FrameChain {
            odom_from_footprint,
            height_m: odom_from_base.translation.z,
            stabilized_from_base: yaw.inverse() * odom_from_base.rotation,
        }
    }

    /// `base_footprint` from `base_link`.
    pub fn footprint_from_base(&self) -> Pose3 {
        Pose3::from_parts(Translation3::new(0.0, 0.0, self.height_m), self.stabilized_from_base)
    }

    /// The whole chain.
    pub fn odom_from_base(&self) -> Pose3 {
        lift(&self.odom_from_footprint) * self.footprint_from_base()
    }
}

/// The correction of an odometer: both poses are of the same moment.
pub fn map_from_odom(map_from_footprint: &Pose2, odom_from_footprint: &Pose2) -> Pose2 {
    map_from_footprint * odom_from_footprint.inverse()
}
