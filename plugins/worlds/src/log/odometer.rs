//! Velocity of a recorded odometer, which many logs leave at zero.

use rumbo_core::frames::{Pose2, Twist};
use rumbo_core::messages::Odometry;
use rumbo_core::time::{Span, Time};
use rumbo_kit::log_file::mean_twist;

/// Turns recorded poses into odometry with a velocity.
#[derive(Debug, Default)]
pub(super) struct Odometer {
    last: Option<Time>,
    reference: Option<(Time, Pose2)>,
    next_reference: Option<(Time, Pose2)>,
    is_told: bool,
}

impl Odometer {
    /// Readings may be less than a millisecond apart; over so long a difference is a velocity.
    const BASELINE: Span = Span(100_000_000);

    /// Errors of recorded robots, standard deviations: m/m, rad/m, rad/rad. No log says them.
    const NOISE: [f64; 3] = [0.05, 0.02, 0.05];

    /// A reading; none where it is not newer than the one before it.
    pub fn read(&mut self, stamp: Time, odom_from_base: Pose2, told: Option<Twist>) -> Option<Odometry> {
        if self.last.is_some_and(|last| stamp <= last) {
            return None;
        }
        self.last = Some(stamp);
        // A robot that stands still tells zero, too: only a log that once told a velocity is believed.
        self.is_told |= told.is_some_and(|twist| twist != Twist::ZERO);
        let seen = self.velocity(stamp, odom_from_base);
        let twist = told.filter(|_| self.is_told).unwrap_or(seen);
        Some(Odometry { odom_from_base, twist, noise: Self::NOISE })
    }

    fn velocity(&mut self, stamp: Time, odom_from_base: Pose2) -> Twist {
        let here = (stamp, odom_from_base);
        if self.next_reference.is_none_or(|(t, _)| stamp - t >= Self::BASELINE) {
            self.reference = self.next_reference.replace(here).or(Some(here));
        }
        let (t, pose) = self.reference.unwrap_or(here);
        mean_twist(&pose, &odom_from_base, (stamp - t).as_secs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    #[test]
    fn poses_a_millisecond_apart_give_the_velocity_of_a_tenth_of_a_second() {
        let mut odometer = Odometer::default();
        for k in 0..2000 {
            // One millisecond of clock jitter would be a hundredfold velocity between neighbors.
            let jitter = if k % 7 == 0 { 900_000 } else { 0 };
            let stamp = Time(k * 1_000_000 + jitter);
            let read = odometer.read(stamp, pose2(0.0005 * k as f64, 0.0, 0.0), Some(Twist::ZERO)).unwrap();
            assert!(k < 100 || (read.twist.forward_m_s - 0.5).abs() < 0.01, "{k}: {:?}", read.twist);
        }
        assert_eq!(odometer.read(Time(0), Pose2::identity(), None), None, "older than the last");
    }

    #[test]
    fn a_log_that_tells_velocities_is_believed_when_it_tells_zero() {
        let mut odometer = Odometer::default();
        let told = Some(Twist::new(0.3, 0.1));
        assert_eq!(odometer.read(Time(0), Pose2::identity(), told).map(|o| o.twist), told);
        let still = odometer.read(Time(1_000_000_000), pose2(1.0, 0.0, 0.0), Some(Twist::ZERO)).unwrap();
        assert_eq!(still.twist, Twist::ZERO);
    }
}
