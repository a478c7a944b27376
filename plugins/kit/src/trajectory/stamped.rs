//! Poses in the order of their stamps.

use rumbo_core::frames::Pose3;
use rumbo_core::time::{Span, Time};

/// A pose at a time.
#[doc(alias = "geometry_msgs/PoseStamped")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampedPose {
    /// When.
    pub stamp: Time,
    /// Where, in the trajectory's own world.
    pub world_from_body: Pose3,
}

/// Poses sorted by their stamps, no two at the same.
#[doc(alias = "nav_msgs/Path")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    poses: Vec<StampedPose>,
}

/// What had to be done to a list of poses to make a trajectory of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Repairs {
    /// Poses that came after one with a later stamp, and were sorted in.
    pub n_out_of_order: usize,
    /// Poses left out because an earlier one has the same stamp.
    pub n_repeated: usize,
}

impl Trajectory {
    /// Sorts poses by their stamps; of several with the same stamp the first stays.
    pub fn of(mut poses: Vec<StampedPose>) -> (Trajectory, Repairs) {
        let is_step_back = |pair: &&[StampedPose]| matches!(pair, [a, b] if b.stamp < a.stamp);
        let n_out_of_order = poses.windows(2).filter(is_step_back).count();
        poses.sort_by_key(|pose| pose.stamp);
        let n = poses.len();
        poses.dedup_by_key(|pose| pose.stamp);
        let n_repeated = n - poses.len();
        (Trajectory { poses }, Repairs { n_out_of_order, n_repeated })
    }

    /// The poses, oldest first.
    pub fn poses(&self) -> &[StampedPose] {
        &self.poses
    }

    /// The first and the last stamp; none of an empty trajectory.
    pub fn time_range(&self) -> Option<(Time, Time)> {
        Some((self.poses.first()?.stamp, self.poses.last()?.stamp))
    }

    /// The way from pose to pose.
    pub fn length_m(&self) -> f64 {
        let place = |pose: &StampedPose| pose.world_from_body.translation.vector;
        self.poses.iter().zip(self.poses.iter().skip(1)).map(|(a, b)| (place(b) - place(a)).norm()).sum()
    }

    /// The pose whose stamp is nearest, the earlier of two equally near ones; none of an empty trajectory.
    pub fn nearest(&self, stamp: Time) -> Option<&StampedPose> {
        let after = self.poses.partition_point(|pose| pose.stamp < stamp);
        let neighbors = self.poses.get(after.saturating_sub(1)..)?.iter().take(2);
        neighbors.min_by_key(|pose| (pose.stamp - stamp).0.abs())
    }

    /// The pose at a stamp, straight between its neighbors and turning evenly; none outside, nor where these are more
    /// than `gap` apart.
    pub fn between(&self, stamp: Time, gap: Span) -> Option<Pose3> {
        let after = self.poses.partition_point(|pose| pose.stamp < stamp);
        let late = self.poses.get(after)?;
        if late.stamp == stamp {
            return Some(late.world_from_body);
        }
        let early = self.poses.get(after.checked_sub(1)?)?;
        if late.stamp - early.stamp > gap {
            return None;
        }
        let share = (stamp - early.stamp).as_secs() / (late.stamp - early.stamp).as_secs();
        let (a, b) = (&early.world_from_body, &late.world_from_body);
        // Half a turn has no shortest way; the earlier pose is as good as any.
        Some(a.try_lerp_slerp(b, share, 1e-9).unwrap_or(*a))
    }
}
