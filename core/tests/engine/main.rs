//! The engine, driven by stages that are as simple as can be.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod automaton;
mod doubles;
mod following;
mod missions;
mod seats;
mod slam;
mod stalls;

use rumbo_core::engine::{EndReason, Engine, Event, EventKind, Metrics, Observer, RunEnd, StepView, Summary};
use rumbo_core::frames::Pose3;
use rumbo_core::pipeline::{InitialPose, Mission, Pipeline, Rate, SensorSpec, StageSpec, Waypoint};
use rumbo_core::registry::{Registry, Stage};
use rumbo_core::robot::Robot;
use rumbo_core::time::Span;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub fn stage(stage: Stage, name: &str, plugin: &str, rate: Option<Rate>, keys: &str) -> StageSpec {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(stage, plugin).unwrap().clone();
    let configured = entry.source.parse(toml::from_str(keys).unwrap()).ok().unwrap().into();
    StageSpec { name: name.into(), entry, configured, rate, latency: Span::ZERO }
}

pub fn sensor(name: &str, plugin: &str, rate_hz: f64, keys: &str) -> SensorSpec {
    let stage = stage(Stage::Sensor, name, plugin, Some(Rate::Hz(rate_hz)), keys);
    SensorSpec { stage, base_from_sensor: Pose3::identity(), inputs: Vec::new() }
}

pub fn go_to(x_m: f64, y_m: f64) -> Mission {
    Mission { waypoints: vec![Waypoint { x_m, y_m, yaw_deg: None }], ..Mission::default() }
}

/// Wheels, scanner, dead reckoning, straight plans, a beeline to (3, 1).
pub fn pipeline(name: &str) -> Pipeline {
    Pipeline {
        name: name.into(),
        seed: 1,
        folder: PathBuf::from("."),
        robot: Arc::new(Robot::default()),
        world: stage(Stage::World, "world", "floor", None, ""),
        duration_s: None,
        sensors: vec![sensor("wheels", "wheels", 20.0, ""), sensor("scanner", "scanner", 10.0, "")],
        odometer: None,
        map_builders: vec![stage(Stage::MapBuilder, "map_builder", "blank", None, "")],
        localizer: Some(stage(Stage::Localizer, &format!("{name} localizer"), "reckoning", None, "")),
        relocalizer: None,
        slam: None,
        planner: Some(stage(Stage::Planner, &format!("{name} planner"), "line", None, "")),
        planner_fallback: None,
        avoider: Some(stage(Stage::Avoider, "avoider", "beeline", None, "")),
        mission: go_to(3.0, 1.0),
        tests: Vec::new(),
    }
}

/// Keeps every event.
#[derive(Default)]
pub struct Events(pub Vec<Event>);
impl Observer for Events {
    fn on_step(&mut self, view: &StepView<'_>) {
        self.0.extend(view.events.iter().cloned());
    }
}
impl Events {
    pub fn count(&self, wanted: impl Fn(&EventKind) -> bool) -> usize {
        self.0.iter().filter(|event| wanted(&event.kind)).count()
    }
}

pub fn run(pipeline: &Pipeline) -> (RunEnd, Summary, Events) {
    let mut engine = Engine::build(pipeline).unwrap();
    let (mut metrics, mut events) = (Metrics::new(), Events::default());
    let end = engine.run(&mut [&mut metrics, &mut events], &AtomicBool::new(false));
    let summary = metrics.summary(end.reason, end.detail.clone());
    (end, summary, events)
}

#[test]
fn a_robot_drives_to_its_goal_and_its_figures_are_right() {
    let (end, summary, events) = run(&pipeline("simple"));
    assert_eq!(end.reason, EndReason::Arrived, "{:?}", events.0);
    assert!(summary.goal_error_m.unwrap() <= 0.1);
    assert!((summary.path_m - 10f64.sqrt()).abs() < 0.15, "{}", summary.path_m);
    assert!(summary.final_error_m.unwrap() < 1e-6 && summary.rms_error_m.unwrap() < 1e-6);
    assert!(summary.rms_heading_error_deg.unwrap() < 1e-6);
    assert!((summary.turn_deg_m.unwrap() * summary.path_m - 18.4).abs() < 1.5, "{:?}", summary.turn_deg_m);
    assert_eq!((summary.replans, summary.guard_interventions, summary.contacts), (0, 0, Some(0)));
}

#[test]
fn a_robot_that_was_told_a_turned_start_keeps_that_error_of_its_heading() {
    let mut turned = pipeline("turned");
    turned.mission.initial_pose = InitialPose::Pose { x_m: 0.0, y_m: 0.0, yaw_deg: -0.5 };
    let (_, summary, _) = run(&turned);
    let (rms_deg, last_deg) =
        (summary.rms_heading_error_deg.unwrap(), summary.final_heading_error_deg.unwrap());
    assert!((rms_deg - 0.5).abs() < 1e-6 && (last_deg - 0.5).abs() < 1e-6, "{rms_deg} {last_deg}");
}

#[test]
fn the_same_pipeline_twice_gives_the_same_bytes() {
    let text = || {
        format!("{:?}", {
            let (end, summary, events) = run(&pipeline("twice"));
            (end, summary, events.0)
        })
    };
    assert_eq!(text(), text());
}
