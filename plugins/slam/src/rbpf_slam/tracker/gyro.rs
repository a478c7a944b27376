//! How far the robot has turned from scan to scan, by the turning rates of an inertial unit.

use crate::gyro::{Gyro, Heading};
use crate::turning::yaw_rate_rad_s;
use rumbo_core::frames::{Pose3, is_finite3};
use rumbo_core::messages::{Check, Imu};
use rumbo_core::time::Time;

/// Turns between scans.
#[derive(Debug, Clone, Default)]
pub struct Turns {
    pub(in crate::rbpf_slam) gyro: Gyro,
    /// At the last scan, where the readings reached so far.
    pub(in crate::rbpf_slam) at_scan: Option<Heading>,
}

/// Errors of a turn: at least, radians; a drift, rad/s; and a share of the turn.
const ERRORS: [f64; 3] = [0.005, 0.01, 0.02];

impl Turns {
    /// Takes in a reading; whether it is of use.
    pub fn take(&mut self, stamp: Time, imu: &Imu, base_from_sensor: &Pose3) -> bool {
        let is_usable = imu.check().is_ok() && is_finite3(base_from_sensor);
        is_usable && self.gyro.take(stamp, yaw_rate_rad_s(imu, base_from_sensor))
    }

    /// What comes cannot be compared with what was.
    pub fn forget(&mut self) {
        *self = Turns::default();
    }

    /// The turn since the last scan and its variance, radians and rad², where the readings did not break off.
    pub fn turn_to(&mut self, stamp: Time, last: Option<Time>) -> Option<(f64, f64)> {
        let at_scan = self.gyro.at(stamp);
        let before = std::mem::replace(&mut self.at_scan, at_scan)?;
        let turn_rad = at_scan?.since(&before)?;
        let [least_rad, drift_rad_s, share] = ERRORS;
        let deviation_rad = least_rad + drift_rad_s * (stamp - last?).as_secs() + share * turn_rad.abs();
        Some((turn_rad, deviation_rad * deviation_rad))
    }
}
