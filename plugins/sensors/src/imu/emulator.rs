//! The device's side of the line, on a clock that is given: yaw, pitch and roll in degrees, line by line.

mod in_place;

use rand_distr::{Distribution as _, StandardNormal};
use rumbo_core::rng::{self, Rng};
use rumbo_core::time::{Span, Time};

pub use crate::text_line::TextFaults;
use crate::text_line::TextLine;

/// Roll, pitch and yaw as they are, radians; nothing where nobody knows.
pub type Attitude = Box<dyn FnMut() -> Option<[f64; 3]> + Send>;

/// What kind of device it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Lines a second.
    pub rate_hz: f64,
    /// Speed of its line.
    pub baud: u32,
    /// Standard deviation of each angle, degrees.
    pub noise_deg: f64,
}

impl Default for Settings {
    /// Fifty lines a second over 57600 baud, with half a degree of noise.
    fn default() -> Self {
        Self { rate_hz: 50.0, baud: 57_600, noise_deg: 0.5 }
    }
}

/// A device.
pub struct Emulator {
    /// What goes wrong with its lines.
    pub faults: TextFaults,
    attitude: Attitude,
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
    /// A device that was switched on just now.
    pub fn new(attitude: Attitude, settings: Settings, seed: u64, now: Time) -> Self {
        Self {
            faults: TextFaults::none(seed),
            attitude,
            settings,
            line: TextLine::new(settings.baud),
            next_at: now,
            rng: rng::stream(seed, "imu_error"),
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
        let Some(attitude_rad) = (self.attitude)() else { return };
        let [roll, pitch, yaw] = attitude_rad.map(|angle_rad| {
            let error: f64 = StandardNormal.sample(&mut self.rng);
            rumbo_core::frames::wrap_angle(angle_rad + self.settings.noise_deg.to_radians() * error)
                .to_degrees()
        });
        let line = format!("Y: {yaw:.2} P: {pitch:.2} R: {roll:.2}\r\n");
        self.line.send(at, line.as_bytes(), &mut self.faults);
    }
}

#[cfg(test)]
mod tests;
