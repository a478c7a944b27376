//! A planner on a thread of its own that takes too long.

use super::super::at_work::Place;
use super::super::watchdog::{Lost, StepLimits};
use super::{Event, EventKind, Navigator, Outcome, Planning, Time};

impl Planning {
    /// Asks a planner beside the step to give up when it takes too long, and goes on without one that does not obey: the
    /// robot stands, and the mission ends.
    pub(super) fn wait(&mut self, nav: &mut Navigator, now: Time, events: &mut Vec<Event>) {
        let Some(running) = self.running.as_ref().filter(|running| running.is_beside) else { return };
        let waited = (now - running.asked).as_secs();
        let StepLimits { step, obey } = self.limits;
        if waited < step.as_secs_f64() {
            return;
        }
        running.job.give_up();
        if waited < (step + obey).as_secs_f64() {
            return;
        }
        let lost =
            Lost { who: self.at_work.name(place(running.by_fallback)).to_owned(), limits: self.limits };
        if let Some(running) = self.running.take() {
            running.job.abandon();
        }
        let (stage, error) = ("planner".to_owned(), lost.to_string());
        events.push(Event { stamp: now, kind: EventKind::StageFailed { stage, error } });
        nav.end(now, Outcome::PlannerFailed(lost.to_string()), events);
    }
}

/// Where a planner sits.
pub(super) fn place(by_fallback: bool) -> Place {
    if by_fallback { Place::Fallback } else { Place::Planner }
}
