//! From a pipeline to an engine.

use super::at_work::AtWork;
use super::following::Following;
use super::guard::Guard;
use super::navigator::Navigator;
use super::ring::Ring;
use super::schedule::Schedule;
use super::scripted::ScriptedDrive;
use super::seats::{localization, odometer, planning, seat, sensors, task, watched};
use super::slam::resume;
use super::stall::StallMonitor;
use super::step::Engine;
use super::wish::WishMotion;
use crate::frames::Pose3;
use crate::map::Map;
use crate::messages::{Command, Observations, SensorId};
use crate::odometry_track::OdometryTrack;
use crate::pipeline::{Pipeline, Rate, StageSpec};
use crate::registry::Built;
use crate::stages::{Background, BuildContext, BuildError, GiveUp, World};
use crate::time::Span;
use crate::trace::Trace;
use std::path::PathBuf;
use std::sync::Arc;

/// Why an engine cannot be built: which section, and what its plugin says.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{section}: {error}")]
pub struct EngineError {
    /// Name of the section or sensor.
    pub section: String,
    /// What its plugin says.
    pub error: BuildError,
}

/// Observations that the ring holds at most: ten seconds of a robot with many fast sensors.
const RING: usize = 4096;
/// Control rate when the pipeline does not say.
const CONTROL: Rate = Rate::Hz(10.0);

/// Builds stages one after the other.
pub(super) struct Builder<'p> {
    pub(super) pipeline: &'p Pipeline,
    pub(super) world_map: Option<PathBuf>,
    pub(super) world_recording: Option<PathBuf>,
    pub(super) real_time: bool,
    pub(super) dry_run: bool,
    pub(super) abort: GiveUp,
}

impl<'p> Builder<'p> {
    /// Before the world is built.
    pub(super) fn new(pipeline: &'p Pipeline, dry_run: bool) -> Builder<'p> {
        let (world_map, world_recording) = (None, None);
        Builder { pipeline, world_map, world_recording, real_time: false, dry_run, abort: GiveUp::default() }
    }

    /// Keeps what the other stages may know of the world.
    pub(super) fn learn(&mut self, world: &dyn World) {
        self.world_map = world.map_file().map(PathBuf::from);
        self.world_recording = world.recording_file().map(PathBuf::from);
        self.real_time = world.is_real_time();
    }

    fn context(&self, spec: &StageSpec, sensor: SensorId, base_from_sensor: Pose3) -> BuildContext {
        BuildContext {
            name: spec.name.clone(),
            sensor,
            robot: self.pipeline.robot.clone(),
            base_from_sensor,
            rate_hz: spec.rate.map(|rate| 1.0 / rate.period().as_secs()),
            seed: self.pipeline.seed,
            folder: self.pipeline.folder.clone(),
            world_map: self.world_map.clone(),
            world_recording: self.world_recording.clone(),
            wanted_layers: self.pipeline.wanted_layers(),
            dry_run: self.dry_run,
            background: self.background(spec),
        }
    }

    pub(super) fn background(&self, spec: &StageSpec) -> Background {
        let place = if self.real_time { Background::threaded() } else { Background::inline(spec.latency) };
        place.under(&self.abort)
    }

    pub(super) fn stage<T: TryFrom<Built, Error = BuildError>>(
        &self,
        spec: &StageSpec,
    ) -> Result<T, EngineError> {
        self.mounted(spec, SensorId(0), Pose3::identity())
    }

    pub(super) fn mounted<T: TryFrom<Built, Error = BuildError>>(
        &self,
        spec: &StageSpec,
        sensor: SensorId,
        base_from_sensor: Pose3,
    ) -> Result<T, EngineError> {
        let context = self.context(spec, sensor, base_from_sensor);
        let built = spec.configured.build(&context).and_then(T::try_from);
        built.map_err(|error| EngineError { section: spec.name.clone(), error })
    }

    pub(super) fn optional<T: TryFrom<Built, Error = BuildError>>(
        &self,
        spec: Option<&StageSpec>,
    ) -> Result<Option<T>, EngineError> {
        spec.map(|spec| self.stage(spec)).transpose()
    }
}

impl Engine {
    /// Builds every stage of the pipeline and starts the map builders.
    pub fn build(pipeline: &Pipeline) -> Result<Engine, EngineError> {
        Engine::build_as(pipeline, false)
    }

    /// As [`build`](Self::build), but touches no device: what a check does.
    pub fn build_dry(pipeline: &Pipeline) -> Result<Engine, EngineError> {
        Engine::build_as(pipeline, true)
    }

