//! A motion that was wished for, followed by the odometer.

use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::messages::Wish;
use rumbo_core::time::{Span, Time};

/// A wish on its way.
#[derive(Debug, Clone)]
pub struct Motion {
    wish: Wish,
    odom_from_start: Pose2,
    odom_from_last: Pose2,
    turned_rad: f64,
    least_left: f64,
    progress_at: Time,
}

/// Nearer than this is done: meters, or radians. Who obeys is more exact.
const DONE: f64 = 0.03;
/// Less than this is no progress: meters, or radians.
const PROGRESS: f64 = 0.01;
/// A robot that makes no progress for so long will not get there, seconds.
const PATIENCE_S: f64 = 10.0;

impl Motion {
    /// Begins at a pose of the odometer.
    pub fn new(wish: Wish, odom_from_base: Pose2, now: Time) -> Motion {
        Motion {
            wish,
            odom_from_start: odom_from_base,
            odom_from_last: odom_from_base,
            turned_rad: 0.0,
            least_left: f64::INFINITY,
            progress_at: now,
        }
    }

    /// Takes in where the odometer is now.
    pub fn follow(&mut self, odom_from_base: Pose2, now: Time) {
        // Step by step, so that half a turn and more is told from its opposite.
        self.turned_rad += wrap_angle(odom_from_base.rotation.angle() - self.odom_from_last.rotation.angle());
        self.odom_from_last = odom_from_base;
        let left = self.left().abs();
        if left < self.least_left - PROGRESS {
            self.least_left = left;
            self.progress_at = now;
        }
    }

    /// It is done, or it will never be.
    pub fn is_over(&self, now: Time) -> bool {
        self.left().abs() <= DONE || now - self.progress_at > Span::from_secs(PATIENCE_S)
    }

    /// What is left to be wished for.
    pub fn wish(&self) -> Wish {
        match self.wish {
            Wish::TurnBy(_) => Wish::TurnBy(self.left()),
            Wish::MoveBy(_) => Wish::MoveBy(self.left()),
            other => other,
        }
    }

    fn left(&self) -> f64 {
        match self.wish {
            Wish::TurnBy(turn_rad) => turn_rad - self.turned_rad,
            Wish::MoveBy(way_m) => {
                way_m - (self.odom_from_start.inverse() * self.odom_from_last).translation.x
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;
    use std::f64::consts::PI;

    #[test]
    fn more_than_half_a_turn_is_followed_either_way_and_half_a_turn_is_not_its_opposite() {
        for whole in [4.0, -4.0, PI, -PI] {
            let mut motion = Motion::new(Wish::TurnBy(whole), pose2(0.0, 0.0, 3.0), Time::ZERO);
            for k in 1..=100 {
                assert!(!motion.is_over(Time::ZERO), "{whole} {k}");
                let turned = whole * f64::from(k) / 100.0;
                motion.follow(pose2(0.0, 0.0, 3.0 + turned), Time::ZERO);
                let Wish::TurnBy(left) = motion.wish() else { panic!("it turns") };
                assert!((left - (whole - turned)).abs() < 1e-9);
            }
            assert!(motion.is_over(Time::ZERO));
        }
    }

    #[test]
    fn a_robot_that_does_not_move_is_not_waited_for_and_a_slow_one_is() {
        for speed_m_s in [0.0, 0.005, f64::NAN] {
            let mut motion = Motion::new(Wish::MoveBy(0.5), Pose2::identity(), Time::ZERO);
            let mut n = 0;
            while !motion.is_over(Time::from_secs(f64::from(n))) && n < 1000 {
                n += 1;
                let now = Time::from_secs(f64::from(n));
                motion.follow(pose2(speed_m_s * f64::from(n), 0.0, 0.0), now);
            }
            assert!(if speed_m_s > 0.0 { (90..100).contains(&n) } else { n < 15 }, "{speed_m_s}: {n}");
        }
    }
}
