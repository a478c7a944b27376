//! Whether the readings are fresh enough to drive by.

use crate::sightings::{Sightings, Source};
use rumbo_core::stages::AvoidError;
use rumbo_core::time::{Span, Time};

/// When the avoider was asked, and since when it can expect readings.
#[derive(Debug)]
pub struct Listening {
    stale_after: Span,
    /// Fresh readings can be expected since then.
    since: Option<Time>,
    last_call: Option<Time>,
}

impl Listening {
    /// Nobody asked yet.
    pub fn new(stale_after: Span) -> Listening {
        Listening { stale_after, since: None, last_call: None }
    }

    /// The avoider is asked; where nobody asked for long, what the sensors said meanwhile was not heard.
    pub fn note(&mut self, now: Time) {
        let was_asked = self.last_call.is_some_and(|last| now - last <= self.stale_after);
        if !was_asked {
            self.since = Some(now);
        }
        self.last_call = Some(now);
    }

    /// Every sensor that ever gave a reading still does; false while the first is waited for.
    pub fn has_fresh_readings(&self, now: Time, sightings: &Sightings) -> Result<bool, AvoidError> {
        let oldest = sightings.iter().min_by_key(|sighting| sighting.stamp);
        if oldest.is_some_and(|sighting| now - sighting.stamp <= self.stale_after) {
            return Ok(true);
        }
        let since = self.since.unwrap_or(now);
        if now - since <= self.stale_after {
            return Ok(false);
        }
        let kind = match oldest.map(|sighting| sighting.source) {
            None => "laser scan or range ring",
            Some(Source::Laser) => "laser scan",
            Some(Source::Sonar { .. }) => "range ring",
        };
        let age_s = (now - oldest.map_or(since, |sighting| sighting.stamp)).as_secs();
        Err(AvoidError::NoReading { kind, age_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::boundary::Buffer;
    use rumbo_core::frames::{Pose2, Pose3};
    use rumbo_core::messages::{Data, LaserScan, Observation, RangeRing, SensorId};

    fn at(seconds: f64) -> Time {
        Time::from_secs(seconds)
    }

    fn reading(sensor: u16, seconds: f64, data: Data) -> Observation {
        let (sensor, base_from_sensor) = (SensorId(sensor), Pose3::identity());
        Observation { sensor, stamp: at(seconds), base_from_sensor, valid: true, data }
    }

    fn scan(seconds: f64) -> Observation {
        let ranges_m = Buffer::from(vec![1.0]);
        reading(0, seconds, Data::LaserScan(LaserScan { ranges_m, max_range_m: 8.0, ..LaserScan::default() }))
    }

    fn sonar(seconds: f64) -> Observation {
        let ring = RangeRing { cone_rad: 0.4, max_range_m: 4.0, ..RangeRing::default() };
        reading(1, seconds, Data::RangeRing(RangeRing { ranges_m: Buffer::from(vec![1.0]), ..ring }))
    }

    /// Asked ten times a second for so long, with these readings: what it says last, and when it first failed.
    fn asked(seconds: f64, readings: &[Observation]) -> (Result<bool, AvoidError>, Option<f64>) {
        let (mut listening, mut sightings) = (Listening::new(Span::from_secs(1.0)), Sightings::new(9.0));
        let (mut said, mut failed) = (Ok(false), None);
        for k in 0..=(seconds * 10.0).round() as i32 {
            let now = at(f64::from(k) / 10.0);
            let new = readings.iter().filter(|r| r.stamp <= now && now - r.stamp < Span::from_secs(0.1));
            new.for_each(|reading| sightings.see(reading, &Pose2::identity(), &[]));
            listening.note(now);
            said = listening.has_fresh_readings(now, &sightings);
            if said.is_err() {
                failed.get_or_insert(now.as_secs());
            }
        }
        (said, failed)
    }

    #[test]
    fn the_first_reading_is_waited_for_once_as_long_as_one_may_be_old() {
        assert_eq!(asked(1.0, &[]), (Ok(false), None));
        let (said, failed) = asked(1.1, &[]);
        assert!(
            matches!(said, Err(AvoidError::NoReading { kind: "laser scan or range ring", .. })),
            "{said:?}"
        );
        assert_eq!(failed, Some(1.1));
    }

    #[test]
    fn a_sensor_that_falls_silent_is_named_at_once_and_not_waited_for_a_second_time() {
        let scans: Vec<Observation> = (0..=20).map(|k| scan(f64::from(k) / 10.0)).collect();
        assert_eq!(asked(3.0, &scans), (Ok(true), None));
        let (said, failed) = asked(3.5, &scans);
        assert!(
            matches!(said, Err(AvoidError::NoReading { kind: "laser scan", age_s }) if (age_s - 1.5).abs() < 1e-9)
        );
        assert_eq!(failed, Some(3.1));
        // The scanner goes on, and the sonars do not.
        let both: Vec<Observation> = (0..=40)
            .map(|k| scan(f64::from(k) / 10.0))
            .chain((0..=5).map(|k| sonar(f64::from(k) / 10.0)))
            .collect();
        let (said, failed) = asked(4.0, &both);
        assert!(matches!(said, Err(AvoidError::NoReading { kind: "range ring", .. })), "{said:?}");
        assert_eq!(failed, Some(1.6));
    }

    #[test]
    fn what_was_not_heard_while_nobody_asked_is_waited_for_anew() {
        let (mut listening, mut sightings) = (Listening::new(Span::from_secs(1.0)), Sightings::new(9.0));
        sightings.see(&scan(0.0), &Pose2::identity(), &[]);
        listening.note(at(0.0));
        assert_eq!(listening.has_fresh_readings(at(0.0), &sightings), Ok(true));
        listening.note(at(60.0));
        assert_eq!(listening.has_fresh_readings(at(60.0), &sightings), Ok(false));
    }
}
