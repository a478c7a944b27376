//! The host's side of the line: finds the device, sets it up, and takes its scans.
//!
//! A state machine over bytes and time, without a port or a clock: whoever owns those passes on what came in, does what
//! [`Driver::next_action`] says, and calls [`Driver::tick`] now and then.

mod fault;
mod setup;
mod task;

use std::collections::VecDeque;

use rumbo_core::time::{Span, Time};

use super::protocol::{
    Command, Configuration, CountUnit, Decoder, LineSpeed, Measured, MeasuringMode, Mode, Reply, Severity,
    StatusByte, Telegram, Token, Variant,
};
pub use fault::{Counters, DriverFault};
use task::Task;

/// What the device shall do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// Speeds at which the device is looked for, besides `speed`, in this order.
    pub connect: Vec<LineSpeed>,
    /// Speed of the line once it is found.
    pub speed: LineSpeed,
    /// Field of view and resolution.
    pub variant: Variant,
    /// Every turn of the mirror as a scan of its own, four of which interlace to a quarter of a degree.
    pub partials: bool,
    /// Unit of distances.
    pub unit: CountUnit,
    /// How values share their bits.
    pub measuring_mode: MeasuringMode,
}

/// A scan that came through.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceScan {
    /// The middle of the measurement.
    pub measured_at: Time,
    /// Values, from right to left.
    pub measured: Measured,
    /// How the device was.
    pub status: StatusByte,
}

/// What the owner of the port shall do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Action {
    /// Change the speed of the port and empty its buffers.
    SetSpeed(LineSpeed),
    /// Send these bytes.
    Send(Vec<u8>),
    /// Take this scan.
    Deliver(DeviceScan),
}

/// Nothing for this long between bytes: the rest of a telegram will not come.
const MOST_GAP: Span = Span(35_000_000);
/// No scan for this long: begin anew.
const MOST_SILENCE: Span = Span(5_000_000_000);
/// After stopping the output, the line is quiet when nothing came for this long.
const QUIET: Span = Span(60_000_000);
/// Both sides need this long to change their speed.
const SPEED_PAUSE: Span = Span(500_000_000);
/// Between a failure and the next attempt.
const REST: Span = Span(500_000_000);
/// Turns of the mirror in a second.
const MIRROR_HZ: i64 = 75;

/// The driver.
#[derive(Debug)]
pub struct Driver {
    settings: Settings,
    decoder: Decoder,
    actions: VecDeque<Action>,
    counters: Counters,
    last_fault: Option<DriverFault>,
    device_type: Option<String>,
    speed: LineSpeed,
    /// What the device says about its own.
    device_speed: LineSpeed,
    task: Task,
    /// When the task is overdue.
    deadline: Time,
    /// So often its command was sent.
    n_tries: u32,
    last_byte_at: Time,
    last_scan_at: Time,
    /// Bytes that came since the last telegram that was understood, or since the search began.
    n_unheeded: u64,
}

impl Driver {
    /// Begins to look for the device.
    pub fn new(settings: Settings, now: Time) -> Self {
        let speed = settings.speed;
        let mut driver = Self {
            settings,
            decoder: Decoder::default(),
            actions: VecDeque::new(),
            counters: Counters::default(),
            last_fault: None,
            device_type: None,
            speed,
            device_speed: speed,
            task: Task::Rest,
            deadline: now,
            n_tries: 0,
            last_byte_at: now,
            last_scan_at: now,
            n_unheeded: 0,
        };
        driver.begin(Task::Find { idx: 0, is_proven: false }, now);
        driver
    }

