//! Poses over time, and the poses between them.

use std::collections::VecDeque;

use rumbo_core::frames::{Pose2, Twist, interpolate2};
use rumbo_core::time::{Span, Time};

type StampedPose = (Time, Pose2);

/// Poses sorted by their stamps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseTrack {
    poses: VecDeque<StampedPose>,
}

impl PoseTrack {
    /// Adds a pose; of two with the same stamp the first stays.
    pub fn push(&mut self, stamp: Time, map_from_base: Pose2) {
        let at = self.poses.partition_point(|(t, _)| *t < stamp);
        if self.poses.get(at).is_none_or(|(t, _)| *t != stamp) {
            self.poses.insert(at, (stamp, map_from_base));
        }
    }

    /// Drops poses that no question about `stamp` or later needs.
    pub fn forget_before(&mut self, stamp: Time) {
        while self.poses.get(1).is_some_and(|(t, _)| *t < stamp) {
            self.poses.pop_front();
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The first pose and its stamp.
    pub fn first(&self) -> Option<(Time, Pose2)> {
        self.poses.front().copied()
    }

    /// The last pose and its stamp.
    pub fn last(&self) -> Option<(Time, Pose2)> {
        self.poses.back().copied()
    }

    /// All of them, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = (Time, Pose2)> + '_ {
        self.poses.iter().copied()
    }

    /// The pose whose stamp is nearest to `stamp`, where it is within `tolerance`.
    pub fn exact(&self, stamp: Time, tolerance: Span) -> Option<Pose2> {
        let (before, after) = self.around(stamp);
        let off = |pose: &(Time, Pose2)| (pose.0 - stamp).0.abs();
        let nearest = before.into_iter().chain(after).min_by_key(off)?;
        (off(&nearest) <= tolerance.0).then_some(nearest.1)
    }

    /// The pose at `stamp`, straight between its neighbors; none outside, nor where these are more than `gap` apart.
    pub fn between(&self, stamp: Time, gap: Span) -> Option<Pose2> {
        let (before, after) = self.around(stamp);
        let (t0, a) = before?;
        if t0 == stamp {
            return Some(a);
        }
        let (t1, b) = after?;
        if t1 - t0 > gap {
            return None;
        }
        let part = (stamp - t0).as_secs() / (t1 - t0).as_secs();
        Some(interpolate2(&a, &b, part))
    }

    /// Velocity in the robot's own frame between the neighbors of `stamp`; zero where there are not two.
    pub fn twist(&self, stamp: Time) -> Twist {
        let (Some((t0, a)), Some((t1, b))) = self.around(stamp) else { return Twist::ZERO };
        mean_twist(&a, &b, (t1 - t0).as_secs())
    }

    /// The last pose at or before `stamp`, and the first after it.
    fn around(&self, stamp: Time) -> (Option<StampedPose>, Option<StampedPose>) {
        let after = self.poses.partition_point(|(t, _)| *t <= stamp);
        let before = after.checked_sub(1).and_then(|idx| self.poses.get(idx));
        (before.copied(), self.poses.get(after).copied())
    }
}

/// The velocity that leads from one pose to another, in the frame of the first; zero in no time.
pub fn mean_twist(from: &Pose2, to: &Pose2, seconds: f64) -> Twist {
    if seconds <= 0.0 {
        return Twist::ZERO;
    }
    let step = from.inverse() * to;
    Twist {
        forward_m_s: step.translation.x / seconds,
        left_m_s: step.translation.y / seconds,
        turn_rad_s: step.rotation.angle() / seconds,
    }
}
