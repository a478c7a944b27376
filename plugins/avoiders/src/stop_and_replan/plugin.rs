//! The avoider: control, watch, and when to stop and ask for a new path.

use super::StopAndReplanParams;
use super::braking::Braking;
use super::front_watch::{Scene, WatchTuning};
use super::lane::{Lane, LaneTuning};
use super::meeting::{Advice, Meeting};
use super::sound_watch::SoundWatch;
use super::touch::add_touched;
use super::turn_then_go::{Motion, TurnThenGo};
use crate::listening::Listening;
use crate::progress::Progress;
use crate::sightings::Sightings;
use rumbo_core::frames::{Twist, flatten, is_finite2};
use rumbo_core::map::Grid;
use rumbo_core::messages::{Check, MessageFault, ObservationKind, Obstacle};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::robot::{DriveKind, Robot};
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, BuildError, Cx, Steering};
use rumbo_core::time::{Span, Time};

/// See [`StopAndReplanParams`].
#[derive(Debug)]
pub struct StopAndReplan {
    watch: WatchTuning,
    /// Echoes over time; none where single echoes count.
    sound: Option<SoundWatch>,
    /// What bumpers touched since the last call.
    touched: Vec<Obstacle>,
    /// People who walk; none where they are obstacles like others.
    meeting: Option<Meeting>,
    lane: LaneTuning,
    control: TurnThenGo,
    sightings: Sightings,
    progress: Progress,
    merge_within_cells: f64,
    /// How the stop distance grows with the speed; none where it does not.
    braking: Option<Braking>,
    listening: Listening,
    following: Option<u64>,
    /// The path is blocked, and this was said: the robot stands until another comes.
    is_blocked: bool,
}

impl StopAndReplan {
    /// Times a second that the avoider runs where nobody says how often.
    pub const DEFAULT_RATE_HZ: f64 = 10.0;
    /// Readings are kept this much farther than anything looks, for the way that the robot goes until the next, meters.
    const MARGIN_M: f64 = 0.5;
    /// Cells of a path that comes without a grid, meters.
    const USUAL_CELL_M: f64 = 0.05;
    /// The robot's velocity explains where it was at most this long ago.
    const OLDEST_S: f64 = 1.0;

    /// An avoider for this robot that is called `rate_hz` times a second.
    pub fn new(params: &StopAndReplanParams, robot: &Robot, rate_hz: f64) -> StopAndReplan {
        let params = params.effective();
        let watch = params.watch(robot);
        let braking = Braking::of(robot);
        let looks_m =
            [watch.stop_distance_m, watch.look_ahead_m, watch.insertion_range_m, watch.watched_width_m];
        let fastest_m_s = robot.max_speed_m_s.min(params.linear_speeds_m_s[2]);
        let farthest_m = looks_m.into_iter().fold(braking.distance_m(fastest_m_s), f64::max);
        StopAndReplan {
            watch,
            sound: params.sound(robot).map(SoundWatch::new),
            touched: Vec::new(),
            meeting: params.meeting(robot).map(Meeting::new),
            lane: params.lane(robot),
            control: TurnThenGo::new(params.tuning(robot, 1.0 / rate_hz)),
            sightings: Sightings::new(farthest_m + Self::MARGIN_M),
            progress: Progress::new(Span::from_secs(params.stuck_after_s)),
            merge_within_cells: params.merge_within_cells,
            braking: (!params.thesis_mode).then_some(braking),
            listening: Listening::new(Span::from_secs(params.stale_after_s)),
            following: None,
            is_blocked: false,
        }
    }

