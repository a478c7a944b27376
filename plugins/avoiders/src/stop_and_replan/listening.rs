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
