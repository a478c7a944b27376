//! The motion that a localizer asked for, carried out slowly by the odometer.

use crate::frames::{Pose2, Twist, wrap_angle};
use crate::messages::Wish;

/// A wish on its way.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WishMotion {
    wish: Option<Wish>,
    last: Option<Pose2>,
    turned_rad: f64,
}

impl WishMotion {
    const SPEED_M_S: f64 = 0.05;
    const TURN_RAD_S: f64 = 0.05;
    /// Nearer than this is done, meters and radians.
    const DONE: f64 = 0.01;

    /// Takes on a new wish; one that is under way goes on.
    pub fn take(&mut self, wish: Option<Wish>) {
        if self.wish.is_none() {
            *self = WishMotion { wish, last: None, turned_rad: 0.0 };
        }
    }

    /// Drops the wish.
    pub fn clear(&mut self) {
        *self = WishMotion::default();
    }

    /// The velocity that carries it out from here.
    pub fn steer(&mut self, odom_from_base: Pose2) -> Twist {
        let last = *self.last.get_or_insert(odom_from_base);
        match self.wish {
            Some(Wish::TurnBy(turn_rad)) => {
                // Turns add up step by step, so that more than half a turn can be asked for.
                self.turned_rad += wrap_angle(odom_from_base.rotation.angle() - last.rotation.angle());
                self.last = Some(odom_from_base);
                self.go(turn_rad - self.turned_rad, |sign| Twist::new(0.0, sign * Self::TURN_RAD_S))
            }
            Some(Wish::MoveBy(way_m)) => {
                let moved_m = (last.inverse() * odom_from_base).translation.x;
                self.go(way_m - moved_m, |sign| Twist::new(sign * Self::SPEED_M_S, 0.0))
            }
            Some(Wish::HoldStill) | None => {
                self.clear();
                Twist::ZERO
            }
        }
    }

    fn go(&mut self, left: f64, twist: impl Fn(f64) -> Twist) -> Twist {
        if left.abs() <= Self::DONE {
            self.clear();
            return Twist::ZERO;
        }
        twist(left.signum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes_end_after_the_way_that_was_asked_for_in_both_directions() {
        for wish in [Wish::TurnBy(4.0), Wish::TurnBy(-1.0), Wish::MoveBy(0.3), Wish::MoveBy(-0.3)] {
            let (mut motion, mut pose, mut n) = (WishMotion::default(), Pose2::identity(), 0);
            motion.take(Some(wish));
            loop {
                let twist = motion.steer(pose);
                if twist == Twist::ZERO {
                    break;
                }
                pose *= twist.integrate(0.1);
                n += 1;
                assert!(n < 2000);
            }
            match wish {
                Wish::TurnBy(by) => assert!(wrap_angle(pose.rotation.angle() - by).abs() < 0.02, "{wish:?}"),
                Wish::MoveBy(by) => assert!((pose.translation.x - by).abs() < 0.02, "{wish:?}"),
                Wish::HoldStill => {}
            }
        }
    }
}