    /// As [`build`](Self::build), in a world of the caller's instead of the pipeline's: a replay, a test.
    pub fn build_in(pipeline: &Pipeline, world: Box<dyn World>) -> Result<Engine, EngineError> {
        let mut builder = Builder::new(pipeline, false);
        builder.learn(world.as_ref());
        Engine::with_world(&builder, world)
    }

    fn build_as(pipeline: &Pipeline, dry_run: bool) -> Result<Engine, EngineError> {
        let mut builder = Builder::new(pipeline, dry_run);
        let world: Box<dyn World> = builder.stage(&pipeline.world)?;
        builder.learn(world.as_ref());
        Engine::with_world(&builder, world)
    }

    fn with_world(builder: &Builder<'_>, world: Box<dyn World>) -> Result<Engine, EngineError> {
        let pipeline = builder.pipeline;
        let script = ScriptedDrive::of(pipeline)?;
        let mut schedule = Schedule::from(world.now());
        let ring = Ring::new(RING, pipeline.odometer.is_some()).replacing(pipeline.replaced());
        let sensors = sensors(builder, &mut schedule)?;
        let odometer = odometer(builder, &mut schedule, &ring)?;
        let mut localization = localization(builder, &mut schedule, &ring)?;
        let mut map = Map::default();
        let left_at = resume(pipeline, &mut localization.finder.stage, &mut map)?;
        let mut builders = Vec::new();
        for spec in &pipeline.map_builders {
            let mut built: Box<dyn crate::stages::MapBuilder> = builder.stage(spec)?;
            let error = |e: crate::stages::MapError| BuildError::at("", e.to_string());
            built.start(&mut map).map_err(|e| EngineError { section: spec.name.clone(), error: error(e) })?;
            map.touch();
            builders.push(seat(built, spec, task(spec.rate, &mut schedule), &ring));
        }
        let beginning = Engine::first_orders(pipeline, world.as_ref(), left_at);
        let at_work = Arc::new(AtWork::of(pipeline));
        let mut planning = planning(builder, at_work.clone())?;
        planning.task = pipeline.planner.as_ref().and_then(|spec| task(spec.rate, &mut schedule));
        let control = pipeline.avoider.as_ref().and_then(|spec| spec.rate).unwrap_or(CONTROL);
        let control_period = control.period();
        let control = schedule.add(control);
        let avoider = match &pipeline.avoider {
            Some(spec) => Some(seat(builder.stage(spec)?, spec, None, &ring)),
            None => None,
        };
        Ok(Engine {
            guard: Guard::new(pipeline.robot.clone(), control_period, &watched(pipeline)),
            navigator: Navigator::new(&pipeline.mission),
            following: Following::of(pipeline),
            stall: StallMonitor::of(&pipeline.mission, &pipeline.robot),
            orders: beginning.clone(),
            beginning,
            pending: Engine::mission_goals(pipeline),
            inbox: Default::default(),
            given: Vec::new(),
            obeyed: Vec::new(),
            robot: pipeline.robot.clone(),
            estimate_is_new: false,
            wish: WishMotion::default(),
            track: OdometryTrack::new(),
            footprint_from_base: pipeline.odometer.as_ref().map(|_| Pose3::identity()),
            derived: pipeline.sensors.iter().map(|sensor| !sensor.inputs.is_empty()).collect(),
            out: Observations::default(),
            command: Command::default(),
            events: Vec::with_capacity(64),
            trace: Trace::unwatched(),
            times: Default::default(),
            step: 0,
            n_new: 0,
            wanders: !pipeline.mission.has_goals() && script.is_none(),
            needed_layers: if pipeline.slam.is_some() { Vec::new() } else { pipeline.wanted_layers() },
            duration: pipeline.duration_s.map(Span::from_secs),
            has_mission: !pipeline.mission.waypoints.is_empty() || script.is_some(),
            script,
            status: crate::messages::Status::Lost,
            not_actuated: false,
            now: world.now(),
            started: world.now(),
            recorded: false,
            stage_drawings: Vec::new(),
            counters: Vec::new(),
            late: Span::ZERO,
            control_period,
            abort: builder.abort.clone(),
            at_work,
            limits: Default::default(),
            localization,
            planning,
            avoider,
            builders,
            odometer,
            sensors,
            map,
            ring,
            schedule,
            control,
            world,
        })
    }
}
