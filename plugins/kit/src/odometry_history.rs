//! Where the base was in the odometer's frame, over the last moments.

use rumbo_core::frames::{Pose2, Twist, interpolate2};
use rumbo_core::time::{Span, Time};
use std::collections::VecDeque;

/// Readings of the odometer, sorted by stamp.
#[derive(Debug, Clone, Default)]
pub struct OdometryHistory {
    readings: VecDeque<(Time, Pose2)>,
}

/// What a reading was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The newest so far.
    Newest,
    /// One that came late and was sorted in.
    Late,
    /// There is one with this stamp, or it is older than everything that is kept: dropped.
    Stale,
}

/// Two readings lie farther apart than the robot can have come, meters.
pub fn is_jump(odom_from_last: &Pose2, odom_from_base: &Pose2, most_m: f64) -> bool {
    (odom_from_last.translation.vector - odom_from_base.translation.vector).norm() > most_m
}

impl OdometryHistory {
    /// Ten seconds at 200 readings a second.
    const MOST_READINGS: usize = 2000;
    const KEPT_S: f64 = 10.0;
    /// A scan may be this much newer than the newest reading.
    const EXTRAPOLATED_S: f64 = 0.05;
    /// Where the velocity is known, a reading of another kind may be this much newer.
    const MOST_AHEAD: Span = Span(500_000_000);

    /// Takes in a reading.
    pub fn push(&mut self, stamp: Time, odom_from_base: Pose2) -> Reading {
        let at = self.readings.partition_point(|(t, _)| *t < stamp);
        let is_twin = self.readings.get(at).is_some_and(|(t, _)| *t == stamp);
        let is_newest = at == self.readings.len();
        if is_twin || at == 0 && !is_newest {
            return Reading::Stale;
        }
        self.readings.insert(at, (stamp, odom_from_base));
        let newest = self.readings.back().map_or(stamp, |(t, _)| *t);
        let too_old = |(t, _): &(Time, Pose2)| newest - *t > Span::from_secs(Self::KEPT_S);
        while self.readings.len() > Self::MOST_READINGS
            || self.readings.len() > 2 && self.readings.get(1).is_some_and(too_old)
        {
            self.readings.pop_front();
        }
        if is_newest { Reading::Newest } else { Reading::Late }
    }

    /// The newest reading.
    pub fn newest(&self) -> Option<(Time, Pose2)> {
        self.readings.back().copied()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.readings.clear();
    }

    /// Whether nothing that is still to come can change the pose at this time.
    pub fn is_past(&self, time: Time) -> bool {
        self.newest().is_some_and(|(newest, _)| newest >= time)
    }

    /// Whether the time lies before everything that is kept.
    pub fn is_before(&self, time: Time) -> bool {
        self.readings.front().is_some_and(|(oldest, _)| time < *oldest)
    }

    /// The pose at a time: between two readings on the straight line, and shortly after the newest the newest. None
    /// where nothing is known.
    pub fn at(&self, time: Time) -> Option<Pose2> {
        let after = self.readings.partition_point(|(t, _)| *t <= time);
        let (t0, a) = *self.readings.get(after.checked_sub(1)?)?;
        let Some((t1, b)) = self.readings.get(after) else {
            return (time - t0 <= Span::from_secs(Self::EXTRAPOLATED_S)).then_some(a);
        };
        let part = (time - t0).as_secs() / (*t1 - t0).as_secs();
        Some(interpolate2(&a, b, part))
    }

    /// Where the base was at a time, seen from where the newest reading has it; after that one by the velocity. None where
    /// nothing is known; before the first reading the base has not moved.
    pub fn now_from_then(&self, stamp: Time, twist: &Twist) -> Option<Pose2> {
        let Some((newest, odom_from_now)) = self.newest() else { return Some(Pose2::identity()) };
        if stamp > newest {
            let ahead = stamp - newest;
            return (ahead <= Self::MOST_AHEAD).then(|| twist.integrate(ahead.as_secs()));
        }
        self.at(stamp).map(|odom_from_then| odom_from_now.inverse() * odom_from_then)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    fn at(seconds: f64) -> Time {
        Time::from_secs(seconds)
    }

    #[test]
    fn poses_are_interpolated_through_the_wrap_and_late_readings_sorted_in() {
        let mut history = OdometryHistory::default();
        assert_eq!(history.push(at(1.0), pose2(0.0, 0.0, 3.0)), Reading::Newest);
        assert_eq!(history.push(at(2.0), pose2(2.0, 0.0, -3.0)), Reading::Newest);
        let middle = history.at(at(1.5)).unwrap();
        assert!((middle.translation.x - 1.0).abs() < 1e-12);
        assert!((middle.rotation.angle().abs() - std::f64::consts::PI).abs() < 1e-12);
        assert_eq!(history.push(at(1.5), pose2(0.4, 0.0, 3.1)), Reading::Late);
        assert!((history.at(at(1.25)).unwrap().translation.x - 0.2).abs() < 1e-12);
    }

    #[test]
    fn stamps_that_do_not_rise_and_times_that_nobody_knows_are_refused() {
        let mut history = OdometryHistory::default();
        assert_eq!(history.at(at(0.0)), None);
        history.push(at(1.0), Pose2::identity());
        for stale in [1.0, 0.5] {
            assert_eq!(history.push(at(stale), pose2(9.0, 9.0, 9.0)), Reading::Stale);
        }
        assert!(history.at(at(0.99)).is_none() && history.at(at(1.06)).is_none());
        assert_eq!(history.at(at(1.04)), Some(Pose2::identity()));
        assert!(history.is_before(at(0.9)) && history.is_past(at(1.0)) && !history.is_past(at(1.01)));
    }

    #[test]
    fn memory_is_bounded_but_covers_a_gap() {
        let mut history = OdometryHistory::default();
        for k in 0..5000 {
            history.push(at(0.001 * f64::from(k)), Pose2::identity());
        }
        assert_eq!(history.readings.len(), OdometryHistory::MOST_READINGS);
        history.push(at(100.0), Pose2::identity());
        assert!(history.at(at(50.0)).is_some());
    }
}
