//! Asking planners, beside the step: a plan never delays control.

mod beside;

use super::at_work::AtWork;
use super::events::{Event, EventKind};
use super::known_grid::KnownGrid;
use super::navigator::{Navigator, Outcome};
use super::order::State;
use super::schedule::{Schedule, TaskId};
use super::watchdog::StepLimits;
use crate::frames::{Point2, Pose2};
use crate::map::Map;
use crate::messages::{Check, Goal, Path};
use crate::robot::Robot;
use crate::stages::{Background, BackgroundJob, PlanError, PlanRequest, Planner};
use crate::time::Time;
use crate::trace::{Drawing, Trace};
use std::sync::Arc;

/// A planner and the way to run it.
pub(super) struct PlannerSeat {
    /// The plugin; away while it works.
    pub planner: Option<Box<dyn Planner>>,
    /// Where it works.
    pub background: Background,
}

struct Planned {
    planner: Box<dyn Planner>,
    result: Result<Path, PlanError>,
    seen: (Vec<Drawing>, Vec<(&'static str, f64)>),
}

struct Running {
    job: BackgroundJob<Planned>,
    goal: Goal,
    by_fallback: bool,
    asked: Time,
    /// It works on a thread of its own, in the world's own time.
    is_beside: bool,
}

/// What a plan starts from.
pub(super) struct Situation<'a> {
    /// The time it is.
    pub now: Time,
    /// The robot.
    pub map_from_base: Pose2,
    /// The map.
    pub map: &'a Map,
    /// What a planner's trace is like.
    pub trace: &'a Trace,
}

/// All planning of a run.
pub(super) struct Planning {
    /// The planner.
    pub main: Option<PlannerSeat>,
    /// Asked when the first has no answer.
    pub fallback: Option<PlannerSeat>,
    /// When to plan anew without being blocked.
    pub task: Option<TaskId>,
    /// The robot.
    pub robot: Arc<Robot>,
    /// The grid of the last request: the map's with all obstacles.
    pub grid: KnownGrid,
    /// Planners draw, whether or not the other stages do.
    pub is_drawn: bool,
    /// Debug drawings of the last plan, of both planners where the second one was asked.
    pub drawings: Vec<Drawing>,
    /// Counters of the last plan.
    pub counters: Vec<(&'static str, f64)>,
    running: Option<Running>,
    /// How long a planner on a thread of its own is waited for.
    pub limits: StepLimits,
    at_work: Arc<AtWork>,
}

impl Planning {
    /// Nothing asked yet.
    pub fn new(
        main: Option<PlannerSeat>,
        fallback: Option<PlannerSeat>,
        robot: Arc<Robot>,
        at_work: Arc<AtWork>,
    ) -> Planning {
        Planning {
            main,
            fallback,
            task: None,
            robot,
            grid: KnownGrid::default(),
            is_drawn: false,
            drawings: Vec::new(),
            counters: Vec::new(),
            running: None,
            limits: StepLimits::default(),
            at_work,
        }
    }

    /// When an answer will come that is known to come.
    pub fn due(&self) -> Option<Time> {
        self.running.as_ref().and_then(|running| running.job.due())
    }

    /// A planner is at work.
    pub fn is_at_work(&self) -> bool {
        self.running.is_some()
    }

    /// Tells a planner at work to stop.
    pub fn give_up(&self) {
        if let Some(running) = &self.running {
            running.job.give_up();
        }
    }

    /// Asks where a path is needed, and takes what has come.
    pub fn update(
        &mut self,
        nav: &mut Navigator,
        schedule: &mut Schedule,
        at: &Situation<'_>,
        events: &mut Vec<Event>,
    ) {
        let periodic = self.task.is_some_and(|task| schedule.take(task, at.now));
        if let Some(since) = nav.patience.take_due(at.now) {
            ask_again(since, nav, at, events);
        }
        if nav.state != State::Navigating {
            self.give_up();
        } else if (nav.needs_plan || (periodic && nav.path.is_some())) && self.running.is_none() {
            let replans = if nav.needs_plan { nav.replans } else { 0 };
            events.push(Event { stamp: at.now, kind: EventKind::PlanRequested { replans } });
            nav.needs_plan = false;
            self.ask(false, nav, at, events);
        }
        self.receive(nav, at, events);
    }

    fn ask(&mut self, by_fallback: bool, nav: &mut Navigator, at: &Situation<'_>, events: &mut Vec<Event>) {
        let Some(goal) = nav.goal().copied() else { return };
        self.grid.renew(at.map.grid.as_ref(), nav.memory.obstacles());
        let seat = if by_fallback { &mut self.fallback } else { &mut self.main };
        let Some(seat) = seat else { return self.straight(nav, at, events) };
        let Some(mut planner) = seat.planner.take() else {
            let gone = "the planner is gone: it panicked, or did not come back".to_owned();
            return nav.end(at.now, Outcome::PlannerFailed(gone), events);
        };
        let mut request = PlanRequest {
            stamp: at.now,
            map: at.map.clone(),
            grid: self.grid.get().cloned(),
            start: at.map_from_base,
            goal,
            robot: self.robot.clone(),
            obstacles: nav.memory.obstacles().to_vec(),
            give_up: Default::default(),
            trace: if self.is_drawn { Trace::watched() } else { at.trace.fresh() },
        };
        let is_beside = seat.background.is_threaded();
        if !is_beside {
            self.at_work.enter(beside::place(by_fallback));
        }
        let job = seat.background.run(at.now, move |give_up| {
            request.give_up = give_up.clone();
            let result = planner.plan(&request);
            Planned { planner, result, seen: request.trace.take() }
        });
        self.running = Some(Running { job, goal, by_fallback, asked: at.now, is_beside });
    }

