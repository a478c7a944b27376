//! A robot that should be on its way and makes none.

use crate::*;
use rumbo_core::frames::Point2;
use rumbo_core::time::Time;

/// An avoider that turns a little to and fro from the fourth second on, as the rule "near things: turn in place" does in a
/// doorway, before a wall across at 3.2 m.
fn dithering(name: &str, keys: &str, change: impl FnOnce(&mut Pipeline)) -> Pipeline {
    let mut pipeline = pipeline(name);
    pipeline.world = stage(Stage::World, "world", "floor", None, "wall_x_m = 3.2");
    let keys = format!("dithers_at_s = 4.0\n{keys}");
    pipeline.avoider = Some(stage(Stage::Avoider, "avoider", "beeline", None, &keys));
    pipeline.mission.stuck_after_s = Some(5.0);
    pipeline.mission.time_limit_s = 120.0;
    change(&mut pipeline);
    pipeline
}

/// When the robot was found stuck, where, and what was closest.
type Stall = (Time, Point2, Option<(Point2, f64)>);

fn stalls(events: &Events) -> Vec<Stall> {
    let stuck = events.0.iter().filter_map(|event| match event.kind {
        EventKind::Stuck { position, closest } => Some((event.stamp, position, closest)),
        _ => None,
    });
    stuck.collect()
}

#[test]
fn a_deadlock_without_planner_ends_as_stuck_within_ten_seconds() {
    let deadlock = dithering("no planner stuck", "", |p| p.planner = None);
    let (end, summary, events) = run(&deadlock);
    assert_eq!(end.reason, EndReason::Stuck);
    assert!(end.detail.unwrap().contains("less than 0.20 m of progress in 5 s"));
    let stalls = stalls(&events);
    let [(when, position, Some((closest, off_m)))] = stalls[..] else { panic!("{stalls:?}") };
    assert!((8.0..14.0).contains(&when.as_secs()), "{when}: the deadlock is from 4 s on");
    assert_eq!(Time::from_secs(summary.time_s), when);
    // Where the avoider let go of it, by the figures of the world; the nearest beam meets the wall squarely.
    let driven_m = position.coords.norm();
    assert!((driven_m - summary.path_m).abs() < 0.02 && driven_m > 0.5, "{position} {}", summary.path_m);
    assert!((closest.x - 3.2).abs() < 0.01 && (closest.y - position.y).abs() < 0.1, "{closest}");
    let radius_m = deadlock.robot.radius_m;
    assert!((off_m - (3.2 - position.x - radius_m)).abs() < 0.01, "{off_m}");
}

#[test]
fn with_a_planner_a_new_path_is_asked_for_and_may_help() {
    // Dithers on the first two paths only.
    let helped = dithering("stuck for a while", "dithers_on_paths = 2", |p| {
        p.mission = Mission { waypoints: go_to(2.5, 0.5).waypoints, ..p.mission.clone() }
    });
    let (end, summary, events) = run(&helped);
    assert_eq!((end.reason, summary.replans), (EndReason::Arrived, 2));
    let when: Vec<f64> = stalls(&events).iter().map(|(when, ..)| when.as_secs()).collect();
    assert!(when.len() == 2 && (when[1] - when[0] - 5.0).abs() < 0.06, "{when:?}");
    assert_eq!(events.count(|e| matches!(e, EventKind::PlanRequested { replans } if *replans > 0)), 2);
}

#[test]
fn with_a_planner_the_sixth_time_in_one_place_is_the_end() {
    let (end, summary, events) = run(&dithering("stuck for ever", "", |_| ()));
    assert_eq!((end.reason, summary.replans), (EndReason::Stuck, 5));
    assert_eq!(stalls(&events).len(), 6);
    assert!(end.detail.unwrap().contains("6 times in one place"));
    let (end, _, events) = run(&dithering("stuck once", "", |p| p.mission.max_replans = Some(1)));
    assert_eq!((end.reason, stalls(&events).len()), (EndReason::Stuck, 2));
}

#[test]
fn nobody_watches_unless_told_to_and_a_robot_that_drives_is_never_stuck() {
    let (end, _, events) = run(&dithering("unwatched", "", |p| p.mission.stuck_after_s = None));
    assert_eq!((end.reason, stalls(&events).len()), (EndReason::TimeLimit, 0));
    let (end, _, events) = run(&dithering("drives", "dithers_on_paths = 0", |p| {
        p.mission = Mission { waypoints: go_to(2.5, 0.5).waypoints, ..p.mission.clone() };
    }));
    assert_eq!((end.reason, stalls(&events).len()), (EndReason::Arrived, 0));
}

#[test]
fn wheels_that_spin_while_the_map_says_that_the_robot_stands_are_a_stall() {
    let mut spins = pipeline("spins");
    spins.localizer = Some(stage(Stage::Localizer, "quiet", "reckoning", None, "stands = true"));
    spins.planner = None;
    spins.mission = Mission { stuck_after_s: Some(5.0), ..go_to(9.0, 0.0) };
    let (end, summary, events) = run(&spins);
    assert_eq!((end.reason, stalls(&events).len()), (EndReason::Stuck, 1));
    assert!(summary.path_m > 1.0, "it drove {} m meanwhile", summary.path_m);
}

#[test]
fn a_recording_that_stands_is_not_stuck() {
    let mut parked = pipeline("parked");
    parked.world = stage(Stage::World, "world", "floor", None, "drives = false");
    parked.mission = Mission { stuck_after_s: Some(2.0), time_limit_s: 10.0, ..go_to(3.0, 1.0) };
    let (end, _, events) = run(&parked);
    assert_eq!((end.reason, stalls(&events).len()), (EndReason::TimeLimit, 0));
}
