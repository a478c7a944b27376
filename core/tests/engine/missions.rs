//! What the navigator and the guard make of trouble.

use crate::*;
use rumbo_core::engine::{Intervention, Order, State};
use rumbo_core::frames::Point2;
use rumbo_core::messages::Goal;
use rumbo_core::pipeline::InitialPose;
use rumbo_core::time::Time;

fn with(name: &str, change: impl FnOnce(&mut Pipeline)) -> Pipeline {
    let mut pipeline = pipeline(name);
    change(&mut pipeline);
    pipeline
}

#[test]
fn an_obstacle_is_remembered_until_the_goal_and_the_plan_knows_it() {
    let blocked = with("blocked", |p| {
        p.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, "blocked_at_s = 2.0"));
        p.mission.forget_seen_through = false;
    });
    let (end, summary, events) = run(&blocked);
    assert_eq!((end.reason, summary.replans), (EndReason::Arrived, 1));
    assert_eq!(events.count(|e| matches!(e, EventKind::Blocked { n_obstacles: 1 })), 1);
    let asked = doubles::logged("blocked planner");
    assert_eq!(asked, ["0 obstacles, 0 cells", "1 obstacles, 1 cells"]);
}

#[test]
fn a_way_that_stays_blocked_ends_after_five_plans() {
    let stuck = with("stuck", |p| {
        p.avoider = Some(stage(
            Stage::Avoider,
            "avoider",
            "beeline",
            None,
            "blocked_at_s = 2.0\nkeeps_blocking = true",
        ));
    });
    let (end, summary, _) = run(&stuck);
    assert_eq!(end.reason, EndReason::Stuck);
    assert!((5..12).contains(&summary.replans), "rolling out is progress: {}", summary.replans);
}

#[test]
fn an_old_obstacle_is_forgotten_before_a_goal_is_called_unreachable() {
    let forgets = |memory_s: f64| {
        with("forgets", |p| {
            p.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, "blocked_at_s = 2.0"));
            p.planner = Some(stage(Stage::Planner, "forgetful", "line", None, "refuses_obstacles = true"));
            p.mission.obstacle_memory_s = memory_s;
            p.mission.forget_seen_through = false;
        })
    };
    assert_eq!(run(&forgets(-1.0)).0.reason, EndReason::Arrived);
    let mut returns = forgets(-1.0);
    let keys = "blocked_at_s = 2.0\nkeeps_blocking = true";
    returns.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, keys));
    let (end, _, events) = run(&returns);
    assert_eq!(end.reason, EndReason::Unreachable, "forgetting is for once");
    assert_eq!(events.count(|e| matches!(e, EventKind::Forgot { .. })), 1);
    let (end, _, _) = run(&forgets(60.0));
    assert_eq!(end.reason, EndReason::Unreachable);
    assert!(end.detail.unwrap().contains("told to refuse"));
}

#[test]
fn who_walks_by_closes_the_way_for_some_seconds_only() {
    let waits = |patience_s: f64, keys: &str| {
        with("waits", |p| {
            p.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, keys));
            p.planner = Some(stage(Stage::Planner, "forgetful", "line", None, "refuses_obstacles = true"));
            p.mission.patience_s = patience_s;
        })
    };
    // Beside the robot, where no beam goes: nothing has seen it since.
    let beside = "blocked_at_s = 2.0\nobstacle_x_m = -0.5";
    let (end, _, events) = run(&waits(10.0, beside));
    assert_eq!(end.reason, EndReason::Arrived);
    assert_eq!(events.count(|e| matches!(e, EventKind::PlanFailed { .. })), 1);
    let (end, _, events) = run(&waits(0.0, beside));
    assert_eq!(end.reason, EndReason::Unreachable, "without patience at once");
    assert_eq!(events.count(|e| matches!(e, EventKind::PlanFailed { .. })), 1);
}

