//! Patience with people who are in the way: a new path after a while, then less fear of what is far in the future.

use rumbo_core::frames::Point2;
use rumbo_core::time::Time;

/// How long the robot has waited, and where it last asked for another path.
#[derive(Debug)]
pub struct Waiting {
    patience_s: f64,
    since: Option<Time>,
    /// It has driven since then, but not for long.
    on_way_since: Option<Time>,
    asked_at: Option<Point2>,
}

impl Waiting {
    /// A robot that goes on for less than this has not gone on, seconds.
    const LEAST_DRIVE_S: f64 = 2.0;
    /// Another place begins this far away, meters.
    const ELSEWHERE_M: f64 = 1.0;
    /// Nothing nearer in time is ever ignored, as a part of the whole horizon.
    const LEAST_HORIZON: f64 = 0.35;

    /// Does not wait yet.
    pub fn new(patience_s: f64) -> Waiting {
        Waiting { patience_s, since: None, on_way_since: None, asked_at: None }
    }

    /// The robot waits now, or does not.
    pub fn is_waiting(&self) -> bool {
        self.since.is_some() && self.on_way_since.is_none()
    }

    /// Whether the robot waits for somebody at `now`.
    pub fn note(&mut self, now: Time, waits: bool) {
        if waits {
            self.since.get_or_insert(now);
            self.on_way_since = None;
        } else if self.since.is_some() {
            let since = *self.on_way_since.get_or_insert(now);
            if (now - since).as_secs() >= Self::LEAST_DRIVE_S {
                (self.since, self.on_way_since) = (None, None);
            }
        }
    }

    fn waited_s(&self, now: Time) -> f64 {
        self.since.map_or(0.0, |since| (now - since).as_secs())
    }

    /// Patience is at an end, and no other path was asked for here yet. Asks for it.
    pub fn asks(&mut self, now: Time, here: Point2) -> bool {
        let is_new = self.asked_at.is_none_or(|asked| (asked - here).norm() >= Self::ELSEWHERE_M);
        let asks = is_new && self.waited_s(now) >= self.patience_s;
        if asks {
            self.asked_at = Some(here);
        }
        asks
    }

    /// How much of the future counts: all of it at first; of somebody who walks to and fro for ever, less and less.
    pub fn horizon_s(&self, horizon_s: f64, now: Time) -> f64 {
        let over_s = (self.waited_s(now) - self.patience_s).max(0.0);
        let part = 1.0 - over_s / (2.0 * self.patience_s).max(1e-3);
        horizon_s * part.max(Self::LEAST_HORIZON)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: f64) -> Time {
        Time::from_secs(seconds)
    }

    #[test]
    fn another_path_is_asked_for_once_a_place_and_the_horizon_shrinks_after_that() {
        let mut waiting = Waiting::new(8.0);
        let here = Point2::origin();
        waiting.note(at(1.0), true);
        assert!(waiting.is_waiting() && !waiting.asks(at(8.9), here));
        assert!(waiting.asks(at(9.1), here) && !waiting.asks(at(9.2), here));
        assert!(waiting.asks(at(9.3), Point2::new(1.5, 0.0)));
        assert_eq!(waiting.horizon_s(4.0, at(9.0)), 4.0);
        assert!((waiting.horizon_s(4.0, at(13.0)) - 3.0).abs() < 1e-9);
        assert!((waiting.horizon_s(4.0, at(90.0)) - 1.4).abs() < 1e-9, "never without any");
    }

    #[test]
    fn a_moment_of_driving_is_no_end_of_waiting() {
        let mut waiting = Waiting::new(8.0);
        waiting.note(at(0.0), true);
        waiting.note(at(5.0), false);
        assert!(!waiting.is_waiting());
        waiting.note(at(6.0), true);
        assert!(waiting.asks(at(8.5), Point2::origin()));
        waiting.note(at(9.0), false);
        waiting.note(at(11.5), false);
        waiting.note(at(12.0), true);
        assert_eq!(waiting.horizon_s(4.0, at(19.9)), 4.0);
    }
}
