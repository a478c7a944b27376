//! One run of a pipeline, watched.

use crate::outcome::Outcome;
use crate::record::{Recorder, RunRecord, way};
use rumbo_core::engine::{Engine, EngineError, Metrics, Observer, RunEnd};
use rumbo_core::map::Map;
use rumbo_core::pipeline::Pipeline;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// What a run leaves.
#[derive(Debug)]
pub struct Driven {
    /// For reports and pictures.
    pub record: RunRecord,
    /// The map as it is known at the end of the run.
    pub map: Map,
    /// How it ended.
    pub end: RunEnd,
}

/// Drives the pipeline to its end. `others` watch too; `file` and `config` go into the record.
pub fn drive(
    pipeline: &Pipeline,
    file: &str,
    config: &str,
    others: &mut [&mut dyn Observer],
    interrupt: &AtomicBool,
) -> Result<RunRecord, EngineError> {
    drive_and_keep(pipeline, file, config, others, interrupt).map(|driven| driven.record)
}

/// As [`drive`], and keeps the map.
pub fn drive_and_keep(
    pipeline: &Pipeline,
    file: &str,
    config: &str,
    others: &mut [&mut dyn Observer],
    interrupt: &AtomicBool,
) -> Result<Driven, EngineError> {
    let mut engine = Engine::build(pipeline)?;
    Ok(drive_engine(&mut engine, pipeline, file, config, Recorder::default(), others, interrupt))
}

/// As [`drive_and_keep`], with an engine that is built already, written down by this recorder.
pub fn drive_engine(
    engine: &mut Engine,
    pipeline: &Pipeline,
    file: &str,
    config: &str,
    mut recorder: Recorder,
    others: &mut [&mut dyn Observer],
    interrupt: &AtomicBool,
) -> Driven {
    let mut metrics = Metrics::new();
    engine.watch_plans();
    let clock = Instant::now();
    let end = {
        let mut observers: Vec<&mut dyn Observer> = vec![&mut metrics, &mut recorder];
        observers.extend(others.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
        engine.run(&mut observers, interrupt)
    };
    let wall = clock.elapsed();
    // A map that does not lie where the known way does would mislead; where [slam] cannot say, there is the run's own.
    let map = engine.slam_map().unwrap_or_else(|_| engine.view().map.clone());
    let outcome = Outcome::new(pipeline, &metrics, &end, &map, wall);
    let mut record = recorder.finish(pipeline, file, &map, config.to_owned());
    record.outcome = Some(outcome);
    // Without [slam], and where it cannot say (which --trajectory tells), what was thought at the time is all there is.
    record.known_way = engine.trajectory().map(|poses| way(&poses)).unwrap_or_default();
    Driven { record, map, end }
}

/// Drives the pipeline to its end and keeps nothing but the figures.
pub fn drive_for_figures(pipeline: &Pipeline, interrupt: &AtomicBool) -> Result<Outcome, EngineError> {
    let mut engine = Engine::build(pipeline)?;
    engine.count();
    engine.keep_no_trajectory();
    let mut metrics = Metrics::new();
    let clock = Instant::now();
    let end = engine.run(&mut [&mut metrics], interrupt);
    let wall = clock.elapsed();
    Ok(Outcome::new(pipeline, &metrics, &end, engine.view().map, wall))
}
