//! Who sees what, and when.

use crate::*;
use rumbo_core::engine::{StepLimits, Stepped};
use rumbo_core::frames::flatten;
use rumbo_core::messages::{Data, SensorId};

fn step_until(engine: &mut Engine, seconds: f64) {
    while engine.view().now.as_secs() < seconds {
        assert_eq!(engine.step(), Stepped::Went);
    }
}

#[test]
fn a_slow_localizer_gets_everything_since_its_last_run_sorted() {
    let mut pipeline = pipeline("multi-rate");
    pipeline.sensors =
        vec![sensor("wheels", "wheels", 4.0, "delay_s = 0.1"), sensor("scanner", "scanner", 2.0, "")];
    pipeline.localizer = Some(stage(Stage::Localizer, "multi-rate", "reckoning", Some(Rate::Every(1.0)), ""));
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 1.0);
    let seen = doubles::logged("multi-rate");
    assert_eq!(seen.len(), 2);
    let expected =
        "odometry:0@150 odometry:0@400 laser_scan:1@500 odometry:0@650 odometry:0@900 laser_scan:1@1000";
    assert_eq!(seen[1], expected, "late stamps are kept and sorted in");
}

#[test]
fn between_two_updates_of_a_slow_localizer_the_odometer_carries_the_pose() {
    let mut pipeline = pipeline("slow localizer");
    pipeline.localizer = Some(stage(Stage::Localizer, "quiet slow", "reckoning", Some(Rate::Every(4.0)), ""));
    let (end, summary, _) = run(&pipeline);
    assert_eq!(end.reason, EndReason::Arrived);
    assert!(summary.rms_error_m.unwrap() < 1e-6);
}

#[test]
fn the_odometer_seat_is_the_only_publisher_of_odometry() {
    let mut pipeline = pipeline("odometer");
    pipeline.odometer = Some(stage(Stage::Localizer, "quiet odometer", "reckoning", None, "scale = 0.5"));
    pipeline.localizer = Some(stage(Stage::Localizer, "behind the odometer", "reckoning", None, ""));
    pipeline.mission = go_to(1.0, 0.0);
    let (end, summary, _) = run(&pipeline);
    assert_eq!(end.reason, EndReason::Arrived);
    assert!(
        (summary.path_m - 2.0).abs() < 0.3,
        "half the way by the odometer is the whole: {}",
        summary.path_m
    );
    let seen = doubles::logged("behind the odometer").join(" ");
    assert!(seen.contains("odometry:65535@") && !seen.contains("odometry:0@"));
}

#[test]
fn a_virtual_sensor_turns_what_others_saw_into_something_else() {
    let mut pipeline = pipeline("virtual");
    pipeline.world = stage(Stage::World, "world", "floor", None, "wall_x_m = 5.0");
    let derived = stage(Stage::Sensor, "sonar", "shortest", None, "");
    pipeline.sensors.push(SensorSpec {
        stage: derived,
        base_from_sensor: Pose3::identity(),
        inputs: vec![1],
    });
    let mut engine = Engine::build(&pipeline).unwrap();
    engine.step();
    let view = engine.view();
    let ring = view.observations.iter().find(|o| o.sensor == SensorId(2)).unwrap();
    let Data::RangeRing(ring) = &ring.data else { panic!("not a ring") };
    assert!((ring.ranges_m[0] - 5.0).abs() < 1e-3);
}

#[test]
fn several_builders_fill_their_layers_in_the_order_of_the_file() {
    let mut pipeline = pipeline("builders");
    pipeline.sensors[1] = sensor("scanner", "scanner", 7.5, "");
    pipeline.map_builders.push(stage(Stage::MapBuilder, "counter", "counter", None, ""));
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 2.0);
    let n_marks = engine.view().map.landmarks.as_ref().unwrap().landmarks.len();
    assert_eq!(n_marks, 16, "7.5 scans a second for two seconds, the first at zero");
    pipeline.map_builders.reverse();
    let error = Engine::build(&pipeline).err().unwrap();
    assert!(error.to_string().contains("counter") && error.to_string().contains("grid"), "{error}");
}

#[test]
fn a_saved_map_has_what_its_builders_add_and_the_run_goes_on_without_it() {
    let mut pipeline = pipeline("saves");
    pipeline.sensors[1] = sensor("scanner", "scanner", 7.5, "");
    pipeline.map_builders.push(stage(Stage::MapBuilder, "marks", "counter", None, ""));
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 2.0);
    let saved = engine.save_map().unwrap();
    assert_eq!(saved.kept, [("marks".to_owned(), 16usize.to_le_bytes().to_vec())]);
    assert!(saved.map.lines.is_some() && engine.view().map.lines.is_none());
    assert_eq!(engine.save_map().unwrap(), saved);
}

#[test]
fn slam_fills_two_seats_at_once() {
    let mut pipeline = pipeline("slam");
    (pipeline.localizer, pipeline.map_builders) = (None, Vec::new());
    pipeline.slam = Some(stage(Stage::Slam, "slam", "believer", None, ""));
    let (end, _, _) = run(&pipeline);
    assert_eq!(end.reason, EndReason::Arrived);
}

