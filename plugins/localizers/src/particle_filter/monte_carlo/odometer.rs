//! What the filter makes of the odometer's readings, also of those that jump.

use super::MonteCarlo;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Check, Odometry};
use rumbo_core::time::Time;
use rumbo_kit::odometry_history::{Reading, is_jump};

impl MonteCarlo {
    /// Standard deviation of the heading after a jump, radians.
    const JUMP_RAD: f64 = 0.5;

    /// Takes in a reading.
    pub(super) fn take_odometry(&mut self, stamp: Time, odometry: &Odometry) {
        if odometry.check().is_err() {
            self.counters.odometry_dropped += 1;
            return;
        }
        let last = self.odometry.newest();
        match last {
            // A newer reading before the push: the way between the two is what counts.
            Some((before, odom_from_last)) if stamp > before => {
                let elapsed_s = (stamp - before).as_secs();
                self.silence.add(elapsed_s);
                let [speed_m_s, _] = self.settings.max_speed;
                if is_jump(
                    &odom_from_last,
                    &odometry.odom_from_base,
                    self.settings.max_odom_jump_m + 2.0 * speed_m_s * elapsed_s,
                ) {
                    self.jump(odom_from_last, odometry.odom_from_base);
                }
            }
            None => self.take_first_reading(odometry),
            _ => {}
        }
        if self.odometry.push(stamp, odometry.odom_from_base) == Reading::Stale {
            self.counters.odometry_dropped += 1;
        }
        self.last_noise = odometry.noise;
    }

    /// The prior may have been made before the odometer had said anything: then its reading there is a guess.
    fn take_first_reading(&mut self, odometry: &Odometry) {
        let jump_m = self.settings.max_odom_jump_m;
        if let Some(anchor) = &mut self.anchor
            && is_jump(&anchor.odom_from_base, &odometry.odom_from_base, jump_m)
        {
            anchor.odom_from_base = odometry.odom_from_base;
        }
    }

    /// The odometer was restarted or lifted: the robot is about where it was, and goes on from the new reading.
    fn jump(&mut self, odom_from_last: Pose2, odom_from_base: Pose2) {
        self.counters.odometry_jumps += 1;
        let Some(anchor) = self.anchor.take() else { return };
        self.filter.advance(&anchor.odom_from_base, &odom_from_last);
        self.filter.widen(self.settings.max_odom_jump_m, Self::JUMP_RAD);
        self.odometry.clear();
        self.queue.clear();
        self.too_soon.clear();
        self.is_first = true;
        self.set_anchor(odom_from_base, anchor.stamp, anchor.scans);
    }
}