    /// No planner: the path is the list of waypoints.
    fn straight(&mut self, nav: &mut Navigator, at: &Situation<'_>, events: &mut Vec<Event>) {
        let start = Point2::from(at.map_from_base.translation.vector);
        let positions: Vec<Point2> = std::iter::once(start).chain(nav.goal().map(|g| g.position)).collect();
        if let Some(path) = Path::through(positions, 0.0) {
            self.accept(path, nav, at.now, events);
        }
    }

    fn receive(&mut self, nav: &mut Navigator, at: &Situation<'_>, events: &mut Vec<Event>) {
        let Some(running) = &mut self.running else { return };
        let polled = running.job.poll(at.now);
        let planned = match polled {
            Ok(None) => return self.wait(nav, at.now, events),
            Ok(Some(planned)) => planned,
            Err(panicked) => {
                self.running = None;
                return nav.end(at.now, Outcome::PlannerFailed(panicked.to_string()), events);
            }
        };
        let (goal, by_fallback) = (running.goal, running.by_fallback);
        self.running = None;
        let (drawings, counters) = planned.seen;
        if !by_fallback {
            self.drawings.clear();
        }
        self.drawings.extend(drawings);
        self.counters = counters;
        let seat = if by_fallback { &mut self.fallback } else { &mut self.main };
        if let Some(seat) = seat {
            seat.planner = Some(planned.planner);
        }
        if nav.state != State::Navigating || nav.goal() != Some(&goal) {
            // An answer to a question that nobody asks any more; the present one is asked in the next step.
            nav.needs_plan = nav.state == State::Navigating;
            return;
        }
        match planned.result {
            Ok(path) => self.accept(path, nav, at.now, events),
            Err(PlanError::GivenUp) => nav.needs_plan = true,
            Err(error) => self.refuse(error, by_fallback, nav, at, events),
        }
    }

    fn accept(&mut self, path: Path, nav: &mut Navigator, now: Time, events: &mut Vec<Event>) {
        if let Err(fault) = path.check() {
            let reason = format!("the planner gave a path that must not go on: {fault}");
            return nav.end(now, Outcome::PlannerFailed(reason), events);
        }
        events.push(Event { stamp: now, kind: EventKind::PlanFound { length_m: path.length_m() } });
        nav.follow(path);
    }

    fn refuse(
        &mut self,
        error: PlanError,
        by_fallback: bool,
        nav: &mut Navigator,
        at: &Situation<'_>,
        events: &mut Vec<Event>,
    ) {
        let reason = error.to_string();
        events.push(Event { stamp: at.now, kind: EventKind::PlanFailed { reason: reason.clone() } });
        if nav.path.is_some() {
            // This was a plan beside a path that still holds; the avoider says when it does not.
            return;
        }
        if !by_fallback && self.fallback.is_some() {
            events.push(Event { stamp: at.now, kind: EventKind::FallbackAsked { reason } });
            self.ask(true, nav, at, events);
            return self.receive(nav, at, events);
        }
        let n_obstacles = if nav.has_forgotten { 0 } else { nav.memory.forget_old(at.now) };
        if n_obstacles > 0 {
            nav.has_forgotten = true;
            let reason = "no way was left, and nothing had seen them for long";
            events.push(Event { stamp: at.now, kind: EventKind::Forgot { n_obstacles, reason } });
            nav.needs_plan = true;
            return;
        }
        let outcome = match error {
            PlanError::MissingLayer { .. } | PlanError::NotFinite { .. } | PlanError::Other(_) => {
                Outcome::PlannerFailed(reason)
            }
            _ if nav.memory.may_change() && nav.patience.no_way(at.now).is_some() => return,
            _ => Outcome::Unreachable(reason),
        };
        nav.end(at.now, outcome, events);
    }
}

/// The robot has stood without a way since then: somebody may have walked by.
fn ask_again(since: Time, nav: &mut Navigator, at: &Situation<'_>, events: &mut Vec<Event>) {
    nav.needs_plan = nav.state == State::Navigating;
    let n_obstacles = nav.memory.forget_unseen(at.map_from_base.translation.vector.into(), since);
    if n_obstacles > 0 {
        let reason = "nothing has seen them beside the robot since there was no way";
        events.push(Event { stamp: at.now, kind: EventKind::Forgot { n_obstacles, reason } });
    }
}
