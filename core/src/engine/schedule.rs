//! What is due when. Times are computed from the run's number, never added up.

use crate::pipeline::Rate;
use crate::time::{Span, Time};

/// A place in the schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskId(usize);

#[derive(Debug)]
struct Task {
    rate: Rate,
    runs: u64,
}

impl Task {
    fn due(&self, start: Time) -> Time {
        start + Span(self.rate.due(self.runs).0)
    }
}

/// Due times of everything that has a rate.
#[derive(Debug, Default)]
pub struct Schedule {
    start: Time,
    tasks: Vec<Task>,
}

impl Schedule {
    /// A schedule whose first runs are due at `start`.
    pub fn from(start: Time) -> Schedule {
        Schedule { start, tasks: Vec::new() }
    }

    /// Adds something that runs at this rate, first at the start.
    pub fn add(&mut self, rate: Rate) -> TaskId {
        self.tasks.push(Task { rate, runs: 0 });
        TaskId(self.tasks.len() - 1)
    }

    /// The earliest due time.
    pub fn next(&self) -> Option<Time> {
        self.tasks.iter().map(|task| task.due(self.start)).min()
    }

    /// This task is due now or was due before; if so, it is counted as run, and runs that were missed are skipped.
    pub fn take(&mut self, id: TaskId, now: Time) -> bool {
        let start = self.start;
        let Some(task) = self.tasks.get_mut(id.0) else { return false };
        if task.due(start) > now {
            return false;
        }
        // A long gap is jumped over, its last few runs are counted one by one to be exact.
        let missed = (now - task.due(start)).as_secs() / task.rate.period().as_secs();
        task.runs += (missed as u64).saturating_sub(2);
        while task.due(start) <= now {
            task.runs += 1;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_that_share_no_divisor_meet_exactly() {
        let mut schedule = Schedule::default();
        let (laser, wheels) = (schedule.add(Rate::Hz(37.5)), schedule.add(Rate::Hz(20.0)));
        let (mut n_laser, mut n_wheels, mut n_both) = (0, 0, 0);
        while let Some(now) = schedule.next().filter(|t| *t < Time::from_secs(60.0)) {
            let (l, w) = (schedule.take(laser, now), schedule.take(wheels, now));
            n_laser += u32::from(l);
            n_wheels += u32::from(w);
            n_both += u32::from(l && w);
        }
        assert_eq!((n_laser, n_wheels, n_both), (2250, 1200, 150));
    }

    #[test]
    fn missed_runs_are_skipped_not_piled_up() {
        let mut schedule = Schedule::default();
        let task = schedule.add(Rate::Every(1.0));
        assert!(schedule.take(task, Time::from_secs(10.5)));
        assert!(!schedule.take(task, Time::from_secs(10.9)));
        assert_eq!(schedule.next(), Some(Time::from_secs(11.0)));
    }

    #[test]
    fn a_clock_that_starts_long_ago_costs_nothing() {
        let epoch = Time(1_800_000_000_000_000_000);
        let mut schedule = Schedule::from(epoch);
        let task = schedule.add(Rate::Hz(1e6));
        assert_eq!(schedule.next(), Some(epoch));
        let later = epoch + Span::from_secs(1e6);
        assert!(schedule.take(task, later));
        assert_eq!(schedule.next(), Some(later + Span(1000)));
    }
}