    /// Takes in what range sensors and bumpers noticed since the last call.
    fn look(&mut self, input: &AvoidInput<'_>, scene: &Scene<'_>) {
        let since_then = |stamp: Time| {
            let age_s = (scene.now - stamp).as_secs().clamp(0.0, Self::OLDEST_S);
            input.twist.integrate(-age_s)
        };
        self.touched.clear();
        // In the order in which it was seen: a robot that waited for a path has seconds to catch up with, and what a scan
        // of that time explains, one of now may not.
        for observation in input.seen.iter() {
            let then = since_then(observation.stamp);
            let map_from_base_then = scene.map_from_base * then;
            let odom_from_base_then = scene.odom_from_base * then;
            if let Some(meeting) = &mut self.meeting {
                let map_from_odom = scene.map_from_base * scene.odom_from_base.inverse();
                meeting.people.see(
                    observation,
                    &odom_from_base_then,
                    &map_from_odom,
                    input.map.grid.as_ref(),
                );
            }
            let walkers = self.meeting.as_ref().map_or(&[][..], |meeting| meeting.people.walkers());
            self.sightings.see(observation, &odom_from_base_then, walkers);
            add_touched(observation, &map_from_base_then, input.obstacles, &mut self.touched);
            if let Some(sound) = &mut self.sound {
                let known = self.meeting.as_ref().map_or(&[][..], |meeting| meeting.people.known());
                sound.listen(observation, map_from_base_then, &self.sightings, scene, known);
            }
        }
    }

    /// Follows the path of the input; false where there is nothing to follow.
    fn follows_a_path(&mut self, now: Time, input: &AvoidInput<'_>) -> bool {
        let Some(path) = input.path else {
            self.following = None;
            return false;
        };
        if self.following != Some(input.path_number) {
            self.following = Some(input.path_number);
            self.is_blocked = false;
            let cell_m = input.grid.map_or(Self::USUAL_CELL_M, Grid::resolution_m);
            let merge_within_m = self.merge_within_cells * cell_m;
            self.control.follow(now, path, &input.map_from_base, merge_within_m);
        }
        !self.is_blocked
    }

    fn turn(&mut self, now: Time, rate: f64, scene: &Scene<'_>) -> Steering {
        let twist = Twist::new(0.0, rate);
        if self.progress.is_stuck(now, twist, &scene.odom_from_base) {
            return self.block(scene, self.watch.stop_distance_m);
        }
        Steering::Drive(twist)
    }

    fn ahead(
        &mut self,
        now: Time,
        twist: Twist,
        left_m: f64,
        input: &AvoidInput<'_>,
        scene: &Scene<'_>,
    ) -> Result<Steering, AvoidError> {
        if !self.listening.has_fresh_readings(now, &self.sightings)? {
            self.progress.rest();
            return Ok(Steering::Drive(Twist::ZERO));
        }
        let meeting = self.meeting.as_mut();
        let advice = meeting.map_or(Advice::GoOn, |meeting| meeting.advise(twist, &self.control, scene));
        let twist = match advice {
            Advice::GoOn => twist,
            Advice::Drive(slower) if slower.forward_m_s > 0.0 => slower,
            Advice::Drive(instead) => {
                self.progress.rest();
                return Ok(Steering::Drive(instead));
            }
            Advice::AnotherPath => return Ok(self.block_for_people(scene)),
        };
        // What is beyond the checkpoint, where the robot stops anyway, needs no brakes.
        let speed_m_s = input.twist.forward_m_s;
        let brakes_m = self.braking.map_or(0.0, |b| b.distance_m(speed_m_s).min(left_m + b.standing_m));
        let stop_distance_m = self.watch.stop_distance_m.max(brakes_m);
        let is_heard = self.sound.as_ref().is_some_and(|sound| {
            sound.meets_unexpected(&self.sightings, scene, self.watch.stop_distance_m, left_m)
        });
        let is_unexpected = is_heard
            || self.watch.meets_unexpected(&self.sightings, scene, stop_distance_m)
            || self.watch.is_way_closed(&self.sightings, scene, left_m);
        let is_held = self.watch.is_too_near(&self.sightings, scene)
            || self.progress.is_stuck(now, twist, &scene.odom_from_base);
        if is_held && !is_unexpected && self.control.turn_away(scene.map_from_base.rotation.angle()) {
            self.progress.rest();
            return Ok(Steering::Drive(Twist::ZERO));
        }
        if is_held || is_unexpected {
            return Ok(self.block(scene, stop_distance_m));
        }
        if self.sound.as_ref().is_some_and(|sound| sound.is_in_doubt(stop_distance_m)) {
            // The next reading tells whether it was an echo at all.
            self.progress.rest();
            return Ok(Steering::Drive(Twist::ZERO));
        }
        Ok(Steering::Drive(twist))
    }

