//! Everything that the plugins of a pipeline have against being built.

use super::build::{Builder, EngineError};
use super::scripted::ScriptedDrive;
use super::step::Engine;
use crate::frames::Pose3;
use crate::map::Map;
use crate::messages::SensorId;
use crate::pipeline::{Pipeline, StageSpec};
use crate::registry::Built;
use crate::stages::{BuildError, MapBuilder, World};

impl Engine {
    /// Builds the engine without touching a device; where that fails, builds every stage for itself, so that all
    /// faults are known at once. Stages for which `is_sound` says no are left out: their faults are known already.
    pub fn build_faults(
        pipeline: &Pipeline,
        is_sound: impl Fn(&str) -> bool,
    ) -> (Vec<EngineError>, Option<Engine>) {
        let all_sound =
            is_sound(&pipeline.world.name) && pipeline.stages().all(|stage| is_sound(&stage.name));
        let first = match all_sound.then(|| Engine::build_dry(pipeline)) {
            Some(Ok(engine)) => return (Vec::new(), Some(engine)),
            Some(Err(error)) => Some(error),
            None => None,
        };
        let mut errors = Vec::new();
        let builder = Builder::new(pipeline, true);
        one_by_one(builder, &is_sound, &mut errors);
        if let Some(first) = first.filter(|first| !errors.contains(first)) {
            errors.push(first);
        }
        (errors, None)
    }
}

fn one_by_one(mut builder: Builder<'_>, is_sound: &impl Fn(&str) -> bool, errors: &mut Vec<EngineError>) {
    let pipeline = builder.pipeline;
    errors.extend(ScriptedDrive::of(pipeline).err());
    let mut has_world = false;
    if is_sound(&pipeline.world.name) {
        match builder.stage::<Box<dyn World>>(&pipeline.world) {
            Ok(world) => {
                has_world = true;
                builder.learn(world.as_ref());
            }
            Err(error) => errors.push(error),
        }
    }
    for (idx, sensor) in pipeline.sensors.iter().enumerate() {
        let id = SensorId(idx as u16);
        try_build(&builder, &sensor.stage, id, sensor.base_from_sensor, is_sound, errors);
    }
    let here = |builder: &Builder<'_>, spec: &StageSpec, errors: &mut Vec<EngineError>| {
        try_build(builder, spec, SensorId(0), Pose3::identity(), is_sound, errors);
    };
    let finders = [&pipeline.odometer, &pipeline.localizer, &pipeline.relocalizer, &pipeline.slam];
    // Without their world they would look for its map and its recording in vain.
    if has_world {
        finders.into_iter().flatten().for_each(|spec| here(&builder, spec, errors));
        map_builders(&builder, is_sound, errors);
    }
    let movers = [&pipeline.planner, &pipeline.planner_fallback, &pipeline.avoider];
    movers.into_iter().flatten().for_each(|spec| here(&builder, spec, errors));
}

/// A stage of whatever kind: only whether it can be built matters.
struct AnyStage;

impl TryFrom<Built> for AnyStage {
    type Error = BuildError;

    fn try_from(_: Built) -> Result<AnyStage, BuildError> {
        Ok(AnyStage)
    }
}

fn try_build(
    builder: &Builder<'_>,
    spec: &StageSpec,
    id: SensorId,
    base_from_sensor: Pose3,
    is_sound: &impl Fn(&str) -> bool,
    errors: &mut Vec<EngineError>,
) {
    if is_sound(&spec.name) {
        errors.extend(builder.mounted::<AnyStage>(spec, id, base_from_sensor).err());
    }
}

fn map_builders(builder: &Builder<'_>, is_sound: &impl Fn(&str) -> bool, errors: &mut Vec<EngineError>) {
    let mut map = Map::default();
    for spec in builder.pipeline.map_builders.iter().filter(|spec| is_sound(&spec.name)) {
        let started = builder.stage::<Box<dyn MapBuilder>>(spec).and_then(|mut built| {
            built.start(&mut map).map_err(|error| EngineError {
                section: spec.name.clone(),
                error: BuildError::at("", error.to_string()),
            })
        });
        errors.extend(started.err());
    }
}
