//! The receiver's side of the line, on a clock that is given: GGA, GSA and RMC at each fix, as the device of Valverde
//! Moreno (2015), annex B.3.

mod in_place;
mod sentence;

use rand::RngExt as _;
use rumbo_core::rng::{self, Rng};
use rumbo_core::time::{Span, Time};

use super::local_frame::LocalFrame;
pub use crate::text_line::TextFaults;
use crate::text_line::TextLine;
pub use in_place::{EMULATED_LATITUDE_DEG, EMULATED_LONGITUDE_DEG};

/// Where the antenna is in the map, meters; nothing where the receiver hears no satellites.
pub type Position = Box<dyn FnMut() -> Option<[f64; 3]> + Send>;

/// What kind of receiver it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Fixes a second.
    pub rate_hz: f64,
    /// Speed of its line.
    pub baud: u32,
    /// Fixes err evenly between minus and plus this, meters.
    pub error_m: f64,
}

impl Default for Settings {
    /// One fix a second over 4800 baud, within 5 m.
    fn default() -> Self {
        Self { rate_hz: 1.0, baud: 4800, error_m: 5.0 }
    }
}

/// A receiver.
pub struct Emulator {
    /// What goes wrong with its lines.
    pub faults: TextFaults,
    position: Position,
    frame: LocalFrame,
    settings: Settings,
    line: TextLine,
    next_at: Time,
    rng: Rng,
}

impl std::fmt::Debug for Emulator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Emulator").field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl Emulator {
    /// A receiver that was switched on just now, in a map that lies on earth like this.
    pub fn new(position: Position, frame: LocalFrame, settings: Settings, seed: u64, now: Time) -> Self {
        Self {
            faults: TextFaults::none(seed),
            position,
            frame,
            settings,
            line: TextLine::new(settings.baud),
            next_at: now,
            rng: rng::stream(seed, "gps_error"),
        }
    }

    /// What has come through the line by now, to a host whose port has this speed.
    pub fn transmit(&mut self, now: Time, host_baud: Option<u32>, out: &mut Vec<u8>) {
        while self.next_at <= now {
            self.say(self.next_at);
            self.next_at = self.next_at + Span::from_secs(1.0 / self.settings.rate_hz);
        }
        self.line.take(now, host_baud, &self.faults, out);
    }

    fn say(&mut self, at: Time) {
        let place = (self.position)().map(|[x_m, y_m, z_m]| {
            let [x_m, y_m, z_m] = [x_m, y_m, z_m].map(|part_m| part_m + self.error_m());
            let [latitude_deg, longitude_deg] = self.frame.degrees([x_m, y_m].into());
            sentence::Place { latitude_deg, longitude_deg, height_m: z_m }
        });
        for line in sentence::lines(at, place.as_ref()) {
            self.line.send(at, line.as_bytes(), &mut self.faults);
        }
    }

    fn error_m(&mut self) -> f64 {
        self.settings.error_m * (2.0 * self.rng.random::<f64>() - 1.0)
    }
}

#[cfg(test)]
mod tests;
