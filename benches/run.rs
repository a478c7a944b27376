//! The main job: the office crossing from the built engine to the goal, with and without what the report needs.

use rumbo::drive::drive;
use rumbo_core::engine::Engine;
use rumbo_core::pipeline::{Loaded, Pipeline};
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
