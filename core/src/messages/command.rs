//! What people and programs tell the robot, and what the engine tells the world.

use super::check::{Check, Checker, MessageFault};
use crate::boundary::Buffer;
use crate::frames::{Point2, Pose2, Twist};
use crate::time::Time;
use nalgebra::Matrix3;

/// A place to go to.
#[doc(alias = "NavigateToPose")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Where, in the map's frame.
    pub position: Point2,
    /// Which way to look at the end, radians; free where absent.
    pub yaw_rad: Option<f64>,
}

impl Check for Goal {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("goal");
        c.finite("position", &[self.position.x, self.position.y])?;
        self.yaw_rad.map_or(Ok(()), |yaw| c.finite("yaw_rad", &[yaw]))
    }
}

/// What a localizer is told when it starts.
#[doc(alias = "initialpose")]
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Prior {
    /// The robot may be anywhere.
    #[default]
    Unknown,
    /// The robot is about here.
    Pose {
        /// The robot in the map.
        map_from_base: Pose2,
        /// The odometer's reading at that time.
        odom_from_base: Pose2,
        /// Covariance of x, y, yaw.
        covariance: Matrix3<f64>,
    },
    /// What the same plugin saved before.
    Saved(Buffer<u8>),
}

impl Check for Prior {
    fn check(&self) -> Result<(), MessageFault> {
        let Prior::Pose { map_from_base, odom_from_base, covariance } = self else { return Ok(()) };
        let c = Checker("prior");
        c.pose2("map_from_base", map_from_base)?;
        c.pose2("odom_from_base", odom_from_base)?;
        c.finite("covariance", covariance.as_slice())
    }
}

/// What the guard lets through to the wheels.
#[doc(alias = "cmd_vel")]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// When it was given.
    pub stamp: Time,
    /// The wanted velocity of the base.
    pub twist: Twist,
}

impl Check for Command {
    fn check(&self) -> Result<(), MessageFault> {
        self.twist.check()
    }
}