#[test]
fn a_pane_in_the_way_does_not_walk_by_and_is_not_forgotten_because_light_goes_through() {
    let pane = with("pane", |p| {
        p.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, "blocked_at_s = 2.0"));
        p.planner = Some(stage(Stage::Planner, "forgetful", "line", None, "refuses_obstacles = true"));
        p.mission.patience_s = 3.0;
    });
    let (end, _, events) = run(&pane);
    assert_eq!(end.reason, EndReason::Unreachable, "the scanner sees nothing there, and never did");
    assert_eq!(events.count(|e| matches!(e, EventKind::Forgot { .. })), 0);
    assert!(events.count(|e| matches!(e, EventKind::PlanFailed { .. })) > 2, "it waited all the same");
}

/// Bytes of the map's grid, and how many obstacles are remembered, step by step.
#[derive(Default)]
struct MapBytes(Vec<(Vec<u8>, u64, usize)>);
impl Observer for MapBytes {
    fn on_step(&mut self, view: &StepView<'_>) {
        let Some(grid) = &view.map.grid else { return };
        let bytes = grid.cells.iter().flat_map(|cell| cell.to_le_bytes()).collect();
        self.0.push((bytes, view.map.version, view.obstacles.len()));
    }
}

#[test]
fn the_map_is_the_same_to_the_byte_while_obstacles_are_remembered_and_after_the_goal() {
    for refuses in [false, true] {
        let temporary = with("temporary", |p| {
            p.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, "blocked_at_s = 2.0"));
            let keys = format!("refuses_obstacles = {refuses}");
            p.planner = Some(stage(Stage::Planner, "forgetful", "line", None, &keys));
            p.mission.patience_s = 1.0;
        });
        let mut engine = Engine::build(&temporary).unwrap();
        let mut bytes = MapBytes::default();
        let end = engine.run(&mut [&mut bytes], &AtomicBool::new(false));
        assert_eq!(end.reason, if refuses { EndReason::Unreachable } else { EndReason::Arrived });
        let (first, version, _) = &bytes.0[0];
        assert!(bytes.0.iter().all(|(now, at, _)| now == first && at == version));
        assert!(bytes.0.iter().any(|(_, _, n_obstacles)| *n_obstacles > 0));
        assert_eq!(bytes.0.last().unwrap().2, 0, "the obstacles of a goal go with it");
    }
}

#[test]
fn the_second_planner_is_asked_only_when_the_first_refuses() {
    let falls_back = with("falls back", |p| {
        p.planner = Some(stage(Stage::Planner, "first", "line", None, "refuses = true"));
        p.planner_fallback = Some(stage(Stage::Planner, "second", "line", None, ""));
    });
    let (end, _, events) = run(&falls_back);
    assert_eq!(end.reason, EndReason::Arrived);
    assert_eq!(events.count(|e| matches!(e, EventKind::FallbackAsked { .. })), 1);
    let unused = with("not needed", |p| {
        p.planner_fallback = Some(stage(Stage::Planner, "never asked", "line", None, ""));
    });
    assert_eq!(run(&unused).0.reason, EndReason::Arrived);
    assert!(doubles::logged("never asked").is_empty());
}

#[test]
fn a_plan_with_latency_arrives_that_much_later() {
    let late = with("late plan", |p| p.planner.as_mut().unwrap().latency = Span::from_secs(1.25));
    let (end, _, events) = run(&late);
    let found = events.0.iter().find(|e| matches!(e.kind, EventKind::PlanFound { .. })).unwrap();
    assert_eq!((end.reason, found.stamp), (EndReason::Arrived, Time::from_secs(1.25)));
}

#[test]
fn without_planner_the_path_is_the_list_of_waypoints() {
    let bare = with("no planner", |p| {
        p.planner = None;
        p.mission.waypoints.push(Waypoint { x_m: 3.0, y_m: 3.0, yaw_deg: None });
    });
    let (end, _, events) = run(&bare);
    assert_eq!(end.reason, EndReason::Arrived);
    assert_eq!(events.count(|e| matches!(e, EventKind::Arrived(_))), 2);
}

