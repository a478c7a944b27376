//! The lane between what stands beside the robot: where the estimate says that the line is free and the scanner says that
//! a wall is near, the robot gives way before the guard has to hold it.

use super::front_watch::Scene;
use crate::sightings::{Sightings, Source};

/// Sideways moves, to the left, that leave room on both sides: from `lowest_m` to `highest_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lane {
    /// The robot must move at least so far to the left; below zero it may move to the right by as much.
    pub lowest_m: f64,
    /// The robot may move so far to the left; below zero it must move to the right by as much.
    pub highest_m: f64,
}

/// What the lane leaves room for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneTuning {
    /// Half the width that the hull sweeps, meters.
    pub half_hull_m: f64,
    /// Room between the hull and what stands beside it, meters; zero for no lane at all.
    pub keep_off_m: f64,
}

impl Lane {
    /// Nothing stands beside the robot.
    pub const FREE: Lane = Lane { lowest_m: f64::NEG_INFINITY, highest_m: f64::INFINITY };
    /// What is farther ahead than this can wait, meters.
    const AHEAD_M: f64 = 0.5;
    /// What is nearer to the robot's axis than this part of the hull is in front of it, not beside it.
    const BESIDE: f64 = 0.75;

    /// The lane for the next piece of the way, of which `left_m` are left.
    pub fn between(sightings: &Sightings, scene: &Scene<'_>, tuning: &LaneTuning, left_m: f64) -> Lane {
        let mut lane = Lane::FREE;
        if tuning.keep_off_m <= 0.0 {
            return lane;
        }
        let base_from_odom = scene.odom_from_base.inverse();
        let lasers = sightings.iter().filter(|sighting| sighting.source == Source::Laser);
        for point in lasers.flat_map(|sighting| &sighting.odom_points) {
            let in_base = base_from_odom * point;
            let beside_m = in_base.y.abs() - tuning.half_hull_m - tuning.keep_off_m;
            let counts = in_base.x > 0.0
                && in_base.x <= left_m.min(Self::AHEAD_M)
                && in_base.y.abs() >= Self::BESIDE * tuning.half_hull_m;
            if counts && in_base.y < 0.0 {
                lane.lowest_m = lane.lowest_m.max(-beside_m);
            } else if counts {
                lane.highest_m = lane.highest_m.min(beside_m);
            }
        }
        lane
    }

    /// The offset from its line that keeps a robot in the lane which is `lateral_m` beside it now: none where the line is
    /// in the lane, the middle where the lane is too narrow.
    pub fn aside_m(&self, lateral_m: f64) -> f64 {
        let (lowest_m, highest_m) = (lateral_m + self.lowest_m, lateral_m + self.highest_m);
        if lowest_m > highest_m { (lowest_m + highest_m) / 2.0 } else { 0f64.clamp(lowest_m, highest_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_stays_on_its_line_where_that_is_free_and_in_the_middle_where_nothing_is() {
        assert_eq!(Lane::FREE.aside_m(0.03), 0.0);
        // A wall on the right that is 5 cm too near: to the left, whatever the robot has given way already.
        let right = Lane { lowest_m: 0.05, highest_m: f64::INFINITY };
        assert!((right.aside_m(0.0) - 0.05).abs() < 1e-12 && (right.aside_m(0.02) - 0.07).abs() < 1e-12);
        // It stays there when it has given way, and comes back as the wall ends.
        assert!((Lane { lowest_m: 0.0, ..right }.aside_m(0.07) - 0.07).abs() < 1e-12);
        assert_eq!(Lane { lowest_m: -0.2, ..right }.aside_m(0.07), 0.0);
        let left = Lane { lowest_m: f64::NEG_INFINITY, highest_m: -0.05 };
        assert!((left.aside_m(0.0) + 0.05).abs() < 1e-12);
        let narrow = Lane { lowest_m: 0.04, highest_m: -0.02 };
        assert!((narrow.aside_m(0.0) - 0.01).abs() < 1e-12);
    }
}
