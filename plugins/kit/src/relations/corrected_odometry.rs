//! Sparse good poses, with odometry between them.

use rumbo_core::frames::Pose3;
use rumbo_core::time::{Span, Time};

use super::pose_near;
use crate::trajectory::Trajectory;

/// The odometer is taken to move straight between readings this far apart.
pub const ODOMETRY_GAP: Span = Span(1_000_000_000);

/// Poses at any time of a log: the nearest known one, moved on (or back) as the odometer moved since (or until) then.
#[derive(Debug, Clone, Copy)]
pub struct CorrectedOdometry<'a> {
    /// The known poses.
    pub poses: &'a Trajectory,
    /// The odometer's.
    pub odometry: &'a Trajectory,
    /// Stamps that differ by no more than this are the same.
    pub tolerance: Span,
}

impl CorrectedOdometry<'_> {
    /// The pose at a stamp; none where the odometer has no reading about there.
    pub fn pose_at(&self, stamp: Time) -> Option<Pose3> {
        // Stamps of relations are rounded, those of the log are not.
        let stamp = self
            .odometry
            .nearest(stamp)
            .map(|read| read.stamp)
            .filter(|read| self.is_same(*read, stamp))
            .unwrap_or(stamp);
        let known = self.poses.nearest(stamp)?;
        if self.is_same(known.stamp, stamp) {
            return Some(known.world_from_body);
        }
        let odom_from_known = self.odometer_at(known.stamp)?;
        let odom_from_base = self.odometer_at(stamp)?;
        Some(known.world_from_body * odom_from_known.inverse() * odom_from_base)
    }

    fn is_same(&self, a: Time, b: Time) -> bool {
        (a - b).0.abs() <= self.tolerance.0
    }

    fn odometer_at(&self, stamp: Time) -> Option<Pose3> {
        let read = pose_near(self.odometry, stamp, self.tolerance);
        read.or_else(|| self.odometry.between(stamp, ODOMETRY_GAP))
    }
}
