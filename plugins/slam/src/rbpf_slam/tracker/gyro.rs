//! How far the robot has turned from scan to scan, by the turning rates of an inertial unit.

use rumbo_core::frames::{Pose2, Pose3, is_finite3, pose2};
use rumbo_core::messages::{Check, Imu};
use rumbo_core::time::Time;
use rumbo_kit::odometry_history::{OdometryHistory, Reading};

/// Turns summed up from rates.
#[derive(Debug, Clone, Default)]
pub struct Gyro {
    /// Turned by so much since the readings began, as a pose without a place.
    pub(in crate::rbpf_slam) turned: OdometryHistory,
    /// The same at the last scan, where the readings reached so far.
    pub(in crate::rbpf_slam) at_scan: Option<Pose2>,
}

/// Nobody knows how far a robot turns between readings farther apart than this, seconds.
const LONGEST_GAP_S: f64 = 0.25;
/// Errors of a turn: at least, radians; a drift, rad/s; and a share of the turn.
const ERRORS: [f64; 3] = [0.005, 0.01, 0.02];

impl Gyro {
    /// Takes in a reading; whether it is of use.
    pub fn take(&mut self, stamp: Time, imu: &Imu, base_from_sensor: &Pose3) -> bool {
        if imu.check().is_err() || !is_finite3(base_from_sensor) {
            return false;
        }
        let rate_rad_s = (base_from_sensor.rotation * nalgebra::Vector3::from(imu.rates_rad_s)).z;
        let Some((last, turn)) = self.turned.newest() else {
            return self.turned.push(stamp, Pose2::identity()) == Reading::Newest;
        };
        let seconds = (stamp - last).as_secs();
        if seconds <= 0.0 {
            return false;
        }
        if seconds > LONGEST_GAP_S {
            self.forget();
            return self.turned.push(stamp, Pose2::identity()) == Reading::Newest;
        }
        self.turned.push(stamp, turn * pose2(0.0, 0.0, rate_rad_s * seconds)) == Reading::Newest
    }

    /// What comes cannot be compared with what was.
    pub fn forget(&mut self) {
        *self = Gyro::default();
    }

    /// Nothing better will be known of this time.
    pub fn is_past(&self, stamp: Time) -> bool {
        let broke_off = |(newest, _): (Time, Pose2)| (stamp - newest).as_secs() > LONGEST_GAP_S;
        self.turned.newest().is_none_or(broke_off) || self.turned.is_past(stamp)
    }

    /// The turn since the last scan and its variance, radians and rad², where the readings did not break off.
    pub fn turn_to(&mut self, stamp: Time, last: Option<Time>) -> Option<(f64, f64)> {
        let at_scan = self.turned.at(stamp);
        let before = std::mem::replace(&mut self.at_scan, at_scan)?;
        let turn_rad = (before.inverse() * at_scan?).rotation.angle();
        let [least_rad, drift_rad_s, share] = ERRORS;
        let deviation_rad = least_rad + drift_rad_s * (stamp - last?).as_secs() + share * turn_rad.abs();
        Some((turn_rad, deviation_rad * deviation_rad))
    }
}
