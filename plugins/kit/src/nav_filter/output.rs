//! What the filter says: how it is, where the robot is, and how sure that is.

use nalgebra::{Matrix6, Rotation2, SMatrix};
use rumbo_core::frames::{Pose2, Pose3, Twist, lift};
use rumbo_core::time::Time;

use super::euler::angles_by_errors;
use super::filter::{NavCounts, NavFilter};
use super::model::{ATTITUDE, Covariance, NavState, POSITION};
use super::moment::Moment;

/// How the filter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NavStatus {
    /// There was no sample yet.
    NotInitialized,
    /// It goes on.
    Ok,
    /// There was no sample for long.
    Stale,
}
/// Where the robot is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NavOutput {
    /// When.
    pub stamp: Time,
    /// The body in the frame that began where the filter began.
    pub odom_from_base: Pose3,
    /// Covariance of x, y, z, roll, pitch, yaw in that frame's axes.
    pub covariance: Matrix6<f64>,
    /// Velocity over the floor, and turning rate about the vertical.
    pub twist: Twist,
    /// Place and yaw by velocity and rates alone: they never jump.
    pub dead_reckoned: Pose2,
}
impl NavFilter {
    /// How it is at this time.
    pub fn status(&self, now: Time) -> NavStatus {
        match self.history.now() {
            None => NavStatus::NotInitialized,
            Some(last) if now - last.stamp > self.settings.stale_after => NavStatus::Stale,
            Some(_) => NavStatus::Ok,
        }
    }

    /// What became of all that came in.
    pub fn counts(&self) -> NavCounts {
        self.counts
    }

    /// The state in the frame of the last step, and its covariance; none before the first sample.
    pub fn state(&self) -> Option<(&NavState, &Covariance)> {
        self.history.now().map(|now| (&now.state, &now.covariance))
    }

    /// How many moments are kept for measurements that come late.
    pub fn n_moments(&self) -> usize {
        self.history.len()
    }

    /// Where the robot is, as of the newest sample; at `now`, for how sure it is of roll and pitch without news.
    pub fn output(&self, now: Time) -> Option<NavOutput> {
        let moment = self.history.now()?;
        let state = &moment.state;
        let odom_from_base =
            lift(&self.odom_from_anchor) * Pose3::from_parts(state.position_m.into(), state.nav_from_body);
        let mut covariance = self.spatial_covariance(moment);
        if self.status(now) == NavStatus::Stale {
            let grown = (self.settings.stale_rad_s * (now - moment.stamp).as_secs()).powi(2);
            covariance[(3, 3)] += grown;
            covariance[(4, 4)] += grown;
        }
        let floor = Rotation2::new(-state.yaw_rad()) * state.velocity_m_s.xy();
        let rates = state.nav_from_body * (moment.sample.rates_rad_s - state.gyro_bias_rad_s);
        let twist = Twist { forward_m_s: floor.x, left_m_s: floor.y, turn_rad_s: rates.z };
        let dead_reckoned = self.dead_reckoned;
        Some(NavOutput { stamp: moment.stamp, odom_from_base, covariance, twist, dead_reckoned })
    }

    /// Covariance of x, y, z, roll, pitch, yaw.
    fn spatial_covariance(&self, moment: &Moment) -> Matrix6<f64> {
        let mut by_errors = SMatrix::<f64, 6, 15>::zeros();
        let turn = self.odom_from_anchor.rotation.to_rotation_matrix();
        by_errors.fixed_view_mut::<2, 2>(0, POSITION).copy_from(turn.matrix());
        by_errors[(2, POSITION + 2)] = 1.0;
        let angles = angles_by_errors(&moment.state.nav_from_body);
        by_errors.fixed_view_mut::<3, 3>(3, ATTITUDE).copy_from(&angles);
        let own = by_errors * moment.covariance * by_errors.transpose();
        // The anchor's yaw moves what lies ahead of it sideways.
        let way = turn * moment.state.position_m.xy();
        let mut by_anchor = SMatrix::<f64, 6, 3>::zeros();
        by_anchor[(0, 0)] = 1.0;
        by_anchor[(1, 1)] = 1.0;
        by_anchor[(5, 2)] = 1.0;
        by_anchor[(0, 2)] = -way.y;
        by_anchor[(1, 2)] = way.x;
        let common = by_anchor * moment.by_anchor * by_errors.transpose();
        let sum =
            own + by_anchor * self.anchor_covariance * by_anchor.transpose() + common + common.transpose();
        (sum + sum.transpose()) * 0.5
    }
}
