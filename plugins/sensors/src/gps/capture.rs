//! A capture of a receiver's sentences: what comes when.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Error, ErrorKind, Read as _, Result};
use std::path::Path;

use rumbo_core::time::{Span, Time};

use super::nmea::{Decoder, Gga, Heard, Tally};

const SECONDS_A_DAY: f64 = 86_400.0;

/// Sentences with the times at which they are due.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Capture {
    due: VecDeque<(Time, Gga)>,
    tally: Tally,
}

impl Capture {
    /// Reads all of a file.
    pub fn read(path: &Path) -> Result<Self> {
        let mut file = File::open(path)?;
        if !file.metadata()?.is_file() {
            return Err(Error::new(ErrorKind::InvalidInput, "this is not a file"));
        }
        let (mut decoder, mut timeline, mut piece) = (Decoder::default(), Timeline::default(), [0u8; 4096]);
        let mut due = VecDeque::new();
        loop {
            let n_bytes = file.read(&mut piece)?;
            if n_bytes == 0 {
                // The last line needs no end.
                decoder.push(b"\n");
            }
            decoder.push(piece.get(..n_bytes).unwrap_or_default());
            while let Some(heard) = decoder.next() {
                if let Heard::Gga(gga) = heard {
                    due.push_back((timeline.due(&gga), gga));
                }
            }
            if n_bytes == 0 {
                break;
            }
        }
        if due.is_empty() {
            let n_refused = decoder.tally().n_refused();
            let message = format!("no GGA sentence in it ({n_refused} lines were refused)");
            return Err(Error::new(ErrorKind::InvalidData, message));
        }
        Ok(Self { due, tally: decoder.tally() })
    }

    /// What is due by now and was not taken before.
    pub fn next(&mut self, now: Time) -> Option<(Time, Gga)> {
        self.due.pop_front_if(|(due, _)| *due <= now)
    }

    /// All lines of the file.
    pub fn tally(&self) -> Tally {
        self.tally
    }
}

/// Times of day, counted on over midnight.
#[derive(Debug, Default)]
struct Timeline {
    last_utc_s: Option<f64>,
    elapsed_s: f64,
}

impl Timeline {
    /// A sentence that does not know the time comes with the one before it.
    fn due(&mut self, gga: &Gga) -> Time {
        let (Gga::Fix(super::nmea::Fix { utc_s, .. }) | Gga::NoFix { utc_s }) = gga;
        if let Some(utc_s) = utc_s {
            let step_s = self.last_utc_s.map_or(0.0, |last_s| utc_s - last_s);
            // What seems to lie half a day back is after midnight; what lies back a little comes at once.
            let step_s = if step_s < -SECONDS_A_DAY / 2.0 { step_s + SECONDS_A_DAY } else { step_s };
            self.elapsed_s += step_s.max(0.0);
            self.last_utc_s = Some(*utc_s);
        }
        Time::ZERO + Span::from_secs(self.elapsed_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_come_as_their_times_of_day_say_also_over_midnight() {
        let mut timeline = Timeline::default();
        let mut due_s = |utc_s| timeline.due(&Gga::NoFix { utc_s }).as_secs();
        let hours = |hours: f64| Some(hours * 3600.0);
        assert_eq!(due_s(None), 0.0);
        assert_eq!(due_s(hours(23.5)), 0.0);
        assert_eq!(due_s(hours(23.75)), 900.0);
        assert_eq!(due_s(None), 900.0);
        assert_eq!(due_s(hours(0.25)), 2700.0);
        assert_eq!(due_s(hours(0.0)), 2700.0, "a clock that was set back");
        assert_eq!(due_s(hours(0.5)), 4500.0);
    }
}
