//! A robot that follows somebody.

use crate::*;
use rumbo_core::engine::{Order, State};
use rumbo_core::frames::Point2;
use rumbo_core::messages::{Goal, PersonPosition};
use rumbo_core::pipeline::Follow;
use rumbo_core::time::Time;

/// Ten meters along x and ten along y at 1.5 m/s, three times as fast as the robot; then she stands.
const CORNER: &str = "route = [[2.0, 1.0, 0.0], [8.0, 10.0, 0.0], [14.667, 10.0, 10.0]]";
const CORNER_ROUTE: [[f64; 3]; 3] = [[2.0, 1.0, 0.0], [8.0, 10.0, 0.0], [14.667, 10.0, 10.0]];

fn follows(name: &str, phone: &str, change: impl FnOnce(&mut Pipeline)) -> Pipeline {
    let mut pipeline = pipeline(name);
    pipeline.sensors.push(sensor("phone", "phone", 5.0, phone));
    let follow = Follow { sensor: Some("phone".into()), ..Follow::default() };
    pipeline.mission = Mission { follow: Some(follow), ..Mission::default() };
    pipeline.duration_s = Some(70.0);
    change(&mut pipeline);
    pipeline
}

/// Where the robot was, how fast it was told to go and in which state, step by step.
#[derive(Default)]
struct Drive(Vec<(Time, Point2, f64, State)>);
impl Observer for Drive {
    fn on_step(&mut self, view: &StepView<'_>) {
        let position = view.truth.unwrap().map_from_base.translation.vector.xy().into();
        self.0.push((view.now, position, view.command.twist.forward_m_s, view.state));
    }
}

fn drive(pipeline: &Pipeline) -> (RunEnd, Summary, Events, Drive) {
    let mut engine = Engine::build(pipeline).unwrap();
    let (mut metrics, mut events, mut drive) = (Metrics::new(), Events::default(), Drive::default());
    let end = engine.run(&mut [&mut metrics, &mut events, &mut drive], &AtomicBool::new(false));
    let summary = metrics.summary(end.reason, end.detail.clone());
    (end, summary, events, drive)
}

/// Farthest that the robot was from the way of the person.
fn off_route_m(drive: &Drive, route: &[[f64; 3]]) -> f64 {
    let walked: Vec<Point2> = (0..2000).map(|k| doubles::on_route(route, 0.01 * f64::from(k))).collect();
    let off = |robot: &Point2| walked.iter().map(|at| (at - robot).norm()).fold(f64::INFINITY, f64::min);
    // It starts a meter before the first of her positions.
    drive.0.iter().filter(|(_, robot, ..)| robot.x > 1.0).map(|(_, robot, ..)| off(robot)).fold(0.0, f64::max)
}

#[test]
fn a_person_who_is_faster_is_followed_round_the_corner_as_she_went() {
    for has_planner in [true, false] {
        let corner = follows("corner", CORNER, |p| {
            if !has_planner {
                p.planner = None;
            }
        });
        let (end, summary, events, drive) = drive(&corner);
        assert_eq!(end.reason, EndReason::Finished, "{:?}", end.detail);
        // Positions to pass are taken within 0.7 m, so the corner is cut by less; the straight way is 7 m off.
        let off_m = off_route_m(&drive, &CORNER_ROUTE);
        assert!(off_m < 0.7, "{off_m}");
        assert!(drive.0.iter().any(|(_, at, ..)| at.x > 9.3 && at.y < 0.7), "it was at the corner");
        let last = drive.0.last().unwrap();
        let off_m = (last.1 - Point2::new(10.0, 10.0)).norm();
        assert!((off_m - 0.5).abs() < 0.1 && last.2 == 0.0, "it stands 0.5 m before her: {off_m}");
        assert!((summary.goal_error_m.unwrap() - off_m).abs() < 1e-9);
        assert_eq!(
            events.count(|e| matches!(e, EventKind::PersonReached(_))),
            2,
            "where she is first, and last"
        );
        assert_eq!(last.3, State::Waiting);
        // Beside her own position: one about every 0.7 m of 19 m, at a reading every 0.3 m.
        let n = events.count(|e| matches!(e, EventKind::GoalAccepted(_)));
        assert!((19..=28).contains(&n), "{n}");
        assert_eq!(summary.stage_failures + summary.replans, 0);
    }
}

