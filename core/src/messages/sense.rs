//! Readings of the robot's own motion and place: wheels, steering, inertia, position fixes.

use super::check::{Check, Checker, MessageFault};
use crate::frames::{Pose2, Twist};

/// Where the wheels (or another odometer) say the base is, seen from where it started.
#[doc(alias = "nav_msgs/Odometry")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odometry {
    /// The base in the odometer's frame.
    pub odom_from_base: Pose2,
    /// Velocity of the base.
    pub twist: Twist,
    /// Standard deviations that grow per meter and per radian: distance (m/m), direction (rad/m), turn (rad/rad).
    pub noise: [f64; 3],
}

impl Default for Odometry {
    fn default() -> Self {
        Odometry { odom_from_base: Pose2::identity(), twist: Twist::ZERO, noise: [0.0; 3] }
    }
}

impl Check for Odometry {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("odometry");
        c.pose2("odom_from_base", &self.odom_from_base)?;
        c.finite("twist", &[self.twist.forward_m_s, self.twist.left_m_s, self.twist.turn_rad_s])?;
        c.finite("noise", &self.noise)
    }
}

/// Rolling speeds of at most four wheels.
#[doc(alias = "sensor_msgs/JointState")]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelSpeeds {
    /// How many of the numbers below are used.
    pub n_wheels: u32,
    /// Speed of each wheel's rim over the floor, m/s; left before right, front before rear.
    pub rim_m_s: [f64; 4],
}

impl Check for WheelSpeeds {
    fn check(&self) -> Result<(), MessageFault> {
        Checker("wheel_speeds").finite("rim_m_s", &self.rim_m_s)
    }
}

/// Angle of the steered wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SteeringAngle {
    /// Counter-clockwise from straight ahead, radians.
    pub angle_rad: f64,
}

impl Check for SteeringAngle {
    fn check(&self) -> Result<(), MessageFault> {
        Checker("steering_angle").finite("angle_rad", &[self.angle_rad])
    }
}

/// Attitude, turning rates and specific force in the sensor's frame.
#[doc(alias = "sensor_msgs/Imu")]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Imu {
    /// Roll, pitch, yaw (fixed axes, applied in this order), radians; absent where the device gives rates only.
    pub attitude_rad: Option<[f64; 3]>,
    /// Turning rates about x, y, z, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Specific force along x, y, z, m/s²; at rest +9.81 along z.
    pub accelerations_m_s2: [f64; 3],
}

impl Check for Imu {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("imu");
        if let Some(attitude) = &self.attitude_rad {
            c.finite("attitude_rad", attitude)?;
        }
        c.finite("rates_rad_s", &self.rates_rad_s)?;
        c.finite("accelerations_m_s2", &self.accelerations_m_s2)
    }
}

/// A position in the map's frame from outside the robot.
#[doc(alias = "sensor_msgs/NavSatFix")]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PositionFix {
    /// x, y, z in the map's frame, meters.
    pub position_m: [f64; 3],
    /// Standard deviation along each axis, meters.
    pub deviation_m: [f64; 3],
}

impl Check for PositionFix {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("position_fix");
        c.finite("position_m", &self.position_m)?;
        self.deviation_m.iter().try_for_each(|d| c.not_negative("deviation_m", *d))
    }
}
