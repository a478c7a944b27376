//! One step: how data flows from the sensors to the wheels.

use super::at_work::{AtWork, Place};
use super::events::{Event, EventKind};
use super::following::Following;
use super::guard::Guard;
use super::inbox::Inbox;
use super::localization::Localization;
use super::navigator::Navigator;
use super::order::{Order, State};
use super::planning::Planning;
use super::ring::{Filter, Ring};
use super::schedule::{Schedule, TaskId};
use super::scripted::ScriptedDrive;
use super::seat::Seat;
use super::sense::SensorSeat;
use super::stall::StallMonitor;
use super::timing::{Part, StageTimes};
use super::watchdog::StepLimits;
use super::wish::WishMotion;
use crate::frames::Pose3;
use crate::map::{Layer, Map};
use crate::messages::{Command, Goal, Observations, Status};
use crate::odometry_track::OdometryTrack;
use crate::robot::Robot;
use crate::stages::{Advance, Avoider, Cx, GiveUp, Localizer, MapBuilder, MapInput, World, WorldError};
use crate::time::{Span, Time};
use crate::trace::{Drawing, Trace};
use std::sync::Arc;
use std::time::Instant;

/// A navigation system at work. Fields are dropped from top to bottom: jobs, stages, sensors, world.
pub struct Engine {
    pub(super) planning: Planning,
    pub(super) avoider: Option<Seat<Box<dyn Avoider>>>,
    pub(super) builders: Vec<Seat<Box<dyn MapBuilder>>>,
    pub(super) localization: Localization,
    pub(super) odometer: Option<Seat<Box<dyn Localizer>>>,
    pub(super) sensors: Vec<SensorSeat>,
    pub(super) world: Box<dyn World>,
    pub(super) robot: Arc<Robot>,
    pub(super) map: Map,
    pub(super) needed_layers: Vec<Layer>,
    pub(super) ring: Ring,
    pub(super) out: Observations,
    pub(super) n_new: usize,
    pub(super) track: OdometryTrack,
    pub(super) footprint_from_base: Option<Pose3>,
    pub(super) derived: Vec<bool>,
    pub(super) schedule: Schedule,
    pub(super) control: TaskId,
    pub(super) control_period: Span,
    pub(super) late: Span,
    pub(super) abort: GiveUp,
    pub(super) at_work: Arc<AtWork>,
    pub(super) limits: StepLimits,
    pub(super) guard: Guard,
    pub(super) navigator: Navigator,
    pub(super) following: Option<Following>,
    pub(super) stall: Option<StallMonitor>,
    pub(super) orders: Vec<Order>,
    pub(super) beginning: Vec<Order>,
    pub(super) inbox: Inbox,
    pub(super) given: Vec<Order>,
    pub(super) obeyed: Vec<Order>,
    pub(super) pending: Vec<Goal>,
    pub(super) has_mission: bool,
    pub(super) wanders: bool,
    pub(super) script: Option<ScriptedDrive>,
    pub(super) duration: Option<Span>,
    pub(super) wish: WishMotion,
    pub(super) status: Status,
    pub(super) estimate_is_new: bool,
    pub(super) not_actuated: bool,
    pub(super) command: Command,
    pub(super) events: Vec<Event>,
    pub(super) trace: Trace,
    pub(super) times: StageTimes,
    pub(super) now: Time,
    pub(super) started: Time,
    pub(super) recorded: bool,
    pub(super) stage_drawings: Vec<Drawing>,
    pub(super) counters: Vec<(&'static str, f64)>,
    pub(super) step: u64,
}

/// What became of a step.
#[derive(Debug, Clone, PartialEq)]
pub enum Stepped {
    /// There is a next one.
    Went,
    /// The world is over.
    Ended,
    /// The world failed; nothing can go on.
    Failed(WorldError),
}

impl Engine {
    /// One step at the earliest due time, in the order in which data flows.
    ///
    /// ```text
    ///  World ─► Sensor ─► (Odometer) ─► Localizer ─► Planner ─► Avoider ─► Guard ─► World
    ///              └───────────────────────┴──► MapBuilder (closes the step)
    /// ```
    /// A scan enters the map only after the localizer has used the map, else it would be matched against itself.
    pub fn step(&mut self) -> Stepped {
        self.events.clear();
        match self.advance() {
            Ok(Advance::Reached(now)) => self.now = now,
            Ok(Advance::Ended) => return Stepped::Ended,
            Err(error) => return Stepped::Failed(error),
        }
        self.sense();
        self.track_odometry();
        self.at_work.enter(Place::Finder);
        self.obey();
        self.localize();
        self.plan();
        if self.schedule.take(self.control, self.now) {
            let wanted = self.steer();
            let allowed = self.guard(wanted);
            if let Err(error) = self.drive(allowed) {
                return Stepped::Failed(error);
            }
        }
        self.insert();
        self.forget();
        if self.trace.is_counting() {
            (self.stage_drawings, self.counters) = self.trace.take();
            self.counters.append(&mut self.planning.counters);
        }
        self.step += 1;
        Stepped::Went
    }