#[test]
fn a_person_who_is_slower_is_kept_up_with_at_the_stop_distance() {
    let route = "route = [[0.0, 1.0, 0.0], [40.0, 9.0, 0.0]]";
    let (_, _, events, drive) = drive(&follows("stroll", route, |p| p.duration_s = Some(40.0)));
    for (when, at, ..) in drive.0.iter().filter(|(when, ..)| when.as_secs() > 10.0) {
        let off_m = 1.0 + 0.2 * when.as_secs() - at.x;
        assert!((0.3..1.2).contains(&off_m), "{off_m} m at {when}");
    }
    assert!(events.count(|e| matches!(e, EventKind::PersonReached(_))) >= 3, "it stops and goes");
}

#[test]
fn a_lost_person_is_waited_for_and_then_followed_on() {
    let silent = format!("{CORNER}\nsilent_s = [[6.0, 20.0]]");
    let (end, _, events, drive) = drive(&follows("silence", &silent, |p| p.duration_s = Some(90.0)));
    assert_eq!(end.reason, EndReason::Finished);
    let when = |wanted: &dyn Fn(&EventKind) -> bool| {
        events
            .0
            .iter()
            .filter(|event| wanted(&event.kind))
            .map(|event| event.stamp.as_secs())
            .collect::<Vec<_>>()
    };
    let lost = when(&|kind| matches!(kind, EventKind::PersonLost { last: Some(_), .. }));
    assert!(
        lost.len() == 1 && lost[0] > 10.7 && lost[0] < 11.0,
        "5 s after the last news at 5.8 s: {lost:?}"
    );
    let found = when(&|kind| matches!(kind, EventKind::PersonFound(_)));
    assert!(found.len() == 2 && (found[1] - 20.0).abs() < 0.1, "{found:?}");
    let stands = |(when, _, speed, state): &&(Time, Point2, f64, State)| {
        (12.5..19.9).contains(&when.as_secs()) && (*speed != 0.0 || *state != State::Waiting)
    };
    assert_eq!(drive.0.iter().find(stands), None, "it waits");
    let end_m = (drive.0.last().unwrap().1 - Point2::new(10.0, 10.0)).norm();
    assert!(end_m <= 0.6, "{end_m}");
    // Nobody ever says anything.
    let never = "route = [[0.0, 1.0, 0.0]]\nsilent_s = [[0.0, 100.0]]";
    let (end, summary, events) = run(&follows("never", never, |p| p.duration_s = Some(20.0)));
    assert_eq!((end.reason, summary.path_m), (EndReason::Finished, 0.0));
    assert_eq!(events.count(|e| matches!(e, EventKind::PersonLost { last: None, .. })), 1);
}

#[test]
fn positions_may_come_as_orders_and_only_where_somebody_is_followed() {
    let person = |x: f64| PersonPosition { position: Point2::new(x, 0.0), deviation_m: 0.0 };
    let ordered = follows("ordered", CORNER, |p| p.mission.follow = Some(Follow::default()));
    let mut engine = Engine::build(&ordered).unwrap();
    let mut refused = 0;
    for k in 0..300 {
        if k % 10 == 0 {
            engine.command(Order::PersonAt(person(2.0)));
        }
        if k == 55 {
            engine.command(Order::PersonAt(person(f64::NAN)));
        }
        engine.step();
        let is_refusal =
            |event: &&Event| matches!(event.kind, EventKind::Refused { command: "person_at", .. });
        refused += engine.view().events.iter().filter(is_refusal).count();
    }
    let x = engine.view().truth.unwrap().map_from_base.translation.x;
    assert!((1.4..1.55).contains(&x) && refused == 1, "{x} {refused}");
    let mut elsewhere = Engine::build(&pipeline("follows nobody")).unwrap();
    elsewhere.step();
    elsewhere.command(Order::PersonAt(person(1.0)));
    elsewhere.step();
    assert!(elsewhere.view().events.iter().any(|e| matches!(e.kind, EventKind::Refused { .. })));
}

