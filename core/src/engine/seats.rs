//! Which stage sits where: from the sections of a pipeline to the seats of an engine.

use super::at_work::AtWork;
use super::build::{Builder, EngineError};
use super::localization::{Finder, Localization};
use super::planning::{PlannerSeat, Planning};
use super::ring::Ring;
use super::schedule::{Schedule, TaskId};
use super::seat::Seat;
use super::sense::SensorSeat;
use crate::frames::Pose2;
use crate::map::Map;
use crate::messages::{Estimate, Prior, SensorId};
use crate::pipeline::{Pipeline, Rate, StageSpec};
use crate::stages::{BuildError, Localizer};
use crate::time::Time;
use std::sync::Arc;

/// Rate of a sensor when neither the pipeline nor its plugin says.
const SENSOR: Rate = Rate::Hz(10.0);

pub(super) fn sensors(
    builder: &Builder<'_>,
    schedule: &mut Schedule,
) -> Result<Vec<SensorSeat>, EngineError> {
    let mut seats = Vec::new();
    for (idx, spec) in builder.pipeline.sensors.iter().enumerate() {
        let id = SensorId(idx as u16);
        let manifest = spec.stage.manifest();
        let default = manifest.default_rate_hz.map_or(SENSOR, Rate::Hz);
        // A virtual sensor without a rate runs whenever its inputs have something new.
        let rate = spec.stage.rate.or((!manifest.is_virtual).then_some(default));
        seats.push(SensorSeat {
            seat: Seat {
                name: spec.stage.name.clone(),
                stage: builder.mounted(&spec.stage, id, spec.base_from_sensor)?,
                cursor: Default::default(),
                task: task(rate, schedule),
                failures: 0,
                last_error: String::new(),
            },
            inputs: spec.inputs.iter().map(|idx| SensorId(*idx as u16)).collect(),
        });
    }
    Ok(seats)
}

pub(super) fn odometer(
    builder: &Builder<'_>,
    schedule: &mut Schedule,
    ring: &Ring,
) -> Result<Option<Seat<Box<dyn Localizer>>>, EngineError> {
    let Some(spec) = &builder.pipeline.odometer else { return Ok(None) };
    let mut built: Box<dyn Localizer> = builder.stage(spec)?;
    // The odometer's frame begins where the base stands.
    let prior = Prior::Pose {
        map_from_base: Pose2::identity(),
        odom_from_base: Pose2::identity(),
        covariance: nalgebra::Matrix3::zeros(),
    };
    let started = built.start(&prior, &Map::default()).map_err(|e| BuildError::at("", e.to_string()));
    started.map_err(|error| EngineError { section: spec.name.clone(), error })?;
    Ok(Some(seat(built, spec, task(spec.rate, schedule), ring)))
}

pub(super) fn localization(
    builder: &Builder<'_>,
    schedule: &mut Schedule,
    ring: &Ring,
) -> Result<Localization, EngineError> {
    let pipeline = builder.pipeline;
    let finder = match (&pipeline.slam, &pipeline.localizer) {
        (Some(spec), _) => {
            let slam = Finder::Slam { slam: builder.stage(spec)?, has_begun: false };
            seat(slam, spec, task(spec.rate, schedule), ring)
        }
        (None, Some(spec)) => {
            seat(Finder::Localizer(builder.stage(spec)?), spec, task(spec.rate, schedule), ring)
        }
        (None, None) => {
            let error = BuildError::at("", "nobody finds the robot; name a plugin in [localizer] or [slam]");
            return Err(EngineError { section: "localizer".into(), error });
        }
    };
    let relocalizer = match &pipeline.relocalizer {
        Some(spec) => Some(seat(builder.stage(spec)?, spec, task(spec.rate, schedule), ring)),
        None => None,
    };
    Ok(Localization { finder, relocalizer, estimate: Estimate::lost(Time::ZERO) })
}

pub(super) fn planning(builder: &Builder<'_>, at_work: Arc<AtWork>) -> Result<Planning, EngineError> {
    let seat = |spec: Option<&StageSpec>| -> Result<Option<PlannerSeat>, EngineError> {
        let planner = builder.optional(spec)?;
        Ok(spec.map(|spec| PlannerSeat { planner, background: builder.background(spec) }))
    };
    let pipeline = builder.pipeline;
    let (main, fallback) = (seat(pipeline.planner.as_ref())?, seat(pipeline.planner_fallback.as_ref())?);
    Ok(Planning::new(main, fallback, pipeline.robot.clone(), at_work))
}

pub(super) fn seat<T>(stage: T, spec: &StageSpec, task: Option<TaskId>, ring: &Ring) -> Seat<T> {
    Seat {
        name: spec.name.clone(),
        stage,
        cursor: ring.cursor(),
        task,
        failures: 0,
        last_error: String::new(),
    }
}

pub(super) fn task(rate: Option<Rate>, schedule: &mut Schedule) -> Option<TaskId> {
    rate.map(|rate| schedule.add(rate))
}

/// Sources whose age the guard watches: all that see obstacles, and the one that says how the robot moves.
pub(super) fn watched(pipeline: &Pipeline) -> Vec<SensorId> {
    let sensors = pipeline.sensors.iter().enumerate();
    let has_odometer = pipeline.odometer.is_some();
    let replaced = pipeline.replaced();
    let watched = sensors.filter(|(idx, spec)| {
        let mut manifest = spec.stage.manifest();
        manifest.produces.retain(|kind| !replaced.contains(&(SensorId(*idx as u16), *kind)));
        manifest.is_watched(has_odometer)
    });
    let odometer = pipeline.odometer.as_ref().map(|_| SensorId::ODOMETER);
    watched.map(|(idx, _)| SensorId(idx as u16)).chain(odometer).collect()
}