    /// World: time passes until something is due.
    fn advance(&mut self) -> Result<Advance, WorldError> {
        let clock = Instant::now();
        self.at_work.enter(Place::World);
        let recorded = self.world.next_recorded();
        self.recorded = recorded.is_some();
        let due = [self.schedule.next(), self.planning.due(), recorded];
        let next = due.into_iter().flatten().min().unwrap_or(Time::MAX).max(self.now);
        let advanced = self.world.advance(next);
        while let Some(text) = self.world.take_notice() {
            self.events.push(Event { stamp: self.now, kind: EventKind::Notice(text) });
        }
        if let Ok(Advance::Reached(now)) = advanced {
            self.late = now - next;
        }
        self.times.add(Part::World, clock);
        advanced
    }

    /// ─► Localizer: where the robot is, on the map as the step before left it.
    fn localize(&mut self) {
        let clock = Instant::now();
        self.estimate_is_new = false;
        let searching = self.navigator.state == State::Localizing;
        let is_mapping = self.localization.finder.stage.is_mapping();
        let active = is_mapping || !matches!(self.navigator.state, State::NoMap | State::Lost);
        // Both are asked in any case: a run that is due and not taken would hold the clock for ever.
        let finder_due = self.localization.finder.is_due(&mut self.schedule, &self.ring, self.now);
        let relocalizer = self.localization.relocalizer.as_ref();
        let relocalizer_due = relocalizer.map(|seat| seat.is_due(&mut self.schedule, &self.ring, self.now));
        let due = relocalizer_due.filter(|_| searching).unwrap_or(finder_due);
        if active && due {
            let place =
                if searching && relocalizer_due.is_some() { Place::Relocalizer } else { Place::Finder };
            self.at_work.enter(place);
            let mut cx = Cx { now: self.now, trace: &self.trace };
            let (ring, map) = (&mut self.ring, &mut self.map);
            self.estimate_is_new =
                self.localization.update(searching, self.not_actuated, &mut cx, ring, map, &mut self.events);
        }
        if self.estimate_is_new {
            self.heed_estimate();
        }
        self.times.add(Part::Localizer, clock);
    }

    fn heed_estimate(&mut self) {
        let estimate = &self.localization.estimate;
        let was_near = matches!(self.status, Status::Converging | Status::Ambiguous);
        let gave_up = self.localization.relocalizer.is_some() && was_near && estimate.status == Status::Lost;
        if estimate.status != self.status {
            self.status = estimate.status;
            self.events.push(Event { stamp: self.now, kind: EventKind::Status(self.status) });
        }
        if self.navigator.state == State::Localizing {
            self.wish.take(estimate.wish);
        }
        if gave_up && self.navigator.state == State::Localizing {
            self.wish.clear();
            return self.navigator.not_found(self.now, &mut self.events);
        }
        let goals = self.navigator.on_status(self.now, self.status, &mut self.events);
        if !goals.is_empty() {
            self.pending = goals;
        }
    }

    /// ─► MapBuilder: closes the step.
    fn insert(&mut self) {
        let clock = Instant::now();
        let located = !matches!(self.navigator.state, State::NoMap | State::Lost | State::Localizing);
        for (idx, seat) in self.builders.iter_mut().enumerate() {
            // Asked in any case: a run that is due and not taken would hold the clock for ever.
            let is_due = seat.is_due(&mut self.schedule, &self.ring, self.now);
            if !(located && is_due) {
                continue;
            }
            self.at_work.enter(Place::MapBuilder(idx));
            seat.report_loss(&self.ring, self.now, &mut self.events);
            let read = self.ring.cursor();
            let seen = self.ring.seen(seat.cursor, Filter::Public);
            let input = MapInput { seen, estimate: &self.localization.estimate };
            let mut cx = Cx { now: self.now, trace: &self.trace };
            let result = seat.stage.insert(&mut cx, &input, &mut self.map);
            seat.settle(result, read, self.now, &mut self.events);
        }
        self.times.add(Part::MapBuilders, clock);
    }
}
