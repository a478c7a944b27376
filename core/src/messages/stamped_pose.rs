//! A place at a time: what a trajectory is made of.

use super::check::{Check, Checker, MessageFault};
use crate::frames::Pose3;
use crate::time::Time;

/// Where the robot was at a time.
#[doc(alias = "geometry_msgs/PoseStamped")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampedPose {
    /// When.
    pub stamp: Time,
    /// The robot in the map.
    pub map_from_base: Pose3,
}

impl Check for StampedPose {
    fn check(&self) -> Result<(), MessageFault> {
        Checker("stamped pose").pose3("map_from_base", &self.map_from_base)
    }
}