    /// Bytes came in, the last of them just now.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        self.last_byte_at = now;
        self.n_unheeded += bytes.len() as u64;
        if self.task == Task::Settle {
            self.deadline = now + QUIET;
        }
        self.decoder.push(bytes);
        self.listen(now);
    }

    /// Time has passed.
    pub fn tick(&mut self, now: Time) {
        while self.decoder.is_amid_frame() && now - self.last_byte_at > MOST_GAP {
            self.decoder.give_up_frame();
            self.listen(now);
        }
        if now >= self.deadline {
            self.be_overdue(now);
        }
    }

    /// What the owner of the port shall do next.
    pub fn next_action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// Ends the output and leaves the device at the speed that it has after power-on.
    pub fn stop(&mut self, now: Time) {
        if !self.task.is_stopping() {
            self.begin(Task::Stop, now);
        }
    }

    /// Stopped, as far as the device could still be reached.
    pub fn is_stopped(&self) -> bool {
        self.task == Task::Stopped
    }

    /// Scans are coming.
    pub fn is_streaming(&self) -> bool {
        self.task == Task::Stream
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        let tally = self.decoder.tally();
        Counters {
            n_checksum_failures: tally.n_checksum_failures,
            n_discarded_bytes: tally.n_discarded,
            ..self.counters
        }
    }

    /// Why the last attempt failed.
    pub fn last_fault(&self) -> Option<&DriverFault> {
        self.last_fault.as_ref()
    }

    /// What the device says that it is.
    pub fn device_type(&self) -> Option<&str> {
        self.device_type.as_deref()
    }

    fn listen(&mut self, now: Time) {
        while let Some(token) = self.decoder.next() {
            match token {
                // Damaged telegrams may look like acknowledgments, so only answers count.
                Token::Ack => {}
                Token::Nak => self.counters.n_refused += 1,
                Token::Frame(payload) => match Telegram::of_payload(&payload) {
                    Ok(telegram) => self.hear(now, telegram, payload.len()),
                    Err(_) => self.counters.n_unknown += 1,
                },
            }
        }
    }

    fn hear(&mut self, now: Time, telegram: Telegram, n_payload: usize) {
        let Telegram { reply, status } = telegram;
        self.n_unheeded = 0;
        self.counters.n_polluted += u64::from(status.is_polluted());
        self.counters.n_implausible += u64::from(status.is_implausible());
        self.counters.n_errors += u64::from(status.severity() >= Severity::Error);
        match reply {
            Reply::Scan(measured) => self.hear_scan(now, measured, status, n_payload),
            Reply::PowerOn(_) if !matches!(self.task, Task::Find { .. } | Task::Rest) => {
                self.fail(DriverFault::Restarted, now);
            }
            reply => self.go_on(now, reply),
        }
    }

    fn hear_scan(&mut self, now: Time, measured: Measured, status: StatusByte, n_payload: usize) {
        if let Task::Find { is_proven, .. } = &mut self.task {
            *is_proven = true;
        }
        // The answer to the start may be lost, the scans that follow it say the same.
        if self.task == (Task::Command(setup::Step::Start)) && self.is_wanted(&measured) {
            self.begin(Task::Stream, now);
            self.last_scan_at = now;
        }
        if self.task != Task::Stream {
            self.counters.n_ignored_scans += 1;
            return;
        }
        if !self.is_wanted(&measured) {
            self.fail(DriverFault::OtherScans, now);
            return;
        }
        let line_time = self.speed.time_of(n_payload + super::protocol::OVERHEAD);
        let expected = Span(self.scan_time().0.max(line_time.0));
        if now - self.last_scan_at > Span(3 * expected.0) {
            self.counters.n_gaps += 1;
        }
        self.counters.n_scans += 1;
        self.last_scan_at = now;
        self.deadline = now + MOST_SILENCE;
        let measured_at = now - line_time - Span(self.scan_time().0 / 2);
        self.actions.push_back(Action::Deliver(DeviceScan { measured_at, measured, status }));
    }

    /// What the device was told to send, and nothing that a checksum let through by chance.
    fn is_wanted(&self, measured: &Measured) -> bool {
        let Settings { variant, partials, unit, .. } = &self.settings;
        let n_values = match (measured.partial, partials) {
            (None, false) => variant.n_values(),
            (Some(number), true) => usize::from(variant.field_deg) + usize::from(number == 0),
            _ => return false,
        };
        measured.words.len() == n_values && measured.unit == *unit
    }

    fn scan_time(&self) -> Span {
        let n_turns = if self.settings.partials { 1 } else { self.settings.variant.n_turns() };
        Span(i64::from(n_turns) * 1_000_000_000 / MIRROR_HZ)
    }

    fn set_speed(&mut self, speed: LineSpeed) {
        self.speed = speed;
        self.decoder.clear();
        self.actions.push_back(Action::SetSpeed(speed));
    }

    fn fail(&mut self, fault: DriverFault, now: Time) {
        self.last_fault = Some(fault);
        self.n_unheeded = 0;
        self.counters.n_restarts += 1;
        self.begin(Task::Rest, now);
    }
}

#[cfg(test)]
mod tests;
