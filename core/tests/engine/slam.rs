//! A SLAM keeps its map whatever it is told, and is asked whatever it says.

use crate::{Events, doubles, pipeline, stage};
use nalgebra::Matrix3;
use rumbo_core::engine::{AskError, Engine, EventKind, Order, State, Stepped};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::Map;
use rumbo_core::pipeline::{InitialPose, Mission, Pipeline, WellKnownPose};
use rumbo_core::registry::Stage;
use rumbo_core::saved_state::SavedState;
use std::path::{Path, PathBuf};

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
    engine.command(Order::SetMap(Box::default()));
    step_until(&mut engine, 3.0, &mut events);
    assert!(n_updates(&mut engine) > before && engine.view().map_from_base == at);
    assert_eq!(engine.view().state, State::Waiting);
    let refused = |kind: &EventKind| matches!(kind, EventKind::StageFailed { error, .. } if error.contains("once it has a map"));
    assert_eq!(events.count(refused), 2, "{:?}", events.0);
    assert_eq!(events.count(|kind| matches!(kind, EventKind::Refused { command: "set_map", .. })), 1);
    assert_eq!(told("deaf_slam"), ["starts 0.0", "is told 7.0", "is told unknown"]);
}

#[test]
fn a_reset_begins_the_map_anew_where_the_run_began() {
    let mut engine = Engine::build(&mapping("reset_slam", "")).unwrap();
    let mut events = Events::default();
    step_until(&mut engine, 2.0, &mut events);
    engine.command(stands(7.0));
    step_until(&mut engine, 3.0, &mut events);
    let before = n_updates(&mut engine);
    engine.command(Order::Reset);
    step_until(&mut engine, 3.5, &mut events);
    assert!(n_updates(&mut engine) < before / 2.0, "the map did not begin anew");
    assert!(engine.view().map_from_base.translation.x.abs() < 1e-9);
    assert_eq!(told("reset_slam"), ["starts 0.0", "is told 7.0", "starts 0.0"]);
    assert_eq!(engine.view().state, State::Waiting);
    // A localizer stands where the run began, too, and builders begin anew.
    let mut engine =
        Engine::build(&Pipeline { mission: Mission::default(), ..pipeline("reset_plain") }).unwrap();
    step_until(&mut engine, 1.0, &mut events);
    let version = engine.view().map.version;
    engine.command(stands(7.0));
    step_until(&mut engine, 1.5, &mut events);
    assert!((engine.view().map_from_base.translation.x - 7.0).abs() < 0.5);
    engine.command(Order::Reset);
    step_until(&mut engine, 2.0, &mut events);
    assert!(engine.view().map_from_base.translation.x < 3.0 && engine.view().map.version > version);
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
    pipeline.mission.initial_pose = InitialPose::WellKnown(WellKnownPose::Unknown);
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
    let engine = Engine::build(&pipeline("no_slam")).unwrap();
    assert_eq!(engine.trajectory(), Err(AskError::NoSlam));
}

#[test]
fn the_map_that_is_saved_is_as_its_slam_knows_it_and_the_run_goes_on_with_its_own() {
    let mut engine = Engine::build(&mapping("saved_map", "")).unwrap();
    step_until(&mut engine, 1.0, &mut Events::default());
    let second_cell = |map: &Map| map.grid.as_ref().unwrap().cells[1];
    assert_eq!(second_cell(&engine.save_map().unwrap().map), 7.0);
    assert_eq!(second_cell(&engine.slam_map().unwrap()), 7.0);
    assert_eq!(second_cell(engine.view().map), 0.0);
}

#[test]
fn a_trajectory_that_steps_back_is_an_error_of_its_plugin() {
    let mut engine = Engine::build(&mapping("back_in_time", "steps_back = true")).unwrap();
    step_until(&mut engine, 1.0, &mut Events::default());
    let told = engine.trajectory().unwrap_err().to_string();
    assert!(told.starts_with("back_in_time: its trajectory has a pose at"), "{told}");
}