/// Where the robot was when each waypoint was passed.
#[derive(Default)]
struct Passed(Vec<(u64, Point2)>);
impl Observer for Passed {
    fn on_step(&mut self, view: &StepView<'_>) {
        let at = view.truth.unwrap().map_from_base.translation.vector.xy().into();
        let passed = view.events.iter().filter(|event| matches!(event.kind, EventKind::Arrived(_)));
        self.0.extend(passed.map(|_| (view.step, at)));
    }
}

#[test]
fn waypoints_within_the_switch_radius_go_one_a_step_and_the_last_at_the_arrival_radius() {
    let x_m = [2.0, 2.1, 2.2, 4.0];
    let close = with("close waypoints", |p| {
        p.mission.waypoints = x_m.map(|x_m| Waypoint { x_m, y_m: 0.0, yaw_deg: None }).to_vec();
        (p.mission.switch_radius_m, p.mission.arrival_radius_m) = (0.7, 0.3);
    });
    let (mut engine, mut passed) = (Engine::build(&close).unwrap(), Passed::default());
    let end = engine.run(&mut [&mut passed], &AtomicBool::new(false));
    assert_eq!((end.reason, passed.0.len()), (EndReason::Arrived, 4));
    let steps: Vec<u64> = passed.0.iter().map(|(step, _)| *step).collect();
    assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "one a step: {steps:?}");
    // A control tick at 0.4 m/s is 4 cm.
    for ((_, at), (x_m, radius_m)) in passed.0.iter().zip(x_m.into_iter().zip([0.7, 0.7, 0.7, 0.3])) {
        let off_m = x_m - at.x;
        assert!(off_m < radius_m && off_m > radius_m - 0.05, "{off_m} m before {x_m} m");
    }
}

#[test]
fn a_goal_or_a_mission_that_takes_too_long_ends() {
    let slow = with("slow", |p| p.mission.goal_timeout_s = Some(2.0));
    assert_eq!(run(&slow).0.reason, EndReason::Timeout);
    let endless = with("endless", |p| p.mission.time_limit_s = 3.0);
    assert_eq!(run(&endless).0.reason, EndReason::TimeLimit);
}

#[test]
fn a_run_without_mission_wanders_until_its_duration_or_the_end_of_the_world() {
    let wanders = with("wanders", |p| {
        p.mission.waypoints.clear();
        p.duration_s = Some(5.0);
    });
    let (end, summary, _) = run(&wanders);
    assert_eq!(end.reason, EndReason::Finished);
    assert!((summary.path_m - 0.48).abs() < 0.05, "{}", summary.path_m);
    let ends = with("ends", |p| p.world = stage(Stage::World, "world", "floor", None, "ends_at_s = 1.0"));
    assert_eq!(run(&ends).0.reason, EndReason::Ended);
}

#[test]
fn the_guard_stops_before_a_wall_that_the_avoider_ignores() {
    let wall = with("wall", |p| {
        p.world = stage(Stage::World, "world", "floor", None, "wall_x_m = 2.0");
        p.mission = go_to(3.0, 0.0);
        p.mission.time_limit_s = 20.0;
    });
    let (end, summary, events) = run(&wall);
    assert_eq!(end.reason, EndReason::TimeLimit);
    assert!(summary.min_clearance_m.unwrap() > 0.02, "{:?}", summary.min_clearance_m);
    assert!(events.count(|e| *e == EventKind::Guard(Intervention::StopZone)) >= 1);
}

