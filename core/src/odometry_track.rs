//! Where the base was in the odometer's frame, over the last moments: what brings a late scan to its own pose.

use crate::frames::{Pose2, Twist, interpolate2};
use crate::messages::Odometry;
use crate::time::Time;
use std::collections::VecDeque;

/// A short history of odom → base.
#[derive(Debug)]
pub struct OdometryTrack {
    history: VecDeque<(Time, Pose2)>,
    twist: Twist,
}

impl Default for OdometryTrack {
    fn default() -> Self {
        OdometryTrack::new()
    }
}

impl OdometryTrack {
    /// Long enough for a scan that is two seconds late at 200 readings a second.
    const LENGTH: usize = 400;

    /// A velocity says nothing about later than this, seconds.
    const CARRY_ON_S: f64 = 0.2;

    /// A base that has not moved.
    pub fn new() -> OdometryTrack {
        OdometryTrack { history: VecDeque::with_capacity(Self::LENGTH + 1), twist: Twist::ZERO }
    }

    /// Takes in a reading; one that is older than the newest is sorted in.
    pub fn push(&mut self, stamp: Time, odometry: &Odometry) {
        let at = self.history.partition_point(|(t, _)| *t <= stamp);
        if at == self.history.len() {
            self.twist = odometry.twist;
        }
        self.history.insert(at, (stamp, odometry.odom_from_base));
        if self.history.len() > Self::LENGTH {
            self.history.pop_front();
        }
    }

    /// The newest pose; the identity before there is any.
    pub fn now(&self) -> Pose2 {
        self.history.back().map_or_else(Pose2::identity, |(_, pose)| *pose)
    }

    /// The newest pose carried on by the newest velocity, for as long as a reading may reasonably take.
    pub fn now_at(&self, now: Time) -> Pose2 {
        let age_s = self.stamp().map_or(0.0, |stamp| (now - stamp).as_secs());
        self.now() * self.twist.integrate(age_s.clamp(0.0, Self::CARRY_ON_S))
    }

    /// The newest velocity.
    pub fn twist(&self) -> Twist {
        self.twist
    }

    /// When the newest reading was made.
    pub fn stamp(&self) -> Option<Time> {
        self.history.back().map(|(stamp, _)| *stamp)
    }

    /// The pose at a time: between two readings on the straight line, before and after them the nearest.
    pub fn at(&self, time: Time) -> Pose2 {
        let after = self.history.partition_point(|(t, _)| *t <= time);
        let before = after.checked_sub(1).and_then(|idx| self.history.get(idx));
        match (before, self.history.get(after)) {
            (Some((t0, a)), Some((t1, b))) => {
                let part = (time - *t0).as_secs() / (*t1 - *t0).as_secs();
                interpolate2(a, b, part)
            }
            (Some((_, pose)), None) | (None, Some((_, pose))) => *pose,
            (None, None) => Pose2::identity(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::pose2;

    #[test]
    fn between_readings_the_velocity_carries_the_pose_on_but_not_for_ever() {
        let mut track = OdometryTrack::new();
        assert_eq!(track.now_at(Time::from_secs(3.0)), Pose2::identity());
        let odometry = Odometry { twist: Twist::new(2.0, 0.0), ..Odometry::default() };
        track.push(Time::from_secs(1.0), &odometry);
        assert!((track.now_at(Time::from_secs(1.05)).translation.x - 0.1).abs() < 1e-12);
        assert!((track.now_at(Time::from_secs(9.0)).translation.x - 0.4).abs() < 1e-12);
    }

    #[test]
    fn a_pose_between_two_readings_turns_the_short_way_round() {
        let mut track = OdometryTrack::new();
        for (seconds, yaw) in [(1.0, 3.1), (0.0, 0.0), (2.0, -3.1)] {
            let odom_from_base = pose2(seconds, 0.0, yaw);
            track.push(Time::from_secs(seconds), &Odometry { odom_from_base, ..Odometry::default() });
        }
        let mid = track.at(Time::from_secs(1.5));
        assert!((mid.translation.x - 1.5).abs() < 1e-12);
        assert!((mid.rotation.angle().abs() - std::f64::consts::PI).abs() < 1e-9);
        assert_eq!(track.at(Time::from_secs(9.0)).translation.x, 2.0);
        assert_eq!(track.at(Time(-5)).translation.x, 0.0);
        assert_eq!(track.stamp(), Some(Time::from_secs(2.0)));
    }
}
