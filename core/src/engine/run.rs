//! From the first step to the last: orders, ends, shutdown.

use super::at_work::Place;
use super::navigator::Outcome;
use super::observer::Observer;
use super::order::State;
use super::seat::MOST_FAILURES;
use super::step::{Engine, Stepped};
use super::watchdog::{StepLimits, Watchdog};
use crate::frames::Twist;
use crate::messages::Command;
use crate::time::Span;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum EndReason {
    /// All waypoints were reached.
    Arrived,
    /// A waypoint cannot be reached.
    Unreachable,
    /// Many plans, no progress.
    Stuck,
    /// A waypoint took longer than `goal_timeout_s`.
    Timeout,
    /// The planner failed.
    PlannerFailed,
    /// A stage failed again and again.
    StageFailed,
    /// The recording is over.
    Ended,
    /// `duration_s`, or a scripted drive, is over.
    Finished,
    /// The mission took longer than `time_limit_s`.
    TimeLimit,
    /// Somebody asked to stop.
    Interrupted,
    /// The world failed.
    WorldFailed,
    /// One step took longer than the watchdog waits.
    Stalled,
}

impl fmt::Display for EndReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EndReason::Arrived => "arrived",
            EndReason::Unreachable => "unreachable",
            EndReason::Stuck => "stuck",
            EndReason::Timeout => "timeout",
            EndReason::PlannerFailed => "planner_failed",
            EndReason::StageFailed => "stage_failed",
            EndReason::Ended => "ended",
            EndReason::Finished => "finished",
            EndReason::TimeLimit => "time_limit",
            EndReason::Interrupted => "interrupted",
            EndReason::WorldFailed => "world_failed",
            EndReason::Stalled => "stalled",
        })
    }
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunEnd {
    /// Why.
    pub reason: EndReason,
    /// More, for people.
    pub detail: Option<String>,
}

impl RunEnd {
    fn new(reason: EndReason, detail: Option<String>) -> RunEnd {
        RunEnd { reason, detail }
    }
}

impl Engine {
    /// End of a run that has neither mission nor duration, seconds.
    const DEFAULT_DURATION_S: f64 = 60.0;

    /// Steps until the run ends, and shuts down. `interrupt` may be raised from outside at any time.
    pub fn run(&mut self, observers: &mut [&mut dyn Observer], interrupt: &AtomicBool) -> RunEnd {
        let watchdog = Watchdog::start(self.abort.clone(), self.at_work.clone(), self.limits);
        let end = loop {
            watchdog.begin();
            let stepped = self.step();
            if watchdog.feed() {
                let detail = format!("one step took more than {} s", self.limits.step.as_secs_f32());
                break RunEnd::new(EndReason::Stalled, Some(detail));
            }
            self.at_work.enter(Place::Nobody);
            match stepped {
                Stepped::Went => {}
                Stepped::Ended => {
                    // What the world says at its end belongs to the run.
                    if !self.events.is_empty() {
                        let view = self.view();
                        observers.iter_mut().for_each(|observer| observer.on_step(&view));
                    }
                    break RunEnd::new(EndReason::Ended, None);
                }
                Stepped::Failed(error) => break RunEnd::new(EndReason::WorldFailed, Some(error.to_string())),
            }
            let view = self.view();
            observers.iter_mut().for_each(|observer| observer.on_step(&view));
            if interrupt.load(Ordering::Relaxed) || self.navigator.shutdown {
                break RunEnd::new(EndReason::Interrupted, None);
            }
            if let Some(end) = self.end() {
                break end;
            }
        };
        self.shut_down();
        end
    }

    /// How long stages are waited for; for tests, which have less time.
    #[doc(hidden)]
    pub fn set_limits(&mut self, limits: StepLimits) {
        self.limits = limits;
        self.planning.limits = limits;
    }

    /// The run is over, and this is why.
    fn end(&mut self) -> Option<RunEnd> {
        if let Some((stage, error)) = self.failing_stage(MOST_FAILURES) {
            let detail = format!("`{stage}` failed again and again: {error}");
            return Some(RunEnd::new(EndReason::StageFailed, Some(detail)));
        }
        let since_start = self.now - self.started;
        if self.has_mission || self.following.is_some() {
            let limit = Span::from_secs(self.navigator.mission().time_limit_s);
            let over = || RunEnd::new(EndReason::TimeLimit, Some(format!("after {} s", limit.as_secs())));
            let outcome = self.navigator.outcome.take();
            let end = outcome.map(end_of).or_else(|| (since_start >= limit).then(over));
            if end.is_some() || self.has_mission {
                return end;
            }
        }
        let limit = self.duration.or_else(|| {
            if self.following.is_some() {
                return None;
            }
            // A recording ends by itself.
            self.world.next_recorded().is_none().then(|| Span::from_secs(Self::DEFAULT_DURATION_S))
        })?;
        (since_start >= limit).then(|| RunEnd::new(EndReason::Finished, None))
    }

    /// A stage that has failed so often in a row: its name and what it said last.
    pub(super) fn failing_stage(&self, at_least: u32) -> Option<(&str, &str)> {
        let searching = self.navigator.state == State::Localizing;
        let sensor = self.sensors.iter().find_map(|sensor| sensor.seat.failed(at_least));
        let odometer = self.odometer.as_ref().and_then(|seat| seat.failed(at_least));
        let localizer = self.localization.failed(searching, at_least);
        let avoider = self.avoider.as_ref().and_then(|seat| seat.failed(at_least));
        let builder = self.builders.iter().find_map(|seat| seat.failed(at_least));
        sensor.or(odometer).or(localizer).or(avoider).or(builder)
    }

    /// Stops the wheels and tells slow work to end; stages, sensors and world go in this order when the engine is
    /// dropped.
    pub fn shut_down(&mut self) {
        let stop = Command { stamp: self.now, twist: Twist::ZERO };
        // The run is over: a world that does not take its last command has stopped already.
        let _ = self.world.drive(&stop);
        self.planning.give_up();
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.shut_down();
    }
}

fn end_of(outcome: Outcome) -> RunEnd {
    match outcome {
        Outcome::Arrived => RunEnd::new(EndReason::Arrived, None),
        Outcome::Driven => RunEnd::new(EndReason::Finished, None),
        Outcome::Unreachable(reason) => RunEnd::new(EndReason::Unreachable, Some(reason)),
        Outcome::Stuck(reason) => RunEnd::new(EndReason::Stuck, Some(reason)),
        Outcome::TimedOut => RunEnd::new(EndReason::Timeout, None),
        Outcome::PlannerFailed(reason) => RunEnd::new(EndReason::PlannerFailed, Some(reason)),
    }
}