#[test]
fn a_silent_scanner_and_a_mad_avoider_stop_the_robot() {
    let silent = with("silent", |p| {
        p.sensors[1] = sensor("scanner", "scanner", 10.0, "silent_after_s = 1.0");
        p.mission.time_limit_s = 10.0;
    });
    let (_, summary, events) = run(&silent);
    assert_eq!(events.count(|e| *e == EventKind::Guard(Intervention::Stale)), 1);
    assert!(summary.path_m < 1.0);
    let mad = with("mad", |p| {
        p.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, "nan_at_s = 2.0"));
        p.mission.time_limit_s = 10.0;
    });
    let (_, summary, events) = run(&mad);
    assert_eq!(events.count(|e| *e == EventKind::Guard(Intervention::NotFinite)), 1);
    assert!(summary.path_m < 1.0);
}

#[test]
fn a_stage_that_fails_again_and_again_ends_the_run_by_name() {
    let fails = with("fails", |p| {
        p.localizer = Some(stage(Stage::Localizer, "bad localizer", "reckoning", None, "fails = true"));
    });
    let (end, summary, _) = run(&fails);
    assert_eq!(end.reason, EndReason::StageFailed);
    assert!(end.detail.unwrap().contains("bad localizer"));
    assert!(summary.stage_failures >= 50 && summary.path_m == 0.0);
    let poisoned =
        with("poisoned", |p| p.sensors[0] = sensor("wheels", "wheels", 20.0, "poison_after_s = 1.0"));
    let (end, _, events) = run(&poisoned);
    assert_eq!(end.reason, EndReason::StageFailed);
    let said =
        |e: &EventKind| matches!(e, EventKind::StageFailed { error, .. } if error.contains("odometry.twist"));
    assert!(events.count(said) >= 50);
}

#[test]
fn a_lost_robot_is_found_by_the_relocalizer_whose_wish_is_obeyed() {
    let lost = with("lost", |p| {
        p.localizer = Some(stage(Stage::Localizer, "loses", "reckoning", None, "lost_at_s = 2.0"));
        p.relocalizer = Some(stage(Stage::Localizer, "relocalizer", "turner", None, ""));
    });
    let (end, _, events) = run(&lost);
    assert_eq!(end.reason, EndReason::Arrived, "{:?}", events.0);
    assert_eq!(events.count(|e| *e == EventKind::Relocalized), 1);
    let states: Vec<State> = events
        .0
        .iter()
        .filter_map(|e| if let EventKind::State { to, .. } = e.kind { Some(to) } else { None })
        .collect();
    let expected = [
        State::Lost,
        State::Waiting,
        State::Navigating,
        State::Lost,
        State::Localizing,
        State::Waiting,
        State::Navigating,
        State::Waiting,
    ];
    assert_eq!(states, expected);
}

#[test]
fn a_wish_in_a_world_that_cannot_drive_is_an_error() {
    let still = with("still", |p| {
        p.world = stage(Stage::World, "world", "floor", None, "drives = false");
        p.mission.initial_pose = InitialPose::WellKnown(rumbo_core::pipeline::WellKnownPose::Unknown);
        p.relocalizer = Some(stage(Stage::Localizer, "relocalizer", "turner", None, ""));
    });
    let (end, _, events) = run(&still);
    assert_eq!(end.reason, EndReason::StageFailed);
    let said =
        |e: &EventKind| matches!(e, EventKind::StageFailed { error, .. } if error.contains("cannot drive"));
    assert!(events.count(said) > 0);
}

#[test]
fn stages_with_a_rate_do_not_hold_the_clock_while_it_is_not_their_turn() {
    let rated = with("rated", |p| {
        let rate = Some(Rate::Hz(7.0));
        p.localizer = Some(stage(Stage::Localizer, "loses", "reckoning", rate, "lost_at_s = 2.0"));
        p.relocalizer = Some(stage(Stage::Localizer, "relocalizer", "turner", rate, ""));
        p.map_builders.iter_mut().for_each(|builder| builder.rate = rate);
        assert!(!p.map_builders.is_empty());
    });
    let mut engine = Engine::build(&rated).unwrap();
    for _ in 0..20_000 {
        engine.step();
    }
    assert!(engine.view().now.as_secs() > 100.0, "{}", engine.view().now);
}

