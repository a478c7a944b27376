//! The device's side of the line, on a clock that is given: what a driver meets, without a device.
//!
//! Answers are those of the telegram listing. Where it leaves something open (what the factory configuration holds, how
//! soon an answer comes) the emulator chooses, and a driver must not rely on it. Modes that no driver here asks for
//! (smallest values, fields, reflectivity) are not accepted.

mod answers;
mod faults;
mod in_place;
mod line;
mod receiver;
mod scanner;

use rumbo_core::time::Time;

use super::protocol::{
    ACK, Command, Configuration, IndexRange, LineSpeed, NAK, Reply, StatusByte, Telegram, Variant,
};
pub use faults::Faults;
use line::Line;
use receiver::{Heard, Receiver};
use scanner::Scanner;

/// What stands around the device: range (meters) and reflector level (0 to 7) at a bearing (radians) and time.
pub type Ranges = Box<dyn FnMut(f64, Time) -> Option<(f64, u8)> + Send>;

/// What the device does unasked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Output {
    /// Nothing.
    OnRequest,
    /// All values.
    All,
    /// Part of the values.
    Part(IndexRange),
    /// Means over scans.
    Means(u8),
    /// Means of part of the values.
    MeansOfPart(u8, IndexRange),
    /// Every turn of the mirror.
    Partials,
}

/// An LMS 200.
pub struct Emulator {
    /// What goes wrong on the line and in the device.
    pub faults: Faults,
    scanner: Scanner,
    receiver: Receiver,
    line: Line,
    speed: LineSpeed,
    mode_code: u8,
    is_installing: bool,
    output: Output,
    variant: Variant,
    configuration: Configuration,
    /// The last scan that was sent, by its number since the output began.
    last_sent: u64,
    streaming_since: Time,
}

/// What the device has after power-on.
const FIRST_VARIANT: Variant = Variant { field_deg: 180, resolution_centideg: 50 };

impl Emulator {
    /// A device that was switched on just now. `faults` may still be none.
    pub fn new(ranges: Ranges, faults: Faults, now: Time) -> Self {
        let mut emulator = Self {
            faults,
            scanner: Scanner { ranges },
            receiver: Receiver::default(),
            line: Line::default(),
            speed: LineSpeed::Baud9600,
            mode_code: 0x25,
            is_installing: false,
            output: Output::OnRequest,
            variant: FIRST_VARIANT,
            configuration: Configuration::factory(),
            last_sent: 0,
            streaming_since: now,
        };
        emulator.switch_on(now);
        emulator
    }

    /// Power was lost and came back: everything but the configuration is as it was in the beginning.
    pub fn switch_on(&mut self, now: Time) {
        self.wake();
        self.line.clear(now);
        self.say(now, Reply::PowerOn(answers::TYPE.to_owned()));
    }

    /// The host sent these bytes with its line at `speed`.
    pub fn receive(&mut self, now: Time, speed: LineSpeed, bytes: &[u8]) {
        if self.faults.is_unplugged {
            return;
        }
        for &byte in bytes {
            let byte = if speed == self.speed { byte } else { line::garbled(byte) };
            if let Some(heard) = self.receiver.hear(now, byte) {
                self.react(now, heard);
            }
        }
    }

    /// What has come through the line by now, to a host that listens at `speed`.
    pub fn transmit(&mut self, now: Time, speed: LineSpeed, out: &mut Vec<u8>) {
        if let Some(heard) = self.receiver.wait(now) {
            self.react(now, heard);
        }
        self.stream(now);
        self.line.take(now, speed, self.faults.is_unplugged, out);
    }

    /// The host's buffers were emptied, as after a change of its speed.
    pub fn flush(&mut self) {
        self.line.break_off();
    }

    /// Scans whose every byte came through unharmed to a host at the right speed.
    pub fn n_whole_scans(&self) -> u64 {
        self.line.n_whole_scans()
    }

    /// Telegrams with scans that were sent, whole or not.
    pub fn n_sent_scans(&self) -> u64 {
        self.line.n_sent_scans()
    }

    /// The speed of the device's line.
    pub fn speed(&self) -> LineSpeed {
        self.speed
    }

    /// The configuration in force.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    fn react(&mut self, now: Time, heard: Heard) {
        let Heard::Payload(payload) = heard else {
            self.line.send(now, self.speed, &[NAK], false, &mut self.faults);
            return;
        };
        if self.faults.n_naks > 0 {
            self.faults.n_naks -= 1;
            self.line.send(now, self.speed, &[NAK], false, &mut self.faults);
            return;
        }
        self.line.send(now, self.speed, &[ACK], false, &mut self.faults);
        match Command::of_payload(&payload) {
            Some(command) => self.obey(now, command),
            None => self.say(now, Reply::NotAccepted),
        }
    }

    fn say(&mut self, now: Time, reply: Reply) {
        let is_scan = matches!(reply, Reply::Scan(_));
        let status = StatusByte(StatusByte::HEALTHY.0 | self.faults.status_bits);
        let bytes = Telegram { reply, status }.to_bytes();
        self.line.send(now, self.speed, &bytes, is_scan, &mut self.faults);
    }

    fn wake(&mut self) {
        self.speed = LineSpeed::Baud9600;
        self.mode_code = 0x25;
        self.is_installing = false;
        self.output = Output::OnRequest;
        self.variant = FIRST_VARIANT;
        self.receiver = Receiver::default();
    }

    /// Turns of the mirror between telegrams.
    fn n_turns(&self) -> u32 {
        match self.output {
            Output::Partials => 1,
            Output::Means(n_scans) | Output::MeansOfPart(n_scans, _) => {
                self.variant.n_turns() * u32::from(n_scans)
            }
            _ => self.variant.n_turns(),
        }
    }

    /// As soon as the line is free, the newest scan goes out; those measured in the meantime are skipped.
    fn stream(&mut self, now: Time) {
        if self.output == Output::OnRequest || self.faults.is_mute {
            return;
        }
        loop {
            let next_at = self.streaming_since
                + scanner::time_of_turns((self.last_sent + 1) * u64::from(self.n_turns()));
            let starts_at = next_at.max(self.line.free_at());
            if starts_at > now {
                return;
            }
            let newest =
                scanner::turns_in(starts_at - self.streaming_since) / u64::from(self.n_turns().max(1));
            self.last_sent = newest.max(self.last_sent + 1);
            let measured_at =
                self.streaming_since + scanner::time_of_turns(self.last_sent * u64::from(self.n_turns()));
            let reply = self.output_at(measured_at);
            self.say(starts_at, reply);
        }
    }
}

impl std::fmt::Debug for Emulator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Emulator")
            .field("speed", &self.speed)
            .field("output", &self.output)
            .field("variant", &self.variant)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
