//! How far the robot has turned, by the turning rates of an inertial unit.

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::time::Time;
use rumbo_kit::odometry_history::{OdometryHistory, Reading};

/// A turn that can be compared with others of the same unbroken run of readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Heading {
    /// Goes up at each gap in the readings.
    pub run: u32,
    /// Turned by so much since the run began, as a pose without a place.
    pub turn: Pose2,
}

/// Turns summed up from rates.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gyro {
    run: u32,
    turned: OdometryHistory,
}

/// Nobody knows how far a robot turns between readings farther apart than this, seconds.
const LONGEST_GAP_S: f64 = 0.25;

impl Gyro {
    /// Takes a rate about the base's vertical axis, rad/s; whether it came in order.
    pub fn take(&mut self, stamp: Time, rate_rad_s: f64) -> bool {
        let Some((last, turn)) = self.turned.newest() else {
            return self.turned.push(stamp, Pose2::identity()) == Reading::Newest;
        };
        let seconds = (stamp - last).as_secs();
        if seconds <= 0.0 {
            return false;
        }
        if seconds > LONGEST_GAP_S {
            self.begin_anew();
        }
        let more = if seconds > LONGEST_GAP_S { 0.0 } else { rate_rad_s * seconds };
        self.turned.push(stamp, turn * pose2(0.0, 0.0, more)) == Reading::Newest
    }

    /// What comes cannot be compared with what was.
    pub fn begin_anew(&mut self) {
        self.run = self.run.wrapping_add(1);
        self.turned.clear();
    }

    /// The heading at a time, if its readings reach so far.
    pub fn at(&self, stamp: Time) -> Option<Heading> {
        self.turned.at(stamp).map(|turn| Heading { run: self.run, turn })
    }

    /// Nothing better will be known of this time.
    pub fn is_past(&self, stamp: Time) -> bool {
        let broke_off = |(newest, _): (Time, Pose2)| (stamp - newest).as_secs() > LONGEST_GAP_S;
        self.turned.newest().is_none_or(broke_off) || self.turned.is_past(stamp)
    }

    /// The run, and the newest reading: all that the next ones depend on.
    pub fn newest(&self) -> (u32, Option<(Time, Pose2)>) {
        (self.run, self.turned.newest())
    }

    /// Goes on from a newest reading that was saved.
    pub fn go_on(run: u32, newest: Option<(Time, Pose2)>) -> Gyro {
        let mut gyro = Gyro { run, ..Gyro::default() };
        if let Some((stamp, turn)) = newest {
            gyro.turned.push(stamp, turn);
        }
        gyro
    }
}

impl Heading {
    /// The turn since an earlier one, radians; nothing where the readings broke off in between.
    pub fn since(&self, earlier: &Heading) -> Option<f64> {
        (self.run == earlier.run).then(|| (earlier.turn.inverse() * self.turn).rotation.angle())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_sum_up_to_turns_until_they_break_off() {
        let at = |k: u32| Time::from_secs(0.01 * f64::from(k));
        let mut gyro = Gyro::default();
        assert_eq!(gyro.at(at(0)), None);
        for k in 0..=1000 {
            assert!(gyro.take(at(k), 0.8));
        }
        assert!(!gyro.take(at(1000), 0.8), "the same moment again");
        assert!(gyro.is_past(at(1000)) && !gyro.is_past(at(1001)) && gyro.is_past(at(1026)), "it broke off");
        let (early, late) = (gyro.at(at(200)).unwrap(), gyro.at(at(550)).unwrap());
        assert!((late.since(&early).unwrap() - 2.8).abs() < 1e-9);
        let mut again = Gyro::go_on(gyro.newest().0, gyro.newest().1);
        gyro.take(at(1001), -0.5);
        again.take(at(1001), -0.5);
        assert_eq!(gyro.at(at(1001)), again.at(at(1001)));
        gyro.take(at(1100), 0.8);
        assert_eq!(gyro.at(at(1100)).unwrap().since(&late), None, "who knows what it did for a second");
    }
}
