//! The host's side of the connection to a base: finds it, keeps its readings, passes commands on.
//!
//! A state machine over bytes and time, without a port or a clock.

mod event;
mod wheel_book;

use std::collections::VecDeque;

use rumbo_core::frames::Twist;
use rumbo_core::time::{Span, Time};

use super::protocol::{
    BaseIdentity, BaseStatus, BumperGeometry, Decoder, Frame, FromBase, SonarGeometry, SonarReading, Tally,
    ToBase, VERSION, encode,
};
use super::readings::{Readings, Stamped};
pub use event::LinkEvent;
use wheel_book::WheelBook;

/// A hello without an answer is said again after this.
const ASK_AGAIN: Span = Span(250_000_000);
/// A base that says nothing for so long is lost.
const MOST_SILENCE: Span = Span(500_000_000);
/// Commands are said again after this: a lost line costs a tenth of a second.
const SAY_AGAIN: Span = Span(100_000_000);
/// A command that is older is not said again: whoever gave it may hang. The base then stops by itself.
const HOLD: Span = Span(300_000_000);

/// What the base has, as it told.
#[derive(Debug, Clone, PartialEq)]
pub struct Base {
    /// Who it is.
    pub identity: BaseIdentity,
    /// Its sonars.
    pub sonars: SonarGeometry,
    /// Its bumpers.
    pub bumpers: BumperGeometry,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nobody has answered yet; the last hello was said then.
    Looking { asked_at: Option<Time> },
    /// The base answers.
    Ready,
    /// The base was told that it is over.
    Leaving,
    /// It is over.
    Left,
}

/// The connection.
#[derive(Debug)]
pub struct Link {
    state: State,
    decoder: Decoder,
    out: Vec<u8>,
    number: u16,
    /// What the answers to the present hello have told so far.
    heard: (Option<BaseIdentity>, Option<SonarGeometry>, Option<BumperGeometry>),
    base: Option<Base>,
    wheels: WheelBook,
    readings: Readings,
    /// The newest command, when it was given, and when it was said.
    command: Option<(Twist, Time, Time)>,
    last_line_at: Time,
    lost_since: Time,
    trouble: Option<String>,
    refused: Option<String>,
    status: Option<BaseStatus>,
    events: VecDeque<LinkEvent>,
}

impl Link {
    /// Begins to look for the base.
    pub fn new(now: Time) -> Self {
        Self {
            state: State::Looking { asked_at: None },
            decoder: Decoder::default(),
            out: Vec::new(),
            number: 0,
            heard: (None, None, None),
            base: None,
            wheels: WheelBook::default(),
            readings: Readings::default(),
            command: None,
            last_line_at: now,
            lost_since: now,
            trouble: None,
            refused: None,
            status: None,
            events: VecDeque::new(),
        }
    }

