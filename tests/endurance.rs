//! A robot on patrol needs no more memory in its third lap than in its first. The long form of this, half an hour with bounds
//! on time, is `cargo bench --bench endurance`.
//!
//! Its own test program, since the counting allocator counts for the whole process.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use rumbo_core::engine::{Engine, Metrics, Observer as _, Stepped};
use rumbo_core::pipeline::{Loaded, Pipeline};
use rumbo_core::time::Span;
use std::path::Path;

/// A lap takes this long, seconds.
const LAP_S: f64 = 56.0;
/// Half an hour may add 1 % to some 18 MB, so two laps 11 kB; a list with a pose for each scan would grow by 160 kB.
const MOST_GROWTH_BYTES: i64 = 4096;
/// Nothing as large as a map is copied meanwhile, also not for a moment.
const MOST_FOR_A_MOMENT_BYTES: u64 = 200_000;

/// The pipeline with its way driven four times.
fn patrol() -> Pipeline {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/finder_endurance.toml");
    let loaded = Loaded::read(&file, &[], &rumbo::registry().ok().unwrap());
    let mut pipeline = loaded.sound().map(|_| loaded.pipeline.clone().unwrap()).unwrap();
    pipeline.mission.waypoints = pipeline.mission.waypoints.repeat(4);
    pipeline
}

#[test]
fn laps_that_show_nothing_new_need_no_more_memory() {
    let mut engine = Engine::build(&patrol()).unwrap();
    engine.keep_no_trajectory();
    let mut metrics = Metrics::new();
    let started = engine.view().started;
    let mut laps = |n: u32| {
        while engine.view().now - started < Span::from_secs(LAP_S * f64::from(n)) {
            assert_eq!(engine.step(), Stepped::Went);
            let view = engine.view();
            metrics.on_step(&view);
            let (place, yaw) = (view.map_from_base.translation, view.map_from_base.rotation.angle());
            assert!([place.x, place.y, yaw].iter().all(|v| v.is_finite()), "{:?}", view.map_from_base);
        }
    };
    laps(1);
    // A list that doubles its room when it is full does so at least once while it becomes three times as long.
    let more = allocation_counter::measure(|| laps(3));
    assert!(more.bytes_current <= MOST_GROWTH_BYTES, "{more:?}");
    assert!(more.bytes_max <= MOST_FOR_A_MOMENT_BYTES, "{more:?}");
    assert!(metrics.summary(rumbo_core::engine::EndReason::Finished, None).p95_error_m.unwrap() < 0.15);
}