#[test]
fn in_real_time_a_planner_works_on_its_own_thread_and_is_joined_at_the_end() {
    let mut pipeline = pipeline("threads");
    pipeline.world = stage(Stage::World, "world", "floor", None, "real_time = true");
    pipeline.planner = Some(stage(Stage::Planner, "waits", "line", None, "waits = true"));
    pipeline.mission.goal_timeout_s = Some(1.0);
    let (end, _, events) = run(&pipeline);
    assert_eq!(end.reason, EndReason::Timeout);
    assert_eq!(events.count(|e| matches!(e, EventKind::PlanFound { .. })), 0);
    pipeline.planner = Some(stage(Stage::Planner, "quick", "line", None, ""));
    pipeline.mission.goal_timeout_s = None;
    let mut engine = Engine::build(&pipeline).unwrap();
    // This floor's time runs as fast as the machine: a thread may need an hour of it only to be woken.
    let hours = std::time::Duration::from_secs(1_000_000);
    engine.set_limits(StepLimits { step: hours, obey: hours });
    let end = engine.run(&mut [], &AtomicBool::new(false));
    assert_eq!(end.reason, EndReason::Arrived);
}

#[test]
fn in_real_time_a_planner_that_never_comes_back_ends_the_mission_with_its_name_and_the_robot_stands() {
    let mut pipeline = pipeline("deaf");
    pipeline.world = stage(Stage::World, "world", "floor", None, "real_time = true");
    pipeline.planner = Some(stage(Stage::Planner, "planner", "line", None, "is_deaf = true"));
    let mut engine = Engine::build(&pipeline).unwrap();
    let second = std::time::Duration::from_secs(1);
    engine.set_limits(StepLimits { step: second, obey: second });
    let mut events = Events::default();
    let end = engine.run(&mut [&mut events], &AtomicBool::new(false));
    let detail = end.detail.unwrap();
    assert_eq!(end.reason, EndReason::PlannerFailed);
    assert!(detail.starts_with("planner `line` of ") && detail.contains("does not come back"), "{detail}");
    assert_eq!(events.count(|e| matches!(e, EventKind::StageFailed { stage, .. } if stage == "planner")), 1);
    assert_eq!(engine.view().command.twist, rumbo_core::frames::Twist::ZERO);
}

#[test]
fn a_seat_that_nobody_fills_is_named() {
    let mut pipeline = pipeline("nobody");
    pipeline.localizer = None;
    assert!(Engine::build(&pipeline).err().unwrap().to_string().contains("[localizer] or [slam]"));
}

#[test]
fn the_estimate_is_never_older_than_the_map_it_was_made_on() {
    let mut engine = Engine::build(&pipeline("order")).unwrap();
    step_until(&mut engine, 1.0);
    let view = engine.view();
    let truth = flatten(&view.truth.unwrap().map_from_base);
    assert!((view.map_from_base.translation.vector - truth.translation.vector).norm() < 1e-9);
}

#[test]
fn waypoints_off_the_map_are_named_before_anything_moves() {
    let mut pipeline = pipeline("waypoints");
    pipeline.mission.waypoints.push(Waypoint { x_m: -3.0, y_m: 2.0, yaw_deg: None });
    let faults = Engine::build_dry(&pipeline).unwrap().waypoint_faults();
    assert_eq!(faults.len(), 1);
    assert!(
        faults[0].to_string().starts_with("waypoint 1 (-3.00, 2.00) m lies outside the map"),
        "{}",
        faults[0]
    );
}

#[test]
fn on_a_recording_sensors_are_due_at_the_recorded_stamps() {
    let mut pipeline = pipeline("recording");
    pipeline.world = stage(Stage::World, "world", "floor", None, "recorded_s = [0.031, 0.2471]");
    pipeline.sensors = vec![sensor("wheels", "wheels", 0.5, "")];
    pipeline.localizer = Some(stage(Stage::Localizer, "recording", "reckoning", None, ""));
    let mut engine = Engine::build(&pipeline).unwrap();
    step_until(&mut engine, 0.3);
    let seen = doubles::logged("recording").join(" ");
    assert!(seen.contains("odometry:0@31 ") && seen.contains("odometry:0@247"), "{seen}");
}

#[test]
fn a_watched_engine_shows_drawings_and_counters_and_an_unwatched_one_none() {
    let mut engine = Engine::build(&pipeline("watched")).unwrap();
    step_until(&mut engine, 0.5);
    assert!(engine.view().drawings.is_empty() && engine.view().counters.is_empty());
    let mut engine = Engine::build(&pipeline("watched")).unwrap();
    engine.watch();
    let mut n_counters = 0;
    while engine.view().now.as_secs() < 0.5 {
        engine.step();
        n_counters += engine.view().counters.len();
    }
    assert_eq!((engine.view().drawings.len(), n_counters), (1, 6));
}