    /// Bytes came in, the last of them just now.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        for byte in bytes {
            if let Some(Frame { text, .. }) = self.decoder.push(*byte) {
                // Lines of later versions are for others.
                if let Ok(line) = FromBase::parse(&text) {
                    self.hear(now, line);
                }
            }
        }
    }

    /// Time has passed.
    pub fn tick(&mut self, now: Time) {
        match self.state {
            State::Looking { asked_at } if asked_at.is_none_or(|asked_at| now - asked_at >= ASK_AGAIN) => {
                self.state = State::Looking { asked_at: Some(now) };
                self.say(&ToBase::Hello { version: VERSION });
            }
            State::Ready if now - self.last_line_at > MOST_SILENCE => {
                self.lose(now, "it has said nothing for 0.5 s".to_owned());
            }
            State::Ready => {
                if let Some((twist, given_at, said_at)) = self.command
                    && now - given_at <= HOLD
                    && now - said_at >= SAY_AGAIN
                {
                    self.command = Some((twist, given_at, now));
                    self.say(&ToBase::Drive(twist));
                }
            }
            _ => {}
        }
    }

    /// The port is not open, or not any more.
    pub fn without_port(&mut self, now: Time, reason: String) {
        if self.state == State::Ready {
            self.lose(now, reason);
        } else {
            self.trouble = Some(reason);
        }
        self.out.clear();
        if self.is_left_or_leaving() {
            self.state = State::Left;
        }
    }

    /// A wanted velocity. A base that is not there does not get it later.
    pub fn drive(&mut self, now: Time, twist: Twist) {
        if self.state == State::Ready {
            self.command = Some((twist, now, now));
            self.say(&ToBase::Drive(twist));
        }
    }

    /// Stops the base and ends the session.
    pub fn leave(&mut self) {
        if self.is_left_or_leaving() {
            return;
        }
        let was_ready = self.state == State::Ready;
        self.state = if was_ready { State::Leaving } else { State::Left };
        if was_ready {
            self.say(&ToBase::Drive(Twist::ZERO));
            self.say(&ToBase::Bye);
        }
    }

    /// Nothing more will come, and nothing is to be said.
    pub fn is_left(&self) -> bool {
        self.state == State::Left
    }

    /// What is to be sent.
    pub fn take_out(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// The base answers.
    pub fn is_ready(&self) -> bool {
        self.state == State::Ready
    }

    /// The base, once it has told what it is.
    pub fn base(&self) -> Option<&Base> {
        self.base.as_ref()
    }

    /// What the base said last about itself.
    pub fn status(&self) -> Option<&BaseStatus> {
        self.status.as_ref()
    }

    /// What the base measured.
    pub fn readings(&mut self) -> &mut Readings {
        &mut self.readings
    }

    /// For how long the base has not answered, and why, as far as that is known.
    pub fn lost_for(&self, now: Time) -> Option<(Span, &str)> {
        let reason = self
            .trouble
            .as_deref()
            .unwrap_or("nobody answers; is the base switched on, and is this its port?");
        (!self.is_ready()).then(|| (now - self.lost_since, reason))
    }

    /// Why this base can never be driven.
    pub fn refused(&self) -> Option<&str> {
        self.refused.as_deref()
    }

    /// The next thing that people should know.
    pub fn next_event(&mut self) -> Option<LinkEvent> {
        self.events.pop_front()
    }

    /// Lines so far.
    pub fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    fn is_left_or_leaving(&self) -> bool {
        matches!(self.state, State::Leaving | State::Left)
    }

    fn say(&mut self, line: &ToBase) {
        self.out.extend(encode(self.number, &line.to_string()));
        self.number = self.number.wrapping_add(1);
    }

    fn lose(&mut self, now: Time, reason: String) {
        self.state = State::Looking { asked_at: None };
        (self.command, self.heard) = (None, (None, None, None));
        self.readings = Readings::default();
        self.lost_since = now;
        self.decoder.restart_count();
        self.trouble = Some(reason.clone());
        self.events.push_back(LinkEvent::Lost { reason });
    }

    fn hear(&mut self, now: Time, line: FromBase) {
        self.last_line_at = now;
        match line {
            FromBase::Base(identity) if identity.version == VERSION => self.heard.0 = Some(identity),
            FromBase::Base(BaseIdentity { version, .. }) | FromBase::No { version } => {
                let reason =
                    format!("it speaks version {version} of the protocol, this program speaks {VERSION}");
                self.refused = Some(reason);
            }
            FromBase::Sonars(ring) => self.heard.1 = Some(ring),
            FromBase::Bumpers(ring) => self.heard.2 = Some(ring),
            FromBase::Bye if self.state == State::Leaving => self.state = State::Left,
            line if self.state == State::Ready => self.keep(now, line),
            // Readings of a session that is over or has not begun.
            _ => {}
        }
        self.become_ready();
    }

    fn become_ready(&mut self) {
        if !matches!(self.state, State::Looking { .. }) {
            return;
        }
        // Answers may be lost or stand in any order; all three are needed.
        let (Some(identity), Some(sonars), Some(bumpers)) = &self.heard else { return };
        let (identity, sonars, bumpers) = (identity.clone(), *sonars, *bumpers);
        self.wheels.begin(identity.boot);
        self.events.push_back(LinkEvent::Found { name: identity.name.clone() });
        self.base = Some(Base { identity, sonars, bumpers });
        (self.state, self.trouble) = (State::Ready, None);
    }

    fn keep(&mut self, now: Time, line: FromBase) {
        match line {
            FromBase::Wheels(report) => {
                let value = self.wheels.add_up(&report.wheels);
                self.readings.wheels = Some(Stamped { value, at: now });
            }
            FromBase::Ranges { readings, .. } => self.keep_ranges(now, &readings),
            FromBase::Touch { pressed, .. } => {
                self.readings.touch = Some(Stamped { value: pressed, at: now })
            }
            FromBase::State(status) => self.keep_status(status),
            _ => {}
        }
    }

    /// REP-117: infinite without an echo, not-a-number without a reading.
    fn keep_ranges(&mut self, now: Time, readings: &[SonarReading]) {
        let n_sonars = self.base.as_ref().map_or(0, |base| base.sonars.n_sonars as usize);
        if readings.len() != n_sonars {
            return;
        }
        let range_m = |reading: &SonarReading| match reading {
            SonarReading::Echo(range_mm) => *range_mm as f32 / 1000.0,
            SonarReading::Nothing => f32::INFINITY,
            SonarReading::Lost => f32::NAN,
        };
        let value = readings.iter().map(range_m).collect();
        self.readings.ranges_m = Some(Stamped { value, at: now });
    }

    fn keep_status(&mut self, status: BaseStatus) {
        let before = self.status.replace(status);
        let was = |read: fn(&BaseStatus) -> bool| before.as_ref().is_some_and(read);
        if status.is_emergency != was(|status| status.is_emergency) {
            self.events.push_back(LinkEvent::Emergency { is_pressed: status.is_emergency });
        }
        if status.is_battery_low && !was(|status| status.is_battery_low) {
            self.events.push_back(LinkEvent::BatteryLow { millivolts: status.battery_mv });
        }
        // Without a command there is nothing to wait for: a base that nobody drives yet stands, too.
        if status.is_watchdog && !was(|status| status.is_watchdog) && self.command.is_some() {
            self.events.push_back(LinkEvent::StoppedByItself);
        }
    }
}

#[cfg(test)]
mod tests;