    /// Who has been in the way for long is an obstacle until a sensor sees through it.
    fn block_for_people(&mut self, scene: &Scene<'_>) -> Steering {
        let map_from_odom = scene.map_from_base * scene.odom_from_base.inverse();
        let mut steering = self.block(scene, self.watch.stop_distance_m);
        if let Steering::Blocked { obstacles } = &mut steering {
            obstacles.extend(self.sightings.walkers(&map_from_odom));
        }
        steering
    }

    fn block(&mut self, scene: &Scene<'_>, stop_distance_m: f64) -> Steering {
        self.is_blocked = true;
        self.progress.rest();
        let mut obstacles = self.watch.unexpected(&self.sightings, scene, stop_distance_m);
        if let Some(sound) = &self.sound {
            obstacles.extend(sound.obstacles(&self.sightings, scene));
        }
        obstacles.append(&mut self.touched);
        Steering::Blocked { obstacles }
    }
}

impl Avoider for StopAndReplan {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        if !is_finite2(&input.map_from_base) {
            let found = format!("{}", input.map_from_base);
            let (message, field, expected) = ("avoid_input", "map_from_base", "finite numbers");
            return Err(MessageFault { message, field, found, expected }.into());
        }
        input.twist.check()?;
        self.listening.note(cx.now);
        let map_from_odom = flatten(&input.estimate.map_from_odom);
        let scene = Scene {
            now: cx.now,
            odom_from_base: map_from_odom.inverse() * input.map_from_base,
            map_from_base: input.map_from_base,
            grid: input.grid,
        };
        self.look(input, &scene);
        if !self.follows_a_path(cx.now, input) {
            self.progress.rest();
            return Ok(Steering::Drive(Twist::ZERO));
        }
        let is_touched = !self.touched.is_empty();
        if self.meeting.as_mut().is_some_and(|m| m.is_touched_by_somebody(cx.now, input.twist, is_touched)) {
            self.progress.rest();
            return Ok(Steering::Drive(Twist::ZERO));
        }
        if is_touched {
            return Ok(self.block(&scene, self.watch.stop_distance_m));
        }
        if let Some(left_m) = self.control.left_m() {
            self.control.give_way(Lane::between(&self.sightings, &scene, &self.lane, left_m));
        }
        match self.control.steer(cx.now, &input.map_from_base, input.twist, input.arrival_radius_m) {
            Motion::Stand => {
                self.progress.rest();
                Ok(Steering::Drive(Twist::ZERO))
            }
            Motion::Turn(rate) => Ok(self.turn(cx.now, rate, &scene)),
            Motion::Ahead { twist, left_m } => self.ahead(cx.now, twist, left_m, input, &scene),
            Motion::Arrived => Ok(Steering::Arrived),
        }
    }
}

impl Params for StopAndReplanParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Avoider> for StopAndReplanParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::LaserScan, ObservationKind::RangeRing]],
            drives: vec![DriveKind::Differential, DriveKind::Omnidirectional],
            default_rate_hz: Some(StopAndReplan::DEFAULT_RATE_HZ),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        let rate_hz = context.rate_hz.filter(|rate| *rate > 0.0).unwrap_or(StopAndReplan::DEFAULT_RATE_HZ);
        Ok(Box::new(StopAndReplan::new(self, &context.robot, rate_hz)))
    }
}

rumbo_core::register_avoider!(
    StopAndReplanParams,
    "stop_and_replan",
    "turns in place, drives straight, stops in front of obstacles and asks for a new path"
);