#[test]
fn orders_go_through_one_door_and_wrong_ones_change_nothing() {
    let mut engine = Engine::build(&with("orders", |p| p.mission.waypoints.clear())).unwrap();
    let goal = |x: f64| Goal { position: nalgebra::Point2::new(x, 0.0), yaw_rad: None };
    engine.command(Order::GoTo(vec![goal(f64::NAN)]));
    engine.step();
    assert!(
        engine.view().events.iter().any(|e| matches!(e.kind, EventKind::Refused { command: "go_to", .. }))
    );
    engine.command(Order::GoTo(vec![goal(1.0), goal(2.0)]));
    engine.step();
    assert_eq!((engine.view().state, engine.view().n_goals_left), (State::Navigating, 2));
    engine.command(Order::Localize);
    engine.step();
    assert_eq!(engine.view().state, State::Navigating);
    engine.command(Order::Cancel);
    engine.step();
    assert_eq!((engine.view().state, engine.view().n_goals_left), (State::Waiting, 0));
}

/// A file of this text, for as long as it lives.
struct ScriptFile(PathBuf);

impl ScriptFile {
    fn of(name: &str, text: &str) -> ScriptFile {
        let path = std::env::temp_dir().join(format!("rumbo-{}-{name}.csv", std::process::id()));
        std::fs::write(&path, text).unwrap();
        ScriptFile(path)
    }
}

impl Drop for ScriptFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn scripted(name: &str, file: &ScriptFile) -> Pipeline {
    with(name, |p| {
        (p.planner, p.avoider) = (None, None);
        p.mission = Mission { commands: Some(file.0.clone()), ..Mission::default() };
    })
}

#[test]
fn a_scripted_drive_is_driven_and_then_the_run_is_finished() {
    let file = ScriptFile::of("drive", "t_s,forward_m_s,turn_deg_s\n0,0.2,0\n5,0.2,20\n7,0,0\n");
    let (end, summary, events) = run(&scripted("scripted", &file));
    assert_eq!((end.reason, end.detail), (EndReason::Finished, None));
    assert!((summary.time_s - 7.0).abs() < 0.11, "{}", summary.time_s);
    // 1.4 m but for what the robot needs to speed up.
    assert!((1.25..1.41).contains(&summary.path_m), "{}", summary.path_m);
    assert_eq!(events.count(|e| matches!(e, EventKind::GoalAccepted(_))), 0);
}

#[test]
fn a_script_that_cannot_be_read_is_a_fault_of_the_mission() {
    let file = ScriptFile::of("bad", "t_s,forward_m_s,turn_deg_s\n0,much,0\n");
    for (folder, expected) in
        [(file.0.clone(), "forward_m_s is `much`"), ("nowhere.csv".into(), "cannot read")]
    {
        let mut pipeline = scripted("bad script", &file);
        pipeline.mission.commands = Some(folder);
        let error = Engine::build(&pipeline).err().unwrap();
        assert_eq!((error.section.as_str(), error.error.path.as_str()), ("mission", "commands"));
        assert!(error.error.message.contains(expected), "{error}");
    }
}

#[test]
fn an_order_to_go_somewhere_ends_a_scripted_drive() {
    let file = ScriptFile::of("order", "t_s,forward_m_s,turn_deg_s\n0,0.0,0\n500,0,0\n");
    let pipeline =
        with("ordered", |p| p.mission = Mission { commands: Some(file.0.clone()), ..Mission::default() });
    let mut engine = Engine::build(&pipeline).unwrap();
    for _ in 0..20 {
        engine.step();
    }
    engine.command(Order::GoTo(vec![Goal { position: Point2::new(3.0, 1.0), yaw_rad: None }]));
    let end = engine.run(&mut [], &AtomicBool::new(false));
    assert_eq!(end.reason, EndReason::Arrived);
}
