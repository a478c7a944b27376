//! The main job: the office crossing from the built engine to the goal, with and without what the report needs and
//! what `--record` writes (into memory: the disk is not ours to measure).

use rumbo::drive::drive;
use rumbo::recording::RunRecording;
use rumbo_core::engine::{Engine, RunEnd};
use rumbo_core::pipeline::{Loaded, Pipeline};
use rumbo_kit::recording::{BagWriter, RunHeader};
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn main() {
    divan::main();
}

fn office() -> Option<Pipeline> {
    let registry = rumbo::registry().unwrap_or_default();
    Loaded::read(Path::new("pipelines/office.toml"), &[], &registry).pipeline
}

#[divan::bench(sample_count = 10)]
fn crossing_without_observers(bencher: divan::Bencher<'_, '_>) {
    let Some(pipeline) = office() else { return };
    let never = AtomicBool::new(false);
    bencher.bench(|| Engine::build(&pipeline).map(|mut engine| engine.run(&mut [], &never)));
}

#[divan::bench(sample_count = 10)]
fn crossing_recorded_for_the_report(bencher: divan::Bencher<'_, '_>) {
    let Some(pipeline) = office() else { return };
    let never = AtomicBool::new(false);
    bencher.bench(|| drive(&pipeline, "office.toml", "", &mut [], &never));
}

fn record(pipeline: &Pipeline) -> Option<(RunEnd, usize)> {
    let mut engine = Engine::build(pipeline).ok()?;
    let sensors = pipeline.sensors.iter().map(|sensor| sensor.stage.name.clone()).collect();
    let header = RunHeader { sensors, ..RunHeader::default() };
    let bag = BagWriter::new(Cursor::new(Vec::with_capacity(1 << 25))).ok()?;
    let mut recording = RunRecording::new(bag, &header).ok()?;
    let end = engine.run(&mut [&mut recording], &AtomicBool::new(false));
    let bytes = recording.finish(&end, &engine.view()).ok()?;
    Some((end, bytes.into_inner().len()))
}

#[divan::bench(sample_count = 10)]
fn crossing_recorded_for_a_replay(bencher: divan::Bencher<'_, '_>) {
    let Some(pipeline) = office() else { return };
    bencher.bench(|| record(&pipeline));
}
