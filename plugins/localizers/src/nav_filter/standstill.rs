//! Does the robot stand? Scans say so: matches over half a second that do not lead away.

use std::collections::VecDeque;

use rumbo_core::frames::Pose2;
use rumbo_core::time::{Span, Time};

/// The poses of the last moments.
#[derive(Debug, Clone, Default)]
pub struct Standstill {
    poses: VecDeque<(Time, Pose2)>,
}

impl Standstill {
    /// So long it has to stand before it is said to.
    const WINDOW: Span = Span(500_000_000);
    /// Within this it has not moved, meters: more than matches err by, less than the slowest drive of 1 cm/s makes.
    const WITHIN_M: f64 = 0.004;
    /// Within this it has not turned, radians.
    const WITHIN_RAD: f64 = 0.004;
    /// So many poses are remembered at most: half a second of the fastest scanners.
    const MOST: usize = 256;

    /// Takes in the pose of a scan; whether the robot stands.
    pub fn see(&mut self, stamp: Time, odom_from_base: &Pose2) -> bool {
        let has_moved = self.poses.iter().any(|(_, pose)| {
            let step = pose.inverse() * odom_from_base;
            step.translation.vector.norm() > Self::WITHIN_M || step.rotation.angle().abs() > Self::WITHIN_RAD
        });
        if has_moved {
            self.poses.clear();
        }
        let is_long = self.poses.front().is_some_and(|(first, _)| stamp - *first >= Self::WINDOW);
        while self.poses.len() >= Self::MOST
            || self.poses.get(1).is_some_and(|(second, _)| stamp - *second >= Self::WINDOW)
        {
            self.poses.pop_front();
        }
        self.poses.push_back((stamp, *odom_from_base));
        is_long
    }

    /// Nobody knows what happened.
    pub fn forget(&mut self) {
        self.poses.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    fn stands_at(speed_m_s: f64, turn_rad_s: f64, rate_hz: f64) -> Option<f64> {
        let mut still = Standstill::default();
        (0..400).map(|k| f64::from(k) / rate_hz).find(|t| {
            let pose = pose2(speed_m_s * t, 0.0, turn_rad_s * t);
            still.see(Time::from_secs(*t), &pose)
        })
    }

    #[test]
    fn only_what_has_not_moved_for_half_a_second_stands() {
        for rate_hz in [5.0, 40.0, 200.0] {
            let at_s = stands_at(0.0, 0.0, rate_hz).unwrap();
            assert!((0.49..0.61).contains(&at_s), "{at_s} at {rate_hz}");
            assert_eq!(stands_at(0.02, 0.0, rate_hz), None, "slow is not standing");
            assert_eq!(stands_at(0.0, 0.02, rate_hz), None);
        }
    }

    #[test]
    fn it_moves_as_soon_as_it_has_moved() {
        let mut still = Standstill::default();
        let pose = pose2(1.0, 2.0, 3.0);
        assert!((0..30).map(|k| still.see(Time(k * 50_000_000), &pose)).last().unwrap());
        assert!(!still.see(Time(1_500_000_000), &(pose * pose2(0.01, 0.0, 0.0))));
        still.forget();
        assert!(!still.see(Time(9_000_000_000), &pose));
    }
}
