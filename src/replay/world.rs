//! The world of a replay: it says what was recorded, when it was recorded, and moves nothing.

use rumbo_core::engine::Inbox;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Command, Observation};
use rumbo_core::stages::{Advance, Answer, Drove, Probe, Truth, World, WorldError};
use rumbo_core::time::Time;
use rumbo_kit::recording::{RecordedEvent, RecordedStep, RecordingReader, RunHeader};
use std::collections::VecDeque;
use std::path::Path;

/// How a replay follows its recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follow {
    /// Step for step: the same pipeline takes the same steps.
    Steps,
    /// By time: another pipeline may take others.
    Times,
}

/// One sensor's channel: what has become due, and what was handed out last.
#[derive(Debug, Default)]
struct Channel {
    due: Vec<Observation>,
    given: Vec<Observation>,
    failed: bool,
}

/// A recording that plays.
pub struct ReplayWorld {
    reader: RecordingReader,
    header: RunHeader,
    follow: Follow,
    /// Sensors that the recording has inputs of; the others derive theirs.
    is_input: Vec<bool>,
    channels: Vec<Channel>,
    ahead: Option<RecordedStep>,
    notices: VecDeque<String>,
    inbox: Inbox,
    now: Time,
    truth: Option<Truth>,
    is_actuated: bool,
    is_over: bool,
}

impl ReplayWorld {
    /// A world at the first step. `is_input` says of each sensor whether it reads the world.
    pub fn new(
        mut reader: RecordingReader,
        follow: Follow,
        is_input: Vec<bool>,
        inbox: Inbox,
    ) -> ReplayWorld {
        let header = reader.header().clone();
        let ahead = reader.next_step();
        ReplayWorld {
            now: header.started,
            channels: header.sensors.iter().map(|_| Channel::default()).collect(),
            header,
            follow,
            is_input,
            ahead,
            notices: VecDeque::new(),
            inbox,
            truth: None,
            is_actuated: true,
            is_over: false,
            reader,
        }
    }

    fn time_ahead(&self) -> Option<Time> {
        self.ahead.as_ref().and_then(|step| step.mark.map(|mark| mark.now))
    }

    /// What the step ahead brought becomes due.
    fn deliver(&mut self) {
        let Some(step) = self.ahead.take() else { return };
        for observation in step.observations {
            let idx = usize::from(observation.sensor.0);
            let is_input = self.is_input.get(idx).copied().unwrap_or(false);
            if let Some(channel) = self.channels.get_mut(idx).filter(|_| is_input) {
                channel.due.push(observation);
            }
        }
        for event in &step.events {
            self.recall(event);
        }
        self.is_actuated = step.is_actuated.unwrap_or(self.is_actuated);
        self.truth = step.mark.and_then(|mark| mark.truth);
        step.orders.into_iter().for_each(|order| self.inbox.put(order));
        self.ahead = self.reader.next_step();
    }

    /// Events that came from outside: what the world said, and devices that failed.
    fn recall(&mut self, event: &RecordedEvent) {
        if event.kind == "Notice" {
            self.notices.push_back(event.text.clone());
        }
        if event.kind == "StageFailed" {
            let names = self.header.sensors.iter().zip(&mut self.channels);
            for (name, channel) in names {
                channel.failed |=
                    event.text.strip_prefix(name).is_some_and(|rest| rest.starts_with(" failed: "));
            }
        }
    }
}

impl World for ReplayWorld {
    fn now(&self) -> Time {
        self.now
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        if to < self.now {
            return Err(WorldError::Backwards { now: self.now, to });
        }
        self.channels.iter_mut().for_each(|channel| channel.failed = false);
        let Some(next) = self.time_ahead() else {
            // What the world said after its last step is said again.
            if !self.is_over {
                self.is_over = true;
                self.deliver();
            }
            return Ok(Advance::Ended);
        };
        match self.follow {
            Follow::Steps => {
                self.deliver();
                // A robot's clock may have gone past what was due; a simulated one never does.
                self.now = if self.header.is_real_time { next } else { to };
            }
            Follow::Times => {
                while self.time_ahead().is_some_and(|next| next <= to) {
                    self.deliver();
                }
                self.now = to;
            }
        }
        Ok(Advance::Reached(self.now))
    }

    fn drive(&mut self, _command: &Command) -> Result<Drove, WorldError> {
        Ok(if self.is_actuated { Drove::Drove } else { Drove::NotActuated })
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        let refused = WorldError::Unsupported { probe: probe.name() };
        let Probe::Channel { name } = probe else { return Err(refused) };
        let idx = self.header.sensors.iter().position(|known| known == name);
        let channel = idx.and_then(|idx| self.channels.get_mut(idx)).ok_or(refused.clone())?;
        if channel.failed {
            return Err(refused);
        }
        channel.given.clear();
        channel.given.append(&mut channel.due);
        Ok(Answer::Recorded(&channel.given))
    }

    fn truth(&self) -> Option<&Truth> {
        self.truth.as_ref()
    }

    fn start(&self) -> Option<Pose2> {
        self.header.start
    }

    fn map_file(&self) -> Option<&Path> {
        self.header.map_file.as_deref()
    }

    fn recording_file(&self) -> Option<&Path> {
        self.header.recording_file.as_deref()
    }

    fn take_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    fn next_recorded(&self) -> Option<Time> {
        self.header.is_recording.then(|| self.time_ahead().unwrap_or(self.now).max(self.now))
    }
}
