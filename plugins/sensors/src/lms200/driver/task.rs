//! From one thing to the next: what is sent, what an answer leads to, and what happens without one.

use rumbo_core::time::{Span, Time};

use super::setup::Step;
use super::{
    Action, Command, Driver, DriverFault, LineSpeed, MOST_SILENCE, Mode, QUIET, REST, Reply, SPEED_PAUSE,
};

/// What the driver is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Task {
    /// Stop the output at the speed of this number; `is_proven` when telegrams were heard at it.
    Find { idx: usize, is_proven: bool },
    /// Wait until the line is quiet, so that no late answer is taken for another.
    Settle,
    /// Wait for an answer.
    Command(Step),
    /// Wait for the device to change its speed.
    SpeedPause,
    /// Take scans.
    Stream,
    /// Wait after a failure.
    Rest,
    /// Stop the output for good.
    Stop,
    /// Back to the speed after power-on.
    StopSpeed,
    /// Over.
    Stopped,
}

impl Task {
    pub fn is_stopping(&self) -> bool {
        matches!(self, Self::Stop | Self::StopSpeed | Self::Stopped)
    }
}

/// How long the answer to a stop may take.
const STOP_BUDGET: Span = Span(300_000_000);
/// A command is sent so often.
const MOST_TRIES: u32 = 3;
/// Where telegrams are heard, the speed is right, and it is worth more tries.
const MOST_TRIES_WHERE_HEARD: u32 = 12;

impl Driver {
    pub(super) fn begin(&mut self, task: Task, now: Time) {
        self.n_tries = 0;
        self.task = task;
        match self.task {
            Task::Find { idx, .. } => match self.speed_to_try(idx) {
                Some(speed) => {
                    self.set_speed(speed);
                    self.send(now);
                }
                None if self.n_unheeded > 0 => self.fail(DriverFault::SomethingElse, now),
                None => self.fail(DriverFault::NotFound, now),
            },
            Task::Command(_) | Task::Stop | Task::StopSpeed => self.send(now),
            Task::Settle => self.deadline = now + QUIET,
            Task::SpeedPause => self.deadline = now + SPEED_PAUSE,
            Task::Stream => self.deadline = now + MOST_SILENCE,
            Task::Rest => self.deadline = now + REST,
            Task::Stopped => self.deadline = Time::MAX,
        }
    }

    /// The wanted speed first: after a pulled cable the device still has it.
    fn speed_to_try(&self, idx: usize) -> Option<LineSpeed> {
        let wanted = self.settings.speed;
        let others = self.settings.connect.iter().copied().filter(|speed| *speed != wanted);
        std::iter::once(wanted).chain(others).nth(idx)
    }

    fn send(&mut self, now: Time) {
        let (command, budget) = match &self.task {
            Task::Command(step) => (step.command(&self.settings), step.budget()),
            Task::StopSpeed => (Command::Switch(Mode::Speed(LineSpeed::Baud9600)), STOP_BUDGET),
            _ => (Command::Switch(Mode::OnRequest), STOP_BUDGET),
        };
        self.n_tries += 1;
        let bytes = command.to_bytes();
        self.deadline = now + budget + self.speed.time_of(bytes.len());
        self.actions.push_back(Action::Send(bytes));
    }

    pub(super) fn be_overdue(&mut self, now: Time) {
        let most_tries = match self.task {
            Task::Find { is_proven: true, .. } => MOST_TRIES_WHERE_HEARD,
            _ => MOST_TRIES,
        };
        match &self.task {
            Task::Find { .. } | Task::Command(_) | Task::Stop | Task::StopSpeed
                if self.n_tries < most_tries =>
            {
                self.send(now);
            }
            Task::Find { idx, .. } => {
                let idx = idx + 1;
                self.begin(Task::Find { idx, is_proven: false }, now);
            }
            Task::Command(step) => {
                let step = step.name();
                self.fail(DriverFault::NoAnswer { step }, now);
            }
            Task::Settle => self.begin(Task::Command(Step::Status), now),
            Task::SpeedPause => {
                self.set_speed(self.settings.speed);
                self.begin(Task::Command(Step::ConfirmSpeed), now);
            }
            Task::Stream => self.fail(DriverFault::Silent, now),
            Task::Rest => self.begin(Task::Find { idx: 0, is_proven: false }, now),
            Task::Stop | Task::StopSpeed | Task::Stopped => self.begin(Task::Stopped, now),
        }
    }

    /// An answer that is no scan.
    pub(super) fn go_on(&mut self, now: Time, reply: Reply) {
        match (&self.task, reply) {
            (Task::Find { .. }, Reply::ModeSwitched(0)) => self.begin(Task::Settle, now),
            (Task::Stop, Reply::ModeSwitched(0)) => self.begin(Task::StopSpeed, now),
            (Task::StopSpeed, Reply::ModeSwitched(0)) => self.begin(Task::Stopped, now),
            (Task::Command(step), reply) => {
                let step = step.clone();
                self.take_answer(now, step, reply);
            }
            // Late answers to what is done already.
            _ => {}
        }
    }

    fn take_answer(&mut self, now: Time, step: Step, reply: Reply) {
        let next = match (step, reply) {
            (step, Reply::NotAccepted) => {
                return self.fail(DriverFault::Refused { step: step.name() }, now);
            }
            (Step::Install(_), Reply::ModeSwitched(1)) => return self.fail(DriverFault::Password, now),
            (Step::Status, Reply::Status(report)) => {
                // Behind a bridge the port's own speed says nothing, so the device's word counts.
                self.device_speed = report.speed().unwrap_or(self.speed);
                Step::Type
            }
            (Step::Type, Reply::Type(text)) => {
                self.device_type = Some(text.trim_end().to_owned());
                if self.device_speed == self.settings.speed {
                    Step::ReadConfiguration
                } else {
                    Step::AskSpeed
                }
            }
            (Step::AskSpeed, Reply::ModeSwitched(0)) => return self.begin(Task::SpeedPause, now),
            (Step::ConfirmSpeed, Reply::Status(_)) => Step::ReadConfiguration,
            (Step::ReadConfiguration, Reply::Configuration(found)) => {
                let wanted = found.with(self.settings.unit, self.settings.measuring_mode);
                // Each write wears the EEPROM.
                if found == wanted { Step::Variant } else { Step::Install(wanted) }
            }
            (Step::Install(wanted), Reply::ModeSwitched(0)) => Step::Write(wanted),
            (Step::Write(wanted), Reply::ConfigurationWritten(true, stored)) if stored == wanted => {
                Step::Leave
            }
            (Step::Leave, Reply::ModeSwitched(0)) => Step::Variant,
            // The answer tells the variant in force, and that is what counts.
            (Step::Variant, Reply::Variant(_, in_force)) if in_force == self.settings.variant => Step::Start,
            (Step::Start, Reply::ModeSwitched(0)) => {
                self.last_scan_at = now;
                return self.begin(Task::Stream, now);
            }
            (step, Reply::ModeSwitched(_) | Reply::ConfigurationWritten(..) | Reply::Variant(..)) => {
                return self.fail(DriverFault::Refused { step: step.name() }, now);
            }
            // Late answers to what is done already.
            _ => return,
        };
        self.begin(Task::Command(next), now);
    }
}
