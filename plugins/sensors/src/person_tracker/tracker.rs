//! Errors of a tracker: noise, gaps, and positions on their way.

use std::collections::VecDeque;

use rand::RngExt as _;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::Point2;
use rumbo_core::messages::PersonPosition;
use rumbo_core::rng::Rng;
use rumbo_core::time::{Span, Time};

/// Measures exact positions with errors, and hands them out when they arrive.
#[derive(Debug)]
pub struct Tracker {
    deviation_m: f64,
    delay: Span,
    dropout_share: f64,
    on_the_way: VecDeque<(Time, PersonPosition)>,
}

impl Tracker {
    /// With these errors.
    pub fn new(deviation_m: f64, delay: Span, dropout_share: f64) -> Tracker {
        Tracker { deviation_m, delay, dropout_share, on_the_way: VecDeque::new() }
    }

    /// Measures where the person is now.
    pub fn measure(&mut self, now: Time, exact: Point2, rng: &mut Rng) {
        // All are drawn whatever is lost, so that a change of one share leaves the other errors as they were.
        let [x, y]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(rng));
        let is_lost = rng.random::<f64>() < self.dropout_share;
        if !is_lost {
            let position = Point2::new(exact.x + self.deviation_m * x, exact.y + self.deviation_m * y);
            self.on_the_way.push_back((now, PersonPosition { position, deviation_m: self.deviation_m }));
        }
    }

    /// The next position that has arrived by now, with the time of its measurement.
    pub fn arrived(&mut self, now: Time) -> Option<(Time, PersonPosition)> {
        let (measured, _) = self.on_the_way.front()?;
        if *measured + self.delay > now {
            return None;
        }
        self.on_the_way.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::rng::stream;

    fn at(seconds: f64) -> Time {
        Time::from_secs(seconds)
    }

    #[test]
    fn without_errors_every_position_arrives_exact_and_at_once() {
        let (mut tracker, mut rng) = (Tracker::new(0.0, Span::ZERO, 0.0), stream(1, "exact"));
        tracker.measure(at(1.0), Point2::new(2.0, -3.0), &mut rng);
        let exact = PersonPosition { position: Point2::new(2.0, -3.0), deviation_m: 0.0 };
        assert_eq!(tracker.arrived(at(1.0)), Some((at(1.0), exact)));
        assert_eq!(tracker.arrived(at(1.0)), None);
    }

    #[test]
    fn positions_arrive_late_in_order_and_with_the_time_of_their_measurement() {
        let (mut tracker, mut rng) = (Tracker::new(0.0, Span::from_secs(0.5), 0.0), stream(1, "late"));
        for k in 0..3 {
            tracker.measure(at(0.2 * f64::from(k)), Point2::new(f64::from(k), 0.0), &mut rng);
        }
        assert_eq!(tracker.arrived(at(0.49)), None);
        let xs = |tracker: &mut Tracker, now: f64| {
            let arrived = std::iter::from_fn(|| tracker.arrived(at(now)));
            arrived.map(|(stamp, person)| (stamp.as_secs(), person.position.x)).collect::<Vec<_>>()
        };
        assert_eq!(xs(&mut tracker, 0.7), [(0.0, 0.0), (0.2, 1.0)]);
        assert_eq!(xs(&mut tracker, 2.0), [(0.4, 2.0)]);
    }

    #[test]
    fn noise_has_its_deviation_on_both_axes_and_as_many_drop_out_as_shall() {
        const N: usize = 20_000;
        let (mut tracker, mut rng) = (Tracker::new(0.3, Span::ZERO, 0.2), stream(7, "noise"));
        let exact = Point2::new(10.0, 20.0);
        (0..N).for_each(|_| tracker.measure(at(0.0), exact, &mut rng));
        let errors: Vec<_> = std::iter::from_fn(|| tracker.arrived(at(0.0)))
            .map(|(_, person)| person.position - exact)
            .collect();
        let n = errors.len() as f64;
        assert!((n / N as f64 - 0.8).abs() < 0.012, "four deviations of a share: {n}");
        for axis in [0, 1] {
            let mean = errors.iter().map(|error| error[axis]).sum::<f64>() / n;
            let spread = (errors.iter().map(|error| error[axis].powi(2)).sum::<f64>() / n).sqrt();
            assert!(
                mean.abs() < 4.0 * 0.3 / n.sqrt() && (spread / 0.3 - 1.0).abs() < 0.025,
                "{mean} {spread}"
            );
        }
    }

    #[test]
    fn a_share_that_changes_leaves_the_noise_of_the_others_as_it_was() {
        let all = |dropout_share: f64| {
            let (mut tracker, mut rng) = (Tracker::new(0.3, Span::ZERO, dropout_share), stream(3, "shares"));
            (0..50).for_each(|k| tracker.measure(at(f64::from(k)), Point2::origin(), &mut rng));
            std::iter::from_fn(|| tracker.arrived(at(100.0))).collect::<Vec<_>>()
        };
        let (most, few) = (all(0.1), all(0.6));
        assert!(few.len() < most.len() && few.iter().all(|reading| most.contains(reading)));
    }
}
