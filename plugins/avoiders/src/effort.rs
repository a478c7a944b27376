//! Notices a robot that is told to move and does not, also one whose way turns back on itself: what counts is the way that
//! was driven and turned, not where it led.

use rumbo_core::frames::{Pose2, Twist};
use rumbo_core::time::{Span, Time};

/// What was asked for, and what the odometer says was done, since a window began.
#[derive(Debug)]
pub struct Effort {
    window: Span,
    /// A turn counts as the way of a point this far from the middle, meters.
    lever_m: f64,
    began: Option<Time>,
    last: Option<(Time, Pose2)>,
    asked_m: f64,
    done_m: f64,
}

impl Effort {
    /// Less than this part of what was asked for is standing.
    const LEAST_PART: f64 = 0.2;

    /// A watch that looks at spans of `window`.
    pub fn new(window: Span, lever_m: f64) -> Effort {
        Effort { window, lever_m, began: None, last: None, asked_m: 0.0, done_m: 0.0 }
    }

    /// The robot is told to stand.
    pub fn rest(&mut self) {
        (self.began, self.last) = (None, None);
    }

    /// The robot is told to move so: true once it has not done it for a whole window.
    pub fn is_in_vain(&mut self, now: Time, told: Twist, odom_from_base: &Pose2) -> bool {
        let Some((before, odom_from_then)) = self.last.replace((now, *odom_from_base)) else {
            (self.began, self.asked_m, self.done_m) = (Some(now), 0.0, 0.0);
            return false;
        };
        let motion = odom_from_then.inverse() * odom_from_base;
        self.done_m += motion.translation.vector.norm() + motion.rotation.angle().abs() * self.lever_m;
        self.asked_m += (told.speed_m_s() + told.turn_rad_s.abs() * self.lever_m) * (now - before).as_secs();
        if self.began.is_none_or(|began| now - began < self.window) {
            return false;
        }
        let is_in_vain = self.done_m < Self::LEAST_PART * self.asked_m;
        (self.began, self.asked_m, self.done_m) = (Some(now), 0.0, 0.0);
        is_in_vain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    /// Second at which a robot that does `part` of what it is told, to and fro, counts as stuck.
    fn in_vain_after(twist: Twist, part: f64) -> Option<i32> {
        let mut effort = Effort::new(Span::from_secs(4.0), 0.3);
        let mut pose = pose2(1.0, 2.0, 3.0);
        (0..=300).find_map(|k| {
            let told = if k % 20 < 10 { twist } else { twist.scaled(-1.0) };
            let is_in_vain = effort.is_in_vain(Time::from_secs(0.1 * f64::from(k)), told, &pose);
            pose *= told.scaled(part).integrate(0.1);
            is_in_vain.then_some(k / 10)
        })
    }

    #[test]
    fn only_a_robot_that_hardly_moves_is_stuck_wherever_its_way_leads() {
        for twist in [Twist::new(0.3, 0.0), Twist::new(0.2, 0.5), Twist::new(0.0, -0.4)] {
            assert_eq!(in_vain_after(twist, 1.0), None);
            assert_eq!(in_vain_after(twist, 0.5), None);
            assert_eq!(in_vain_after(twist, 0.1), Some(4));
            assert_eq!(in_vain_after(twist, 0.0), Some(4));
        }
    }
}
