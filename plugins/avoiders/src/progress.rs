//! Notices a robot that is told to move and does not: the guard holds it, or its wheels spin.

use rumbo_core::frames::{Pose2, Twist};
use rumbo_core::time::{Span, Time};

/// Compares what was asked for with what the odometer says.
#[derive(Debug)]
pub struct Progress {
    window: Span,
    began: Option<Began>,
}

#[derive(Debug, Clone, Copy)]
struct Began {
    stamp: Time,
    /// 0 for a turn in place, else the sign of the speed: what is done back undoes what was done ahead.
    direction: f64,
    odom_from_base: Pose2,
    last: Time,
    asked: f64,
}

impl Progress {
    /// Less than this part of what was asked for is standing.
    const LEAST_PART: f64 = 0.2;

    /// A watch that looks at spans of `window`.
    pub fn new(window: Span) -> Progress {
        Progress { window, began: None }
    }

    /// The robot is told to stand.
    pub fn rest(&mut self) {
        self.began = None;
    }

    /// The robot is told to move so: true once it has not done it for the whole window.
    pub fn is_stuck(&mut self, now: Time, twist: Twist, odom_from_base: &Pose2) -> bool {
        let turns = twist.speed_m_s() == 0.0;
        let rate = if turns { twist.turn_rad_s.abs() } else { twist.speed_m_s() };
        let direction = if turns { 0.0 } else { 1.0_f64.copysign(twist.forward_m_s) };
        let fresh = Began { stamp: now, direction, odom_from_base: *odom_from_base, last: now, asked: 0.0 };
        let Some(began) = self.began.as_mut().filter(|began| began.direction == direction) else {
            self.began = Some(fresh);
            return false;
        };
        began.asked += rate * (now - began.last).as_secs();
        began.last = now;
        if now - began.stamp < self.window {
            return false;
        }
        let motion = began.odom_from_base.inverse() * odom_from_base;
        let done = if turns { motion.rotation.angle().abs() } else { motion.translation.vector.norm() };
        let stuck = done < Self::LEAST_PART * began.asked;
        self.began = Some(fresh);
        stuck
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    /// First second at which a robot that does `part` of what it is told counts as stuck.
    fn stuck_after(twist: Twist, part: f64) -> Option<i32> {
        let mut progress = Progress::new(Span::from_secs(3.0));
        (0..=200).find_map(|k| {
            let t = f64::from(k) * 0.1;
            let odom_from_base = twist.scaled(part).integrate(t);
            progress.is_stuck(Time::from_secs(t), twist, &odom_from_base).then_some(k / 10)
        })
    }

    #[test]
    fn only_a_robot_that_hardly_moves_is_stuck() {
        for twist in
            [Twist::new(0.05, 0.0), Twist::new(0.2, 0.01), Twist::new(0.0, -0.05), Twist::new(0.0, 0.15)]
        {
            assert_eq!(stuck_after(twist, 1.0), None);
            assert_eq!(stuck_after(twist, 0.5), None);
            assert_eq!(stuck_after(twist, 0.1), Some(3));
            assert_eq!(stuck_after(twist, 0.0), Some(3));
        }
    }

    #[test]
    fn every_new_movement_gets_its_own_time() {
        let mut progress = Progress::new(Span::from_secs(3.0));
        let still = pose2(1.0, 2.0, 3.0);
        for k in 0..300 {
            let twist = if k % 20 < 10 { Twist::new(0.1, 0.0) } else { Twist::new(0.0, 0.1) };
            assert!(!progress.is_stuck(Time::from_secs(f64::from(k) * 0.1), twist, &still));
        }
        for k in 300..600 {
            let twist = Twist::new(if k % 40 < 20 { 0.1 } else { -0.1 }, 0.05);
            assert!(!progress.is_stuck(Time::from_secs(f64::from(k) * 0.1), twist, &still));
        }
        progress.rest();
        assert!(!progress.is_stuck(Time::from_secs(99.0), Twist::new(0.1, 0.0), &still));
    }
}
