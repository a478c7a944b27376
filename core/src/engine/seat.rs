//! A stage in its place: what it has read, when it is due, how often it failed.

use super::events::{Event, EventKind};
use super::ring::{Cursor, Ring};
use super::schedule::{Schedule, TaskId};
use crate::time::Time;
use std::fmt;

/// A stage in its place.
pub(super) struct Seat<T> {
    /// Name of the instance.
    pub name: String,
    /// The plugin.
    pub stage: T,
    /// What it has read.
    pub cursor: Cursor,
    /// Its place in the schedule; absent where it runs on news.
    pub task: Option<TaskId>,
    /// Failures in a row.
    pub failures: u32,
    /// What the last failure said.
    pub last_error: String,
}

/// Failures in a row that end a run.
pub(super) const MOST_FAILURES: u32 = 50;

impl<T> Seat<T> {
    /// This stage runs in this step.
    pub fn is_due(&self, schedule: &mut Schedule, ring: &Ring, now: Time) -> bool {
        match self.task {
            Some(task) => schedule.take(task, now),
            None => ring.has_news(self.cursor),
        }
    }

    /// Says how many observations were dropped before this stage saw them.
    pub fn report_loss(&mut self, ring: &Ring, now: Time, events: &mut Vec<Event>) {
        let n_lost = ring.lost(self.cursor);
        if n_lost > 0 {
            let stage = self.name.clone();
            events.push(Event { stamp: now, kind: EventKind::Overflow { stage, n_lost } });
        }
    }

    /// Keeps the good result of a run that has read everything up to `read`; a failed run reads nothing.
    pub fn settle<R, E: fmt::Display>(
        &mut self,
        result: Result<R, E>,
        read: Cursor,
        now: Time,
        events: &mut Vec<Event>,
    ) -> Option<R> {
        match result {
            Ok(value) => {
                self.cursor = read;
                self.failures = 0;
                Some(value)
            }
            Err(error) => {
                self.fail(&error, now, events);
                None
            }
        }
    }

    /// Counts a failure and says so.
    pub fn fail(&mut self, error: &impl fmt::Display, now: Time, events: &mut Vec<Event>) {
        self.failures += 1;
        let (stage, error) = (self.name.clone(), error.to_string());
        self.last_error.clone_from(&error);
        events.push(Event { stamp: now, kind: EventKind::StageFailed { stage, error } });
    }

    /// Its name and last error, if it has failed so often in a row.
    pub fn failed(&self, at_least: u32) -> Option<(&str, &str)> {
        (self.failures >= at_least).then_some((self.name.as_str(), self.last_error.as_str()))
    }
}
