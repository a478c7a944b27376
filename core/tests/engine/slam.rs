//! A SLAM keeps its map whatever it is told, and is asked whatever it says.

use crate::{Events, doubles, pipeline, stage};
use nalgebra::Matrix3;
use rumbo_core::engine::{AskError, Engine, EventKind, Order, State, Stepped};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::Map;
use rumbo_core::pipeline::{InitialPose, Mission, Pipeline};
use rumbo_core::registry::Stage;

/// Wheels, scanner, a SLAM, and nothing to do.
fn mapping(name: &str, keys: &str) -> Pipeline {
    let mut pipeline = pipeline(name);
    (pipeline.localizer, pipeline.map_builders) = (None, Vec::new());
    (pipeline.planner, pipeline.avoider) = (None, None);
    pipeline.mission = Mission::default();
    pipeline.duration_s = Some(60.0);
    pipeline.slam = Some(stage(Stage::Slam, name, "believer", None, keys));
    pipeline
}

/// What the SLAM of a pipeline was told so far.
fn told(name: &str) -> Vec<String> {
    doubles::logged(&format!("quiet {name}"))
}

fn step_until(engine: &mut Engine, seconds: f64, events: &mut Events) {
    while engine.view().now.as_secs() < seconds {
        assert_eq!(engine.step(), Stepped::Went);
        let view = engine.view();
        events.0.extend(view.events.iter().cloned());
    }
}

/// Updates whose traces are in the map.
fn n_updates(engine: &mut Engine) -> f32 {
    engine.view().map.grid.as_ref().unwrap().cells[0]
}

fn stands(x_m: f64) -> Order {
    Order::SetPose { map_from_base: pose2(x_m, 2.0, 0.0), covariance: Matrix3::identity() * 1e-4 }
}

#[test]
fn a_pose_during_a_run_moves_the_robot_and_leaves_the_map() {
    let mut engine = Engine::build(&mapping("told_slam", "")).unwrap();
    let mut events = Events::default();
    step_until(&mut engine, 2.0, &mut events);
    let before = n_updates(&mut engine);
    assert!(before > 10.0, "{before}");
    engine.command(stands(7.0));
    step_until(&mut engine, 3.0, &mut events);
    assert!(n_updates(&mut engine) > before, "the map began anew");
    let at: Pose2 = engine.view().map_from_base;
    assert!((at.translation.x - 7.0).abs() < 1e-9 && (at.translation.y - 2.0).abs() < 1e-9, "{at}");
    assert_eq!(engine.view().state, State::Waiting);
    assert_eq!(told("told_slam"), ["starts 0.0", "is told 7.0"]);
}

#[test]
fn a_slam_that_cannot_be_told_says_so_and_goes_on() {
    let mut engine = Engine::build(&mapping("deaf_slam", "is_told = false")).unwrap();
    let mut events = Events::default();
    step_until(&mut engine, 2.0, &mut events);
    let (before, at) = (n_updates(&mut engine), engine.view().map_from_base);
    engine.command(stands(7.0));
    engine.command(Order::Localize);
    engine.command(Order::SetMap(Box::new(Map::default())));
    step_until(&mut engine, 3.0, &mut events);
    assert!(n_updates(&mut engine) > before && engine.view().map_from_base == at);
    assert_eq!(engine.view().state, State::Waiting);
    let refused = |kind: &EventKind| matches!(kind, EventKind::StageFailed { error, .. } if error.contains("once it has a map"));
    assert_eq!(events.count(refused), 2, "{:?}", events.0);
    assert_eq!(events.count(|kind| matches!(kind, EventKind::Refused { command: "set_map", .. })), 1);
    assert_eq!(told("deaf_slam"), ["starts 0.0", "is told 7.0", "is told unknown"]);
}

#[test]
fn a_slam_that_is_lost_goes_on_looking_and_is_found_with_its_map() {
    let mut engine = Engine::build(&mapping("lost_slam", "lost_s = [2.0, 4.0]")).unwrap();
    let mut events = Events::default();
    step_until(&mut engine, 3.0, &mut events);
    let during = n_updates(&mut engine);
    assert_eq!(engine.view().state, State::Lost);
    step_until(&mut engine, 5.0, &mut events);
    assert!(n_updates(&mut engine) > during + 10.0);
    assert_eq!(engine.view().state, State::Waiting);
    assert_eq!(events.count(|kind| *kind == EventKind::Relocalized), 1);
    assert_eq!(told("lost_slam"), ["starts 0.0"]);
}

#[test]
fn where_nobody_knows_the_start_a_slam_starts_anywhere() {
    let mut pipeline = mapping("anywhere_slam", "");
    pipeline.mission.initial_pose = InitialPose::WellKnown(rumbo_core::pipeline::WellKnownPose::Unknown);
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 1.0, &mut Events::default());
    assert_eq!(
        (engine.view().state, told("anywhere_slam")),
        (State::Waiting, vec!["starts unknown".to_owned()])
    );
}

#[test]
fn the_trajectory_of_a_run_can_be_asked_at_any_time() {
    let mut engine = Engine::build(&mapping("kept_way", "")).unwrap();
    assert_eq!(engine.trajectory(), Ok(Vec::new()));
    step_until(&mut engine, 2.0, &mut Events::default());
    let poses = engine.trajectory().unwrap();
    assert_eq!(poses.last().map(|pose| pose.stamp), Some(engine.view().estimate.stamp));
    assert!(poses.len() > 10);
    let engine = Engine::build(&crate::pipeline("no_slam")).unwrap();
    assert_eq!(engine.trajectory(), Err(AskError::NoSlam));
}

#[test]
fn a_trajectory_that_steps_back_is_an_error_of_its_plugin() {
    let mut engine = Engine::build(&mapping("back_in_time", "steps_back = true")).unwrap();
    step_until(&mut engine, 1.0, &mut Events::default());
    let told = engine.trajectory().unwrap_err().to_string();
    assert!(told.starts_with("back_in_time: its trajectory has a pose at"), "{told}");
}
