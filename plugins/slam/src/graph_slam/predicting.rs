//! Where will the next scan have been taken? The wheels say it, a gyroscope, or the motion before.

use super::front_end::Prediction;
use super::tracker::{BLIND_AFTER_S, Reckoned, Tracker};
use crate::gyro::Heading;
use nalgebra::UnitComplex;
use rumbo_core::frames::{Pose2, interpolate2};
use rumbo_core::time::Time;

/// Dead reckoning that may be farther off has nothing to be registered on, meters.
const MOST_OFF_M: f64 = 0.5;
/// Errors of a guess without an odometer, shares of the gap between two scans.
const GUESS_M_S: f64 = 1.0;
const GUESS_RAD_S: f64 = 1.0;

impl Tracker {
    pub(super) fn predict(&self, stamp: Time) -> Prediction {
        let Some(before) = self.before else {
            let deviation = self.covariance.diagonal().map(f64::sqrt);
            let off_m = deviation.x.max(deviation.y).max(1e-3);
            let first_gate_m = (2.0 * off_m).clamp(0.3, 0.5);
            let deviation = [off_m, deviation.z.max(1e-3)];
            let here = self.frame_from_base;
            return Prediction {
                frame_from_base: here,
                without_odometer: None,
                deviation,
                seconds: 0.0,
                first_gate_m,
                is_far: false,
                is_blind: false,
            };
        };
        let now = self.reckoned_at(stamp);
        let seconds = (stamp - before.reckoned.stamp).as_secs();
        let [least_m, share_m, least_rad, share_rad] = self.settings.tie.odometer;
        let share = if before.seconds > 0.0 { (seconds / before.seconds).min(3.0) } else { 0.0 };
        let as_before = interpolate2(&Pose2::identity(), &before.motion, share);
        let (mut motion, mut deviation) = match (before.reckoned.odom_from_base, now.odom_from_base) {
            (Some(last), Some(now)) => {
                let motion = last.inverse() * now;
                let off_m = least_m + share_m * motion.translation.vector.norm();
                (motion, [off_m, least_rad + share_rad * motion.rotation.angle().abs()])
            }
            _ => (as_before, [least_m + GUESS_M_S * seconds, least_rad + GUESS_RAD_S * seconds]),
        };
        let has_odometer = now.odom_from_base.is_some() && before.reckoned.odom_from_base.is_some();
        let is_far = has_odometer && deviation[0] > MOST_OFF_M;
        let is_blind = !has_odometer && seconds > BLIND_AFTER_S;
        if let Some(turn_rad) = now.turn_since(&before.reckoned) {
            motion.rotation = UnitComplex::new(turn_rad);
            deviation[1] = self.settings.tie.off_by_gyroscope_rad(turn_rad, seconds);
        }
        let first_gate_m = (2.0 * deviation[0] + 10.0 * deviation[1]).clamp(0.3, 0.5);
        let here = self.frame_from_base;
        let without_odometer = (seconds <= BLIND_AFTER_S).then(|| [here, here * as_before]);
        Prediction {
            frame_from_base: here * motion,
            without_odometer,
            deviation,
            seconds,
            first_gate_m,
            is_far,
            is_blind,
        }
    }

    /// What odometer and gyroscope say of a time, as well as it is known yet.
    pub(super) fn reckoned_at(&self, stamp: Time) -> Reckoned {
        Reckoned { stamp, odom_from_base: self.odom_at(stamp), heading: self.heading_at(stamp) }
    }

    /// The odometer at a time, as well as it is known yet.
    pub fn odom_at(&self, stamp: Time) -> Option<Pose2> {
        self.odometry.at(stamp).or_else(|| self.odometry.newest().map(|(_, pose)| pose))
    }

    pub(super) fn heading_at(&self, stamp: Time) -> Option<Heading> {
        let newest = || self.gyro.newest().1.and_then(|(newest, _)| self.gyro.at(newest));
        self.gyro.at(stamp).or_else(newest)
    }
}