#[test]
fn an_order_to_go_somewhere_or_to_stop_ends_the_following() {
    let stands = "route = [[0.0, 2.0, 0.0]]";
    let (mut engine, goal) =
        (Engine::build(&follows("ends", stands, |_| ())).unwrap(), Point2::new(0.0, 1.5));
    let mut step = |orders: &mut Vec<(u32, Order)>, n: u32| {
        for k in 0..n {
            while let Some(at) = orders.iter().position(|(when, _)| *when == k) {
                engine.command(orders.remove(at).1);
            }
            engine.step();
        }
        let view = engine.view();
        (view.state, Point2::from(view.truth.unwrap().map_from_base.translation.vector.xy()))
    };
    let goals = vec![Goal { position: goal, yaw_rad: None }];
    let (state, at) = step(&mut vec![(300, Order::GoTo(goals))], 900);
    assert!(state == State::Waiting && (at - goal).norm() < 0.15, "{state} {at}");
    let mut engine = Engine::build(&follows("cancelled", "route = [[0.0, 9.0, 0.0]]", |_| ())).unwrap();
    (0..60).for_each(|_| drop(engine.step()));
    engine.command(Order::Cancel);
    (0..200).for_each(|_| drop(engine.step()));
    assert!(
        engine.view().state == State::Waiting
            && engine.view().truth.unwrap().map_from_base.translation.x < 4.0
    );
}

#[test]
fn no_way_to_the_person_is_no_end_and_asked_for_again() {
    let stands = "route = [[0.0, 4.0, 0.0]]";
    let (end, summary, events) = run(&follows("no way", stands, |p| {
        p.planner = Some(stage(Stage::Planner, "planner", "line", None, "refuses = true"));
        p.duration_s = Some(11.0);
    }));
    assert_eq!((end.reason, summary.path_m), (EndReason::Finished, 0.0));
    let n = events.count(|e| matches!(e, EventKind::Unreachable { .. }));
    assert!((5..=6).contains(&n), "every 2 s: {n}");
}

#[test]
fn a_slow_planner_does_not_stop_the_robot_at_each_position_of_the_trail() {
    let straight = "route = [[0.0, 1.5, 0.0], [10.0, 14.0, 0.0]]";
    let (end, _, _, drive) = drive(&follows("slow planner", straight, |p| {
        p.planner.as_mut().unwrap().latency = Span::from_secs(0.4);
        p.duration_s = Some(25.0);
    }));
    assert_eq!(end.reason, EndReason::Finished);
    let stops = drive.0.iter().filter(|(when, _, speed, _)| when.as_secs() > 3.0 && *speed < 0.3);
    assert_eq!(stops.count(), 0, "it holds its path until the next one comes");
}

#[test]
fn following_ends_with_the_duration_or_the_time_limit_or_a_dead_planner() {
    let endless = |change: &dyn Fn(&mut Pipeline)| run(&follows("endless", CORNER, |p| change(p))).0.reason;
    assert_eq!(endless(&|p| p.duration_s = Some(5.0)), EndReason::Finished);
    let limited = |p: &mut Pipeline| {
        p.duration_s = None;
        p.mission.time_limit_s = 80.0;
    };
    assert_eq!(endless(&limited), EndReason::TimeLimit, "no default of 60 s");
    assert_eq!(endless(&|p| p.mission.goal_timeout_s = Some(0.5)), EndReason::Timeout);
}

#[test]
fn a_robot_that_was_lost_finds_itself_and_follows_on() {
    let (end, _, events, drive) = drive(&follows("lost on the way", CORNER, |p| {
        let keys = "lost_at_s = 12.0";
        p.localizer = Some(stage(Stage::Localizer, "quiet", "reckoning", None, keys));
        p.relocalizer = Some(stage(Stage::Localizer, "turner", "turner", None, ""));
        p.duration_s = Some(90.0);
    }));
    assert_eq!(end.reason, EndReason::Finished);
    assert_eq!(events.count(|e| matches!(e, EventKind::Relocalized)), 1);
    let end_m = (drive.0.last().unwrap().1 - Point2::new(10.0, 10.0)).norm();
    assert!(end_m <= 0.6, "{end_m}");
}

#[test]
fn the_same_walk_twice_gives_the_same_bytes() {
    let text = || {
        let (end, summary, events, drive) = drive(&follows("twice followed", CORNER, |_| ()));
        format!("{end:?} {summary:?} {:?} {:?}", events.0, drive.0)
    };
    assert_eq!(text(), text());
}
