//! Where will the next scan have been taken? The wheels say it, a gyroscope, or the motion before.

use super::front_end::Prediction;
use super::tracker::{BLIND_AFTER_S, Tracker};
use crate::gyro::Heading;
use nalgebra::UnitComplex;
use rumbo_core::frames::{Pose2, interpolate2};
use rumbo_core::time::Time;

/// Dead reckoning that may be farther off has nothing to be registered on, meters.
const MOST_OFF_M: f64 = 0.5;
/// Errors of a guess without an odometer, shares of the gap between two scans.
const GUESS_M_S: f64 = 1.0;
const GUESS_RAD_S: f64 = 1.0;
/// Errors of a turn by the gyroscope: at least, radians; a drift, rad/s; and a share of the turn.
const GYRO: [f64; 3] = [0.01, 0.01, 0.02];

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
                first_gate_m,
                is_far: false,
                is_blind: false,
            };
        };
        let seconds = (stamp - before.stamp).as_secs();
        let odom_from_base = self.odom_at(stamp);
        let [least_m, share_m, least_rad, share_rad] = self.settings.tie.odometer;
        let share = if before.seconds > 0.0 { (seconds / before.seconds).min(3.0) } else { 0.0 };
        let as_before = interpolate2(&Pose2::identity(), &before.motion, share);
        let (mut motion, mut deviation) = match (before.odom_from_base, odom_from_base) {
            (Some(last), Some(now)) => {
                let motion = last.inverse() * now;
                let off_m = least_m + share_m * motion.translation.vector.norm();
                (motion, [off_m, least_rad + share_rad * motion.rotation.angle().abs()])
            }
            _ => (as_before, [least_m + GUESS_M_S * seconds, least_rad + GUESS_RAD_S * seconds]),
        };
        let has_odometer = odom_from_base.is_some() && before.odom_from_base.is_some();
        let is_far = has_odometer && deviation[0] > MOST_OFF_M;
        let is_blind = !has_odometer && seconds > BLIND_AFTER_S;
        let heading = self.heading_at(stamp).zip(before.heading);
        if let Some(turn_rad) = heading.and_then(|(now, then)| now.since(&then)) {
            motion.rotation = UnitComplex::new(turn_rad);
            let [least_rad, drift_rad_s, share] = GYRO;
            deviation[1] = least_rad + drift_rad_s * seconds + share * turn_rad.abs();
        }
        let first_gate_m = (2.0 * deviation[0] + 10.0 * deviation[1]).clamp(0.3, 0.5);
        let here = self.frame_from_base;
        let without_odometer = (seconds <= BLIND_AFTER_S).then(|| [here, here * as_before]);
        Prediction {
            frame_from_base: here * motion,
            without_odometer,
            deviation,
            first_gate_m,
            is_far,
            is_blind,
        }
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
