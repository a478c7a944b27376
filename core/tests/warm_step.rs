//! After warm-up, a control step allocates nothing in core.
//!
//! Its own test program, since the counting allocator counts for the whole process.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, unsafe_code, dead_code)]

#[path = "engine/doubles.rs"]
mod doubles;

use rumbo_core::engine::{Engine, Metrics, Observer, Stepped};
use rumbo_core::frames::Pose3;
use rumbo_core::pipeline::{Mission, Pipeline, Rate, SensorSpec, StageSpec, Waypoint};
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::robot::Robot;
use rumbo_core::time::Span;
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

struct Counting;
static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: passes every call on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn stage(stage: Stage, name: &str, plugin: &str, rate: Option<Rate>) -> StageSpec {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(stage, plugin).unwrap().clone();
    let configured = entry.source.parse(toml::Table::new()).ok().unwrap().into();
    StageSpec { name: name.into(), entry, configured, rate, latency: Span::ZERO }
}

fn sensor(name: &str, rate_hz: f64) -> SensorSpec {
    let stage = stage(Stage::Sensor, name, name, Some(Rate::Hz(rate_hz)));
    SensorSpec { stage, base_from_sensor: Pose3::identity(), inputs: Vec::new() }
}

#[test]
fn a_warm_control_step_allocates_nothing() {
    let pipeline = Pipeline {
        name: "warm".into(),
        seed: 1,
        folder: PathBuf::from("."),
        robot: Arc::new(Robot::default()),
        world: stage(Stage::World, "world", "floor", None),
        duration_s: None,
        sensors: vec![sensor("wheels", 20.0), sensor("scanner", 37.5)],
        odometer: None,
        map_builders: vec![stage(Stage::MapBuilder, "map_builder", "blank", None)],
        localizer: Some(stage(Stage::Localizer, "quiet", "reckoning", None)),
        relocalizer: None,
        slam: None,
        resume: None,
        planner: Some(stage(Stage::Planner, "planner", "line", None)),
        planner_fallback: None,
        avoider: Some(stage(Stage::Avoider, "avoider", "beeline", None)),
        mission: Mission {
            waypoints: vec![Waypoint { x_m: 90.0, y_m: 0.5, yaw_deg: None }],
            ..Mission::default()
        },
        tests: Vec::new(),
    };
    let mut engine = Engine::build(&pipeline).unwrap();
    let mut metrics = Metrics::new();
    let mut steps = |n: usize| {
        for _ in 0..n {
            assert_eq!(engine.step(), Stepped::Went);
            metrics.on_step(&engine.view());
        }
    };
    steps(2000);
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    steps(2000);
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
}
