//! What is said of the robot.

use super::Tracker;
use super::odometer::unmeasured;
use crate::rbpf_slam::motion::Step;
use crate::rbpf_slam::proposal::difference;
use crate::unseen::is_unsure;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Estimate, Status};
use rumbo_core::time::Time;

/// Without a scan for so long the robot is followed by the odometer alone, seconds.
pub(super) const SCANLESS_S: f64 = 2.0;

impl Tracker {
    /// Where the robot is now.
    pub fn estimate(&self, now: Time) -> Estimate {
        let Some(best) = self.filter.best() else { return Estimate::lost(now) };
        let (mut stamp, step) = self.odometer.ahead(self.stamp, now);
        let start_from_scan = best.map_from_base * self.step_from_base;
        let map_from_scan = self.map_from_start * start_from_scan;
        let map_from_base = map_from_scan * step.before_from_after;
        let followed = self.since_step.then(&step);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), self.map_from_start.rotation.angle());
        let in_start = self.covariance + self.spread(&best.map_from_base);
        let mut covariance = turn.matrix() * in_start * turn.matrix().transpose();
        let is_blind = step != Step::default() || self.n_unmatched > 0;
        if is_blind {
            covariance += self.settings.motion.covariance(&map_from_scan, &followed);
        }
        let silent_s = self.stamp.map_or(f64::INFINITY, |scan| (now - scan).as_secs());
        let is_old = silent_s > SCANLESS_S;
        if is_old && self.stamp == Some(stamp) {
            // Nobody says how it moved.
            stamp = now;
            covariance += Matrix3::from_diagonal(&unmeasured(silent_s).into());
        }
        covariance = (covariance + covariance.transpose()) * 0.5;
        let odom_from_base = self.odometer.newest_pose(stamp);
        let mut estimate = Estimate::planar(stamp, map_from_base, odom_from_base, covariance);
        estimate.status = if self.is_lost() {
            Status::Lost
        } else if self.n_unmatched > 0 || self.is_on_trial() || is_old || is_unsure(&covariance) {
            Status::Converging
        } else {
            Status::Tracking
        };
        estimate
    }

    /// How far the guesses are apart.
    fn spread(&self, map_from_best: &Pose2) -> Matrix3<f64> {
        let weights = self.filter.weights();
        let off =
            self.filter.particles().iter().map(|particle| difference(map_from_best, &particle.map_from_base));
        let weighed = || off.clone().zip(&weights);
        let mean = weighed().map(|(off, w)| off * *w).sum::<Vector3<f64>>();
        weighed().map(|(off, w)| (off - mean) * (off - mean).transpose() * *w).sum()
    }
}
