//! One step: how data flows from the sensors to the wheels.

use super::events::{Event, EventKind};
use super::guard::{self, Guard};
use super::localization::Localization;
use super::navigator::{Navigator, Order, State};
use super::observer::StepView;
use super::odometry_track::OdometryTrack;
use super::planning::{self, Planning};
use super::ring::{Filter, Ring};
use super::schedule::{Schedule, TaskId};
use super::seat::Seat;
use super::timing::{Part, StageTimes};
use super::wish::WishMotion;
use crate::frames::{Pose2, Twist, flatten};
use crate::map::{Layer, Map};
use crate::messages::{
    Check, Command, Data, Goal, MessageFault, Observation, Observations, Odometry, SensorId, Status, Wish,
};
use crate::robot::Robot;
use crate::stages::{
    Advance, AvoidInput, Avoider, Cx, Drove, GiveUp, Localizer, MapBuilder, MapInput, Sensor, Steering,
    World, WorldError,
};
use crate::time::{Span, Time};
use crate::trace::{Drawing, Trace};
use std::sync::Arc;
use std::time::Instant;

/// A sensor in its place.
pub(super) struct SensorSeat {
    pub seat: Seat<Box<dyn Sensor>>,
    pub inputs: Vec<SensorId>,
}

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
    pub(super) schedule: Schedule,
    pub(super) control: TaskId,
    pub(super) control_period: Span,
    pub(super) late: Span,
    pub(super) abort: GiveUp,
    pub(super) guard: Guard,
    pub(super) navigator: Navigator,
    pub(super) orders: Vec<Order>,
    pub(super) pending: Vec<Goal>,
    pub(super) has_mission: bool,
    pub(super) wanders: bool,
    pub(super) duration: Option<Span>,
    pub(super) wish: WishMotion,
    pub(super) status: Status,
    pub(super) estimate_is_new: bool,
    pub(super) failed: bool,
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
        self.failed = false;
        match self.advance() {
            Ok(Advance::Reached(now)) => self.now = now,
            Ok(Advance::Ended) => return Stepped::Ended,
            Err(error) => return Stepped::Failed(error),
        }
        self.sense();
        self.track_odometry();
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
        if self.trace.is_watched() {
            (self.stage_drawings, self.counters) = self.trace.take();
        }
        self.step += 1;
        Stepped::Went
    }

    /// World: time passes until something is due.
    fn advance(&mut self) -> Result<Advance, WorldError> {
        let clock = Instant::now();
        let recorded = self.world.next_recorded();
        self.recorded = recorded.is_some();
        let due = [self.schedule.next(), self.planning.due(), recorded];
        let next = due.into_iter().flatten().min().unwrap_or(Time::MAX).max(self.now);
        let advanced = self.world.advance(next);
        if let Ok(Advance::Reached(now)) = advanced {
            self.late = now - next;
        }
        self.times.add(Part::World, clock);
        advanced
    }

    /// World ─► Sensor: what is seen goes into the ring.
    fn sense(&mut self) {
        let clock = Instant::now();
        self.n_new = 0;
        for idx in 0..self.sensors.len() {
            let SensorSeat { seat, inputs } = &mut self.sensors[idx];
            // In a recording a sensor is due at the recorded stamps, whatever its rate.
            if !(seat.is_due(&mut self.schedule, &self.ring, self.now) || self.recorded && inputs.is_empty())
            {
                continue;
            }
            let (mut cx, read) = (Cx { now: self.now, trace: &self.trace }, self.ring.cursor());
            let result = if inputs.is_empty() {
                seat.stage.poll(&mut cx, self.world.as_mut(), &mut self.out)
            } else {
                let seen = self.ring.seen(seat.cursor, Filter::Of(inputs));
                if seen.is_empty() { Ok(()) } else { seat.stage.derive(&mut cx, seen, &mut self.out) }
            };
            let kept = self.collect();
            let result = result.map_err(|e| e.to_string()).and(kept.map_err(|e| e.to_string()));
            let seat = &mut self.sensors[idx].seat;
            self.failed |= seat.settle(result, read, self.now, &mut self.events).is_none();
        }
        self.times.add(Part::Sensors, clock);
    }

    /// Moves what a sensor gave into the ring; a message that must not go on stays out.
    fn collect(&mut self) -> Result<(), MessageFault> {
        let mut kept = Ok(());
        while let Some(observation) = self.out.pop_front() {
            match observation.check() {
                Ok(()) => {
                    self.ring.push(observation, &mut self.out);
                    self.n_new += 1;
                }
                Err(fault) => kept = Err(fault),
            }
        }
        kept
    }

    /// (Odometer): the only publisher of odom → base; without one, the odometry sensor is.
    fn track_odometry(&mut self) {
        let clock = Instant::now();
        if let Some(seat) = &mut self.odometer
            && seat.is_due(&mut self.schedule, &self.ring, self.now)
        {
            let (mut cx, read) = (Cx { now: self.now, trace: &self.trace }, self.ring.cursor());
            let seen = self.ring.seen(seat.cursor, Filter::Raw);
            let result = seat.stage.update(&mut cx, seen, &self.map).map_err(|e| e.to_string());
            let checked = result.and_then(|e| e.check().map(|()| e).map_err(|fault| fault.to_string()));
            match seat.settle(checked, read, self.now, &mut self.events) {
                Some(estimate) => {
                    let observation = odometry_of(&estimate.pose2(), estimate.stamp, &self.track);
                    self.ring.push(observation, &mut self.out);
                    self.n_new += 1;
                }
                None => self.failed = true,
            }
        }
        let from_odometer = self.odometer.is_some();
        for observation in self.ring.newest(self.n_new) {
            if let Data::Odometry(odometry) = &observation.data
                && observation.valid
                && from_odometer == (observation.sensor == SensorId::ODOMETER)
            {
                self.track.push(observation.stamp, odometry);
            }
        }
        for observation in self.ring.newest(self.n_new) {
            self.guard.see(observation, &self.track.at(observation.stamp));
        }
        self.times.add(Part::Localizer, clock);
    }

    /// ─► Localizer: where the robot is, on the map as the step before left it.
    fn localize(&mut self) {
        let clock = Instant::now();
        self.estimate_is_new = false;
        let searching = self.navigator.state == State::Localizing;
        let active = !matches!(self.navigator.state, State::NoMap | State::Lost);
        let due = match &self.localization.relocalizer {
            Some(seat) if searching => seat.is_due(&mut self.schedule, &self.ring, self.now),
            _ => self.localization.finder.is_due(&mut self.schedule, &self.ring, self.now),
        };
        if active && due {
            let mut cx = Cx { now: self.now, trace: &self.trace };
            let (ring, map) = (&mut self.ring, &mut self.map);
            self.estimate_is_new = self.localization.update(searching, &mut cx, ring, map, &mut self.events);
            self.failed |= !self.estimate_is_new;
        }
        if self.estimate_is_new {
            self.heed_estimate();
        }
        self.times.add(Part::Localizer, clock);
    }

    fn heed_estimate(&mut self) {
        let estimate = &self.localization.estimate;
        if estimate.status != self.status {
            self.status = estimate.status;
            self.events.push(Event { stamp: self.now, kind: EventKind::Status(self.status) });
        }
        if self.navigator.state == State::Localizing {
            self.wish.take(estimate.wish);
            if self.not_actuated && matches!(estimate.wish, Some(Wish::TurnBy(_) | Wish::MoveBy(_))) {
                let error =
                    crate::stages::LocalizeError::NeedsMotion { wish: format!("{:?}", estimate.wish) };
                self.localization.finder.fail(&error, self.now, &mut self.events);
            }
        }
        let goals = self.navigator.on_status(self.now, self.status, &mut self.events);
        if !goals.is_empty() {
            self.pending = goals;
        }
    }

    /// ─► Planner: a path where one is needed, from a planner that works beside the step.
    fn plan(&mut self) {
        let clock = Instant::now();
        let map_from_base = self.map_from_base();
        if self.navigator.state == State::Navigating {
            self.look_through_obstacles();
            self.navigator.watch(self.now, map_from_base.translation.vector.into(), &mut self.events);
        }
        let watched = self.trace.is_watched();
        let at = planning::Situation { now: self.now, map_from_base, map: &self.map, watched };
        self.planning.update(&mut self.navigator, &mut self.schedule, &at, &mut self.events);
        self.times.add(Part::Planner, clock);
    }

    fn look_through_obstacles(&mut self) {
        if self.navigator.memory.obstacles().is_empty() {
            return;
        }
        let map_from_odom = flatten(&self.localization.estimate.map_from_odom);
        let mut n_obstacles = 0;
        for observation in self.ring.newest(self.n_new) {
            let map_from_base = map_from_odom * self.track.at(observation.stamp);
            n_obstacles += self.navigator.memory.look(observation, &map_from_base);
        }
        if n_obstacles > 0 {
            let kind = EventKind::Forgot { n_obstacles, reason: "a sensor sees through them" };
            self.events.push(Event { stamp: self.now, kind });
        }
    }

    /// ─► Avoider: what to do until the next control tick.
    fn steer(&mut self) -> Twist {
        let clock = Instant::now();
        let twist = match self.navigator.state {
            State::Localizing => self.wish.steer(self.track.now()),
            State::Navigating if self.navigator.path.is_some() => self.ask_avoider(),
            State::Waiting if self.wanders => self.ask_avoider(),
            _ => Twist::ZERO,
        };
        self.times.add(Part::Avoider, clock);
        twist
    }

    fn ask_avoider(&mut self) -> Twist {
        let map_from_base = self.map_from_base();
        let Some(seat) = &mut self.avoider else { return Twist::ZERO };
        seat.report_loss(&self.ring, self.now, &mut self.events);
        let read = self.ring.cursor();
        let input = AvoidInput {
            map_from_base,
            estimate: &self.localization.estimate,
            twist: self.track.twist(),
            seen: self.ring.seen(seat.cursor, Filter::Public),
            map: &self.map,
            grid: self.planning.grid.as_ref().or(self.map.grid.as_ref()),
            path: self.navigator.path.as_ref(),
            path_number: self.navigator.path_number,
            arrival_radius_m: self.navigator.mission().arrival_radius_m,
            obstacles: self.navigator.memory.obstacles(),
            robot: &self.robot,
        };
        let result = seat.stage.steer(&mut Cx { now: self.now, trace: &self.trace }, &input);
        let checked = result.map_err(|e| e.to_string()).and_then(|steering| match &steering {
            Steering::Blocked { obstacles } => {
                let fault = obstacles.iter().find_map(|obstacle| obstacle.check().err());
                fault.map_or(Ok(steering), |fault| Err(fault.to_string()))
            }
            _ => Ok(steering),
        });
        let position = map_from_base.translation.vector.into();
        match seat.settle(checked, read, self.now, &mut self.events) {
            Some(Steering::Drive(twist)) => return twist,
            Some(Steering::Arrived) => self.navigator.arrive(self.now, &mut self.events),
            Some(Steering::Blocked { obstacles }) => {
                let n_obstacles = obstacles.len();
                self.events.push(Event { stamp: self.now, kind: EventKind::Blocked { n_obstacles } });
                self.navigator.memory.add(&obstacles, self.map.grid.as_ref());
                self.navigator.blocked(self.now, position, &mut self.events);
            }
            None => self.failed = true,
        }
        Twist::ZERO
    }

    /// ─► Guard: no plugin passes it.
    fn guard(&mut self, wanted: Twist) -> Twist {
        let clock = Instant::now();
        let situation = guard::Situation {
            now: self.now,
            odom_from_base: self.track.now_at(self.now),
            stage_failed: self.failed,
            deadline_missed: self.late > self.control_period,
        };
        let twist = self.guard.limit(wanted, &situation, &mut self.events);
        self.times.add(Part::Guard, clock);
        twist
    }

    /// ─► World: the wheels obey until the next command.
    fn drive(&mut self, twist: Twist) -> Result<(), WorldError> {
        let clock = Instant::now();
        self.command = Command { stamp: self.now, twist };
        let drove = self.world.drive(&self.command)?;
        self.not_actuated = drove == Drove::NotActuated;
        self.times.add(Part::World, clock);
        Ok(())
    }

    /// ─► MapBuilder: closes the step.
    fn insert(&mut self) {
        let clock = Instant::now();
        let located = !matches!(self.navigator.state, State::NoMap | State::Lost | State::Localizing);
        for seat in &mut self.builders {
            if !(located && seat.is_due(&mut self.schedule, &self.ring, self.now)) {
                continue;
            }
            seat.report_loss(&self.ring, self.now, &mut self.events);
            let read = self.ring.cursor();
            let seen = self.ring.seen(seat.cursor, Filter::Public);
            let input = MapInput { seen, estimate: &self.localization.estimate };
            let mut cx = Cx { now: self.now, trace: &self.trace };
            let result = seat.stage.insert(&mut cx, &input, &mut self.map);
            self.failed |= seat.settle(result, read, self.now, &mut self.events).is_none();
        }
        self.times.add(Part::MapBuilders, clock);
    }

    /// Observations that every stage has read make room.
    fn forget(&mut self) {
        let newest = self.ring.cursor();
        // A seat that is not asked at present starts from the present when it is asked again.
        let state = self.navigator.state;
        let localizing = state == State::Localizing && self.localization.relocalizer.is_some();
        if let Some(seat) = self.localization.relocalizer.as_mut().filter(|_| !localizing) {
            seat.cursor = newest;
        }
        if localizing || matches!(state, State::NoMap | State::Lost) {
            self.localization.finder.cursor = newest;
        }
        if matches!(state, State::NoMap | State::Lost | State::Localizing) {
            self.builders.iter_mut().for_each(|seat| seat.cursor = newest);
        }
        let steering = state == State::Navigating || (state == State::Waiting && self.wanders);
        if let Some(seat) = self.avoider.as_mut().filter(|_| !steering) {
            seat.cursor = newest;
        }
        let cursors = [Some(self.localization.finder.cursor)]
            .into_iter()
            .chain([self.localization.relocalizer.as_ref().map(|seat| seat.cursor)])
            .chain([
                self.odometer.as_ref().map(|seat| seat.cursor),
                self.avoider.as_ref().map(|seat| seat.cursor),
            ])
            .chain(self.builders.iter().map(|seat| Some(seat.cursor)))
            .chain(self.sensors.iter().filter(|s| !s.inputs.is_empty()).map(|s| Some(s.seat.cursor)));
        let slowest = cursors.flatten().min().unwrap_or(newest);
        // The observations of this step stay for observers.
        self.ring.forget_before(slowest.min(self.ring.before_newest(self.n_new)), &mut self.out);
    }

    /// The robot in the map, now: the last estimate moved on by the odometer, so that a slow localizer never leaves the
    /// avoider on an old pose.
    pub fn map_from_base(&self) -> Pose2 {
        flatten(&self.localization.estimate.map_from_odom) * self.track.now_at(self.now)
    }

    /// From now on stages keep debug drawings and counters for observers.
    pub fn watch(&mut self) {
        self.trace = Trace::watched();
    }

    /// The step as observers see it.
    pub fn view(&mut self) -> StepView<'_> {
        let map_from_base = self.map_from_base();
        StepView {
            now: self.now,
            step: self.step.saturating_sub(1),
            state: self.navigator.state,
            observations: self.ring.newest(self.n_new),
            estimate: &self.localization.estimate,
            estimate_is_new: self.estimate_is_new,
            map_from_base,
            odom_from_base: self.track.now_at(self.now),
            truth: self.world.truth(),
            command: &self.command,
            path: self.navigator.path.as_ref(),
            path_number: self.navigator.path_number,
            goal: self.navigator.goals.front(),
            n_goals_left: self.navigator.goals.len(),
            obstacles: self.navigator.memory.obstacles(),
            map: &self.map,
            drawings: &self.planning.drawings,
            stage_drawings: &self.stage_drawings,
            counters: &self.counters,
            events: &self.events,
            times: &self.times,
        }
    }
}

/// The odometer seat's estimate as an observation.
fn odometry_of(odom_from_base: &Pose2, stamp: Time, track: &OdometryTrack) -> Observation {
    let mut twist = Twist::ZERO;
    if let Some(last) = track.stamp() {
        let seconds = (stamp - last).as_secs();
        if seconds > 0.0 {
            let step = track.now().inverse() * odom_from_base;
            twist = Twist {
                forward_m_s: step.translation.x / seconds,
                left_m_s: step.translation.y / seconds,
                turn_rad_s: step.rotation.angle() / seconds,
            };
        }
    }
    let odometry = Odometry { odom_from_base: *odom_from_base, twist, noise: [0.0; 3] };
    Observation {
        sensor: SensorId::ODOMETER,
        stamp,
        base_from_sensor: crate::frames::Pose3::identity(),
        valid: true,
        data: Data::Odometry(odometry),
    }
}