/// A state that a SLAM of these tests saved after two seconds, at x = 4 m.
fn saved(name: &str) -> PathBuf {
    let mut pipeline = mapping(name, "");
    pipeline.mission.initial_pose = InitialPose::Pose { x_m: 4.0, y_m: 1.0, yaw_deg: 90.0 };
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 2.0, &mut Events::default());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let state = engine.save_state().unwrap();
    assert_eq!((state.plugin.as_str(), state.is_lost, state.bytes.as_slice()), ("believer", false, &[9][..]));
    state.write(&folder.join("slam.state")).unwrap();
    folder
}

/// The robot after a second of a run that goes on from there, and what its SLAM was told.
fn resumed(name: &str, initial_pose: InitialPose) -> (f64, State, Vec<String>) {
    let folder = saved(&format!("{name}_before"));
    let mut pipeline = mapping(name, "");
    pipeline.mission.initial_pose = initial_pose;
    (pipeline.folder, pipeline.resume) = (folder, Some("slam.state".into()));
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 1.0, &mut Events::default());
    let view = engine.view();
    (view.map_from_base.translation.x, view.state, told(name))
}

#[test]
fn a_resumed_slam_is_told_where_it_left_the_robot_or_where_the_pipeline_says_that_it_is() {
    let there = InitialPose::WellKnown(WellKnownPose::World);
    let (x_m, state, told) = resumed("resumed", there);
    assert!((x_m - 4.0).abs() < 1e-9 && state == State::Waiting, "{x_m} {state}");
    // Once when it was built, which is what a check tries, and once when it knows the odometer.
    assert_eq!(told, ["starts saved [9]", "is told 4.0", "is told 4.0"]);
    let elsewhere = InitialPose::Pose { x_m: 6.0, y_m: 0.0, yaw_deg: 0.0 };
    let (x_m, state, told) = resumed("resumed_elsewhere", elsewhere);
    assert!((x_m - 6.0).abs() < 1e-9 && state == State::Waiting, "{x_m} {state}");
    assert_eq!(told, ["starts saved [9]", "is told 4.0", "is told 6.0"]);
    let (_, state, told) = resumed("resumed_anywhere", InitialPose::WellKnown(WellKnownPose::Unknown));
    assert_eq!(told, ["starts saved [9]", "is told 4.0", "is told unknown"]);
    assert_eq!(state, State::Waiting, "it cannot look for the robot, says so, and goes on");
}

#[test]
fn a_robot_that_was_lost_when_it_was_saved_is_looked_for() {
    let folder = saved("was_lost_before");
    let file = folder.join("slam.state");
    let state = SavedState { is_lost: true, ..SavedState::read(&file, "believer").unwrap() };
    state.write(&file).unwrap();
    let mut pipeline = mapping("was_lost", "");
    (pipeline.folder, pipeline.resume) = (folder, Some("slam.state".into()));
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 1.0, &mut Events::default());
    assert_eq!(told("was_lost"), ["starts saved [9]", "is told 4.0", "is told unknown"]);
}

#[test]
fn a_state_that_cannot_be_gone_on_from_is_a_fault_of_its_key() {
    let folder = saved("faulty_state");
    let refused = |keys: &str, file: &str, plugin: Option<&str>| {
        let mut pipeline = mapping("refused", keys);
        if let Some(plugin) = plugin {
            let path = folder.join("other.state");
            let state = SavedState::read(&folder.join("slam.state"), "believer").unwrap();
            SavedState { plugin: plugin.into(), ..state }.write(&path).unwrap();
        }
        (pipeline.folder, pipeline.resume) = (folder.clone(), Some(file.into()));
        let error = Engine::build_dry(&pipeline).err().unwrap();
        assert_eq!((error.section.as_str(), error.error.path.as_str()), ("refused", "resume"));
        error.error.message
    };
    assert!(refused("", "nothing.state", None).contains("nothing.state"));
    assert!(
        refused("", "other.state", Some("graph")).ends_with("was saved by `graph`, and [slam] is `believer`")
    );
    let told = refused("is_told = false", "slam.state", None);
    assert!(told.contains("saved by version") && told.contains("once it has a map"), "{told}");
}

#[test]
fn without_a_slam_there_is_nothing_to_save() {
    let engine = Engine::build(&pipeline("no_slam_to_save")).unwrap();
    assert_eq!(engine.save_state(), Err(AskError::NoSlam));
}
