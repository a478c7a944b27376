//! Known answers, exact durations, and closed loops with a small simulated unicycle.

use super::*;
use crate::stop_and_replan::StopAndReplanParams;
use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rumbo_core::frames::pose2;
use rumbo_core::messages::PathPoint;
use rumbo_core::rng::{self, Rng};
use rumbo_core::robot::Robot;

const ARRIVAL_M: f64 = 0.10;
const MERGE_M: f64 = 0.025;

fn vectors() -> toml::Table {
    include_str!("../../../tests/data/control_and_watch.toml").parse().unwrap()
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or(value.as_integer().map(|i| i as f64)).unwrap()
}

fn pairs(value: &toml::Value) -> Vec<(f64, f64)> {
    let pair = |v: &toml::Value| (number(&v[0]), number(&v[1]));
    value.as_array().unwrap().iter().map(pair).collect()
}

fn tuning(thesis_mode: bool, period_s: f64) -> Tuning {
    let params = StopAndReplanParams { thesis_mode, ..StopAndReplanParams::default() };
    params.effective().tuning(&Robot::default(), period_s)
}

/// A unicycle that obeys at once, or as the guard lets it, and remembers where it was.
struct Unicycle {
    pose: Pose2,
    twist: Twist,
    accelerations: Option<(f64, f64)>,
}

impl Unicycle {
    fn obeys_at_once(pose: Pose2) -> Unicycle {
        Unicycle { pose, twist: Twist::ZERO, accelerations: None }
    }

    fn guarded(pose: Pose2) -> Unicycle {
        let robot = Robot::default();
        let accelerations = Some((robot.max_accel_m_s2, robot.max_turn_accel_rad_s2()));
        Unicycle { pose, twist: Twist::ZERO, accelerations }
    }

    fn drive(&mut self, wanted: Twist, period_s: f64) {
        self.twist = match self.accelerations {
            None => wanted,
            Some((straight, turn)) => {
                let near = |from: f64, to: f64, most: f64| from + (to - from).clamp(-most, most);
                Twist::new(
                    near(self.twist.forward_m_s, wanted.forward_m_s, straight * period_s),
                    near(self.twist.turn_rad_s, wanted.turn_rad_s, turn * period_s),
                )
            }
        };
        self.pose *= self.twist.integrate(period_s);
    }
}

struct Run {
    duration_s: f64,
    trail: Vec<Pose2>,
    n_turns_of_sides: [usize; 2],
}

/// Follows the path until the end, or not at all within `limit_s`.
fn follow(
    tuning: Tuning,
    mut robot: Unicycle,
    path: &Path,
    limit_s: f64,
    mut estimate: impl FnMut(f64, &Pose2) -> Pose2,
) -> Option<Run> {
    let mut control = TurnThenGo::new(tuning);
    let mut run = Run { duration_s: 0.0, trail: vec![robot.pose], n_turns_of_sides: [0; 2] };
    control.follow(Time::ZERO, path, &estimate(0.0, &robot.pose), MERGE_M);
    let n_steps = (limit_s / tuning.period_s) as usize;
    for step in 0..n_steps {
        let now_s = step as f64 * tuning.period_s;
        let seen = estimate(now_s, &robot.pose);
        let wanted = match control.steer(Time::from_secs(now_s), &seen, robot.twist, ARRIVAL_M) {
            Motion::Arrived => return Some(Run { duration_s: now_s, ..run }),
            Motion::Stand => Twist::ZERO,
            Motion::Ahead { twist, .. } => twist,
            Motion::Turn(rate) => {
                run.n_turns_of_sides[usize::from(rate < 0.0)] += 1;
                Twist::new(0.0, rate)
            }
        };
        robot.drive(wanted, tuning.period_s);
        run.trail.push(robot.pose);
    }
    None
}

fn exactly(_: f64, pose: &Pose2) -> Pose2 {
    *pose
}

fn through(points: &[(f64, f64)], yaw_rad: Option<f64>) -> Path {
    let mut points: Vec<PathPoint> =
        points.iter().map(|(x, y)| PathPoint { position: Point2::new(*x, *y), yaw_rad: None }).collect();
    points.last_mut().unwrap().yaw_rad = yaw_rad;
    Path::new(points, 0.0).unwrap()
}

#[test]
fn turns_and_distances_are_those_of_the_worked_examples() {
    let vectors = vectors();
    for example in vectors["turn_then_go"].as_array().unwrap() {
        let [from, to] = ["from", "to"].map(|k| Point2::new(number(&example[k][0]), number(&example[k][1])));
        let heading = number(&example["heading"]).to_radians();
        let required = (to.y - from.y).atan2(to.x - from.x);
        assert!((required.to_degrees() - number(&example["required_heading"])).abs() < 1e-8);
        let turn = smaller_turn(heading, required).to_degrees();
        assert!((turn - number(&example["turn"])).abs() < 1e-8, "{turn}");
        // The controller makes this very turn.
        let mut control = TurnThenGo::new(tuning(true, 0.1));
        let pose = pose2(from.x, from.y, heading);
        control.follow(Time::ZERO, &through(&[(from.x, from.y), (to.x, to.y)], None), &pose, MERGE_M);
        let motion = control.steer(Time::ZERO, &pose, Twist::ZERO, ARRIVAL_M);
        assert_eq!(motion, Motion::Turn(2.8f64.to_radians().copysign(turn)));
        assert!(((to - from).norm() - number(&example["distance"])).abs() < 1e-8);
    }
}

#[test]
fn speeds_along_a_movement_are_those_of_the_samples() {
    let vectors = vectors();
    let profile = &vectors["profile"];
    let t = tuning(true, 0.1);
    for (progress_m, speed) in pairs(&profile["linear_samples"]) {
        assert_eq!(t.straight.speed(progress_m, 4.0), speed, "{progress_m}");
    }
    for (progress_deg, speed_deg_s) in pairs(&profile["angular_samples"]) {
        let speed = t.turn.speed(f64::to_radians(progress_deg), 70f64.to_radians());
        assert!((speed.to_degrees() - speed_deg_s).abs() < 1e-12, "{progress_deg}");
    }
    assert_eq!(t.straight.capped(0.07).levels, [0.05, 0.07, 0.07]);
}

#[test]
fn movements_take_the_durations_of_the_source() {
    let vectors = vectors();
    let expected = |key: &str| number(&vectors["profile"][key]);
    // The durations are those of a robot that changes its speed at once.
    let ideal =
        Robot { max_accel_m_s2: 1e6, braking_m_s2: 1e6, max_turn_accel_deg_s2: 1e8, ..Robot::default() };
    for (period_s, tolerance_s) in [(0.0005, 0.002), (0.1, 0.3)] {
        let thesis = StopAndReplanParams { thesis_mode: true, ..StopAndReplanParams::default() };
        let tuning = thesis.effective().tuning(&ideal, period_s);
        for (key, length_m) in [("duration_4m_s", 4.0), ("duration_0_5m_s", 0.5)] {
            let path = through(&[(0.0, 0.0), (length_m, 0.0)], None);
            let robot = Unicycle::obeys_at_once(Pose2::identity());
            let run = follow(tuning, robot, &path, 60.0, exactly).unwrap();
            assert!((run.duration_s - expected(key)).abs() < tolerance_s, "{key}: {}", run.duration_s);
            assert!((run.trail.last().unwrap().translation.x - length_m).abs() < 0.002);
        }
        for (key, turn_deg) in
            [("duration_70deg_s", 70f64), ("duration_20deg_s", 20.0), ("duration_70deg_s", -70.0)]
        {
            let path = through(&[(0.0, 0.0)], Some(turn_deg.to_radians()));
            let robot = Unicycle::obeys_at_once(Pose2::identity());
            let run = follow(tuning, robot, &path, 60.0, exactly).unwrap();
            assert!((run.duration_s - expected(key)).abs() < tolerance_s, "{key}: {}", run.duration_s);
            let end_deg = run.trail.last().unwrap().rotation.angle().to_degrees();
            assert!((end_deg - turn_deg).abs() < 0.1, "{end_deg}");
        }
    }
}

#[test]
fn a_half_turn_goes_clockwise_and_never_changes_its_side_under_noise() {
    let mut rng = rng::stream(3, "half turn");
    let noise = Normal::new(0.0, 2f64.to_radians()).unwrap();
    for start_deg in [-180.0, -90.0, 0.0, 90.0, 179.0f64] {
        let start = pose2(0.0, 0.0, start_deg.to_radians());
        let (sin, cos) = start.rotation.angle().sin_cos();
        let path = through(&[(0.0, 0.0), (-2.0 * cos, -2.0 * sin)], None);
        let exact = follow(tuning(true, 0.1), Unicycle::guarded(start), &path, 120.0, exactly).unwrap();
        assert_eq!(exact.n_turns_of_sides[0], 0, "{start_deg}");
        let noisy = follow(tuning(false, 0.1), Unicycle::guarded(start), &path, 240.0, |_, pose| {
            pose * pose2(0.0, 0.0, noise.sample(&mut rng))
        });
        let [left, right] = noisy.unwrap().n_turns_of_sides;
        // One side makes the half turn, the other at most small corrections.
        assert!(left.min(right) < 60 && left.max(right) > 190, "{start_deg}: {left} {right}");
    }
}

#[test]
fn a_robot_at_its_goal_arrives_at_once_and_turns_only_for_a_wanted_heading() {
    let here = pose2(3.0, -1.0, 2.0);
    for path in [through(&[(3.0, -1.0)], None), through(&[(3.04, -1.0), (3.02, -1.05)], None)] {
        let run = follow(tuning(false, 0.1), Unicycle::guarded(here), &path, 1.0, exactly).unwrap();
        assert_eq!(run.duration_s, 0.0);
    }
    let path = through(&[(3.0, -1.0)], Some(-2.0));
    let run = follow(tuning(false, 0.1), Unicycle::guarded(here), &path, 60.0, exactly).unwrap();
    let end = run.trail.last().unwrap();
    assert!((end.rotation.angle() + 2.0).abs() < 1f64.to_radians());
    assert_eq!(end.translation.vector, here.translation.vector);
    assert_eq!(run.n_turns_of_sides[1], 0, "from 2.0 to -2.0 rad the short way leads through the half turn");
}

/// A controller on its way from (0, 0) to (4, 0), just begun to drive.
fn driving(thesis_mode: bool) -> TurnThenGo {
    let mut control = TurnThenGo::new(tuning(thesis_mode, 0.1));
    let start = Pose2::identity();
    control.follow(Time::ZERO, &through(&[(0.0, 0.0), (4.0, 0.0)], None), &start, MERGE_M);
    assert!(matches!(control.steer(Time::ZERO, &start, Twist::ZERO, ARRIVAL_M), Motion::Ahead { .. }));
    control
}

#[test]
fn a_half_turn_that_rounding_or_noise_puts_on_the_other_side_stays_clockwise() {
    assert!(smaller_turn(0.0, PI - 1e-12) < 0.0 && smaller_turn(0.3, 0.3 + PI) < 0.0);
    assert!(smaller_turn(0.0, PI - 1e-6) > 0.0 && smaller_turn(0.0, -PI + 1e-6) < 0.0);
    let mut control = TurnThenGo::new(tuning(false, 0.1));
    control.follow(Time::ZERO, &through(&[(0.0, 0.0), (-2.0, 0.0)], None), &Pose2::identity(), MERGE_M);
    for yaw_deg in [0.0, 1.0, 2.0, -1.0, 0.5, -3.0] {
        let pose = pose2(0.0, 0.0, f64::to_radians(yaw_deg));
        let motion = control.steer(Time::ZERO, &pose, Twist::ZERO, ARRIVAL_M);
        assert!(matches!(motion, Motion::Turn(rate) if rate < 0.0), "{yaw_deg}: {motion:?}");
    }
}

#[test]
fn a_movement_ends_within_a_quarter_of_its_last_step() {
    let ideal =
        Robot { max_accel_m_s2: 1e6, braking_m_s2: 1e6, max_turn_accel_deg_s2: 1e8, ..Robot::default() };
    let tuning = StopAndReplanParams::default().tuning(&ideal, 0.1);
    for k in 0..20 {
        let (length_m, yaw_rad) = (0.3 + 0.0413 * f64::from(k), 0.2 + 0.1234 * f64::from(k));
        let path = through(&[(0.0, 0.0), (length_m, 0.0)], Some(yaw_rad));
        let run = follow(tuning, Unicycle::obeys_at_once(Pose2::identity()), &path, 90.0, exactly).unwrap();
        let end = run.trail.last().unwrap();
        assert!((end.translation.x - length_m).abs() <= 0.00126, "{length_m}: {}", end.translation.x);
        let off_deg = wrap_angle(end.rotation.angle() - yaw_rad).to_degrees().abs();
        assert!(off_deg <= 0.071, "{yaw_rad}: {off_deg}");
    }
}

#[test]
fn a_checkpoint_once_reached_is_not_lost_to_noise_in_the_last_moment() {
    let path = through(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], None);
    let last_moment = |_: f64, pose: &Pose2| {
        let aside_m = if pose.translation.x > 0.985 && pose.rotation.angle() < 0.01 { 0.07 } else { 0.0 };
        pose2(pose.translation.x, pose.translation.y + aside_m, pose.rotation.angle())
    };
    let run =
        follow(tuning(true, 0.1), Unicycle::guarded(Pose2::identity()), &path, 90.0, last_moment).unwrap();
    assert_eq!(run.n_turns_of_sides[1], 0, "no turn back to a checkpoint 0.07 m aside");
}

#[test]
fn a_heading_that_always_reads_wrong_at_rest_does_not_make_turns_endless() {
    let path = through(&[(0.0, 0.0)], Some(1.0));
    let (mut last, mut off_deg) = (f64::NAN, 3.5f64);
    let wrong_at_rest = |_: f64, pose: &Pose2| {
        let yaw_rad = pose.rotation.angle();
        let rests = yaw_rad == last;
        last = yaw_rad;
        off_deg = if rests { -off_deg } else { off_deg };
        pose2(0.0, 0.0, yaw_rad + if rests { off_deg.to_radians() } else { 0.0 })
    };
    let robot = Unicycle::guarded(Pose2::identity());
    assert!(follow(tuning(true, 0.1), robot, &path, 60.0, wrong_at_rest).is_some());
}

#[test]
fn a_heading_error_stops_the_robot_where_it_would_miss_the_checkpoint() {
    for (side, thesis_mode) in [(1.0, true), (-1.0, true), (1.0, false), (-1.0, false)] {
        let stops = |x_m: f64, yaw_deg: f64| {
            let mut control = driving(thesis_mode);
            let pose = pose2(x_m, 0.0, (side * yaw_deg).to_radians());
            (0..3).any(|_| control.steer(Time::ZERO, &pose, Twist::ZERO, ARRIVAL_M) == Motion::Stand)
        };
        assert!(stops(1.0, 6.0) && !stops(1.0, 4.0));
        assert!(stops(3.5, 7.0) && !stops(3.7, 7.0), "0.04 m beside a checkpoint is near enough");
    }
}

#[test]
fn every_turn_of_a_movement_begins_with_the_narrow_tolerance() {
    let mut control = TurnThenGo::new(tuning(true, 0.1));
    control.follow(Time::ZERO, &through(&[(0.0, 0.0), (0.0, 4.0)], None), &Pose2::identity(), MERGE_M);
    let mut motion = |yaw_deg: f64| {
        let pose = pose2(0.0, 0.5, f64::to_radians(yaw_deg));
        control.steer(Time::ZERO, &pose, Twist::ZERO, ARRIVAL_M)
    };
    assert!(matches!(motion(0.0), Motion::Turn(_)));
    assert_eq!(motion(90.0), Motion::Stand);
    assert!(matches!(motion(90.5), Motion::Ahead { .. }));
    assert_eq!([96.0; 3].map(&mut motion)[2], Motion::Stand);
    assert!(matches!(motion(91.5), Motion::Turn(rate) if rate < 0.0));
}

#[test]
fn a_robot_far_beside_its_line_stops_even_if_it_looks_at_the_checkpoint() {
    for side in [1.0, -1.0] {
        let mut control = driving(true);
        let stops_at = |lateral_m: f64, control: &mut TurnThenGo| {
            let pose = pose2(1.0, lateral_m * side, -(lateral_m * side / 3.0).atan());
            control.steer(Time::ZERO, &pose, Twist::ZERO, ARRIVAL_M) == Motion::Stand
        };
        assert!((0..5).all(|_| !stops_at(0.09, &mut control)));
        // One reading may be noise, three are none.
        assert_eq!(
            [0.12, 0.12, 0.0, 0.12, 0.12, 0.12].map(|m| stops_at(m, &mut control)),
            [false, false, false, false, false, true]
        );
    }
}

#[test]
fn an_odometer_that_always_sees_motion_delays_a_turn_by_a_second_at_most() {
    let mut control = TurnThenGo::new(tuning(true, 0.1));
    control.follow(Time::ZERO, &through(&[(0.0, 0.0), (0.0, 2.0)], None), &Pose2::identity(), MERGE_M);
    let begins = (0..100).find(|k| {
        let now = Time::from_secs(0.1 * f64::from(*k));
        let shaky = Twist::new(0.02, 0.0);
        matches!(control.steer(now, &Pose2::identity(), shaky, ARRIVAL_M), Motion::Turn(_))
    });
    assert_eq!(begins, Some(10));
}

#[test]
fn the_correction_keeps_the_robot_on_its_line_where_thesis_mode_drifts() {
    for side in [1.0, -1.0] {
        let off_m = |thesis_mode: bool| {
            let start = pose2(0.0, 0.0, side * 0.9f64.to_radians());
            let path = through(&[(0.0, 0.0), (4.0, 0.0)], None);
            let run =
                follow(tuning(thesis_mode, 0.1), Unicycle::guarded(start), &path, 60.0, exactly).unwrap();
            run.trail.iter().map(|pose| off_path_m(&path, pose)).fold(0.0, f64::max)
        };
        assert!(off_m(true) > 0.045, "{}", off_m(true));
        assert!(off_m(false) < 0.005, "{}", off_m(false));
        // And back to it from beside.
        let beside = follow(
            tuning(false, 0.1),
            Unicycle::guarded(pose2(0.0, 0.04 * side, 0.0)),
            &through(&[(0.0, 0.04 * side), (4.0, 0.0)], None),
            60.0,
            |now_s, pose| if now_s < 5.0 { pose2(0.0, -0.04 * side, 0.0) * pose } else { *pose },
        );
        let end = *beside.unwrap().trail.last().unwrap();
        assert!(end.translation.y.abs() < 0.01, "{}", end.translation.y);
    }
}

/// The robot must keep at least `room_m` to the left of the line through the origin.
fn wall_on_the_right(room_m: f64, pose: &Pose2) -> Lane {
    Lane { lowest_m: room_m - pose.translation.y, highest_m: f64::INFINITY }
}

/// Turn rates of a driving controller that sees the same pose and the same wall again and again.
fn rates(control: &mut TurnThenGo, room_m: f64, pose: &Pose2, n: usize) -> Vec<Option<f64>> {
    (0..n)
        .map(|_| {
            control.give_way(wall_on_the_right(room_m, pose));
            match control.steer(Time::ZERO, pose, Twist::ZERO, ARRIVAL_M) {
                Motion::Ahead { twist, .. } => Some(twist.turn_rad_s),
                _ => None,
            }
        })
        .collect()
}

#[test]
fn giving_way_is_smooth_bounded_and_no_lateral_error() {
    let mut control = driving(false);
    let aside = pose2(1.0, 0.08, 0.0);
    // However much the wall demands, the robot gives 0.08 m and drives straight there.
    let last = *rates(&mut control, 1.0, &aside, 20).last().unwrap();
    assert!(last.is_some_and(|rate| rate.abs() < 1e-3), "{last:?}");
    // A renewed path does not make it forget.
    control.follow(Time::ZERO, &through(&[(1.0, 0.08), (4.0, 0.0)], None), &aside, MERGE_M);
    assert!(rates(&mut control, 1.0, &aside, 1)[0].is_some_and(|rate| rate.abs() < 2e-3));
    // Beside its line, but not beside where it gives way to.
    let farther = pose2(1.0, 0.12, 0.0);
    assert!(rates(&mut control, 1.0, &farther, 5).iter().all(Option::is_some));
    let first = rates(&mut driving(false), 0.08, &Pose2::identity(), 2);
    assert!(first[0] > Some(0.0) && first[1] > first[0], "smoothly: {first:?}");
}

#[test]
fn a_checkpoint_that_was_passed_aside_is_reached() {
    let mut control = TurnThenGo::new(tuning(false, 0.1));
    control.follow(
        Time::ZERO,
        &through(&[(0.0, 0.0), (1.5, 0.0), (1.5, 2.0)], None),
        &Pose2::identity(),
        MERGE_M,
    );
    let mut robot = Unicycle::guarded(Pose2::identity());
    for step in 0..300 {
        if robot.pose.translation.x < 1.4 {
            control.give_way(wall_on_the_right(0.07, &robot.pose));
        }
        match control.steer(Time::from_secs(0.1 * f64::from(step)), &robot.pose, robot.twist, ARRIVAL_M) {
            Motion::Turn(rate) => {
                assert!(rate > 0.0, "no turn back to a checkpoint 0.07 m aside");
                return;
            }
            Motion::Ahead { twist, .. } => robot.drive(twist, 0.1),
            _ => robot.drive(Twist::ZERO, 0.1),
        }
    }
    panic!("never turned");
}

#[test]
fn a_turn_away_is_followed_by_the_same_straight_piece_unless_the_path_is_another() {
    for other_path in [false, true] {
        let mut control = driving(false);
        let start = Pose2::identity();
        assert!(!control.turn_away(0.0), "nothing beside it");
        control.give_way(wall_on_the_right(0.08, &start));
        assert!(control.turn_away(0.0));
        let away = pose2(0.0, 0.0, (0.08f64 / 0.5).atan());
        let motion = control.steer(Time::ZERO, &start, Twist::ZERO, ARRIVAL_M);
        assert!(matches!(motion, Motion::Turn(rate) if rate > 0.0));
        if other_path {
            control.follow(Time::ZERO, &through(&[(0.0, 0.0), (0.0, -4.0)], None), &start, MERGE_M);
            let motion = control.steer(Time::ZERO, &away, Twist::ZERO, ARRIVAL_M);
            assert!(matches!(motion, Motion::Turn(rate) if rate < 0.0));
        } else {
            assert_eq!(control.steer(Time::ZERO, &away, Twist::ZERO, ARRIVAL_M), Motion::Stand);
            let motion = control.steer(Time::ZERO, &away, Twist::ZERO, ARRIVAL_M);
            assert!(matches!(motion, Motion::Ahead { .. }), "{motion:?}");
        }
    }
    let mut as_published = driving(true);
    as_published.give_way(wall_on_the_right(0.08, &Pose2::identity()));
    assert!(!as_published.turn_away(0.0));
}

#[test]
fn the_robots_own_limits_bound_speeds_and_brakes() {
    let weak = Robot { max_speed_m_s: 0.12, max_turn_deg_s: 4.0, braking_m_s2: 0.2, ..Robot::default() };
    let t = StopAndReplanParams::default().tuning(&weak, 0.1);
    assert_eq!(t.straight.levels, [0.05, 0.10, 0.12]);
    assert_eq!(t.turn.levels.map(|rate| (rate.to_degrees() * 1e6).round() / 1e6), [2.8, 4.0, 4.0]);
    assert!((t.slowing_m_s2 - 0.16).abs() < 1e-12);
}

/// Distance of the robot to the nearest piece of the path.
fn off_path_m(path: &Path, pose: &Pose2) -> f64 {
    let position = Point2::from(pose.translation.vector);
    let pieces = path.points().windows(2).map(|w| {
        let (piece, to_point) = (w[1].position - w[0].position, position - w[0].position);
        let along = (to_point.dot(&piece) / piece.norm_squared()).clamp(0.0, 1.0);
        (to_point - piece * along).norm()
    });
    pieces.fold(f64::INFINITY, f64::min)
}

fn random_path(rng: &mut Rng) -> (Pose2, Path) {
    let start = pose2(rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0), rng.random_range(-3.1..3.1));
    let (mut x, mut y) = (start.translation.x, start.translation.y);
    let mut points = vec![(x, y)];
    for _ in 0..rng.random_range(1..6) {
        let (length_m, heading) = (rng.random_range(0.06..2.5), rng.random_range(-3.1..3.1f64));
        x += length_m * heading.cos();
        y += length_m * heading.sin();
        points.push((x, y));
    }
    let yaw_rad = rng.random_bool(0.5).then(|| rng.random_range(-3.1..3.1));
    (start, through(&points, yaw_rad))
}

/// How far the robot may be from the path, and from the end when it arrives, for an estimate of some noise.
fn arrives_always(thesis_mode: bool, noise_m: f64, noise_deg: f64, jump_m: f64, most_off_m: f64) {
    let mut rng = rng::stream(17, "random paths");
    let mut noise_rng = rng::stream(18, "noise");
    let (place, angle) =
        (Normal::new(0.0, noise_m).unwrap(), Normal::new(0.0, noise_deg.to_radians()).unwrap());
    for case in 0..150 {
        let (start, path) = random_path(&mut rng);
        let most_turns = path.points().len() as f64 * 45.0;
        let limit_s = 30.0 + 3.0 * (path.length_m() / 0.1 + most_turns);
        let mut offset = Pose2::identity();
        let mut next_jump_s = 4.0;
        let run =
            follow(tuning(thesis_mode, 0.1), Unicycle::guarded(start), &path, limit_s, |now_s, pose| {
                if now_s >= next_jump_s {
                    // A correction of the localizer, which stays until the next.
                    offset = pose2(noise_rng.random_range(-1.0..1.0) * jump_m, 0.0, 0.0);
                    next_jump_s += 4.0;
                }
                let mut n = || place.sample(&mut noise_rng);
                let moved = pose2(pose.translation.x + n(), pose.translation.y + n(), pose.rotation.angle());
                offset * moved * pose2(0.0, 0.0, angle.sample(&mut noise_rng))
            });
        let run = run.unwrap_or_else(|| panic!("case {case} has not arrived after {limit_s:.0} s"));
        let off_m = run.trail.iter().map(|pose| off_path_m(&path, pose)).fold(0.0, f64::max);
        assert!(off_m < most_off_m, "case {case}: {off_m:.3} m off the path");
        let end = run.trail.last().unwrap();
        let missed_m = (end.translation.vector - path.end().position.coords).norm();
        assert!(missed_m < ARRIVAL_M + jump_m + 3.0 * noise_m, "case {case}: {missed_m:.3} m from the end");
        if let Some(yaw_rad) = path.end().yaw_rad {
            let off_deg = wrap_angle(end.rotation.angle() - yaw_rad).abs().to_degrees();
            assert!(off_deg < 5.5 + 3.0 * noise_deg, "case {case}: {off_deg:.2} degrees off");
        }
    }
}

#[test]
fn random_paths_are_followed_closely_by_an_exact_estimate() {
    arrives_always(false, 0.0, 0.0, 0.0, 0.06);
    arrives_always(true, 0.0, 0.0, 0.0, 0.06);
}

#[test]
fn random_paths_are_finished_with_a_noisy_estimate() {
    arrives_always(false, 0.01, 0.5, 0.03, 0.20);
    arrives_always(true, 0.01, 0.5, 0.03, 0.25);
    arrives_always(false, 0.03, 2.0, 0.10, 0.35);
}

#[test]
fn a_push_sideways_is_answered_with_another_turn() {
    let path = through(&[(0.0, 0.0), (4.0, 0.0)], None);
    for (side, thesis_mode) in [(1.0, true), (-1.0, true), (1.0, false), (-1.0, false)] {
        let push = |now_s: f64, pose: &Pose2| {
            let pushed = if now_s > 8.0 { 0.2 * side } else { 0.0 };
            pose2(pose.translation.x, pose.translation.y + pushed, pose.rotation.angle())
        };
        let robot = Unicycle::guarded(Pose2::identity());
        let run = follow(tuning(thesis_mode, 0.1), robot, &path, 120.0, push).unwrap();
        let end = run.trail.last().unwrap();
        assert!(
            (end.translation.y + 0.2 * side).abs() < ARRIVAL_M && (end.translation.x - 4.0).abs() < ARRIVAL_M
        );
        assert!(run.n_turns_of_sides[usize::from(side > 0.0)] > 5);
    }
}

#[test]
fn an_estimate_that_jumps_past_the_end_makes_the_robot_come_back() {
    let path = through(&[(0.0, 0.0), (2.0, 0.0)], None);
    let jump = |now_s: f64, pose: &Pose2| {
        pose2(
            pose.translation.x + if now_s > 10.0 { 0.5 } else { 0.0 },
            pose.translation.y,
            pose.rotation.angle(),
        )
    };
    for start_m in [0.0, 0.2] {
        let robot = Unicycle::guarded(pose2(start_m, 0.0, 0.0));
        let run = follow(tuning(false, 0.1), robot, &path, 240.0, jump).unwrap();
        assert!((run.trail.last().unwrap().translation.x - 1.5).abs() < ARRIVAL_M);
    }
}

#[test]
fn a_fast_robot_stops_where_it_shall() {
    let robot = Robot { max_speed_m_s: 2.0, max_turn_deg_s: 180.0, ..Robot::default() };
    let params = StopAndReplanParams {
        linear_speeds_m_s: [0.3, 0.8, 2.0],
        turn_speeds_deg_s: [20.0, 60.0, 180.0],
        ..StopAndReplanParams::default()
    };
    let path = through(&[(0.0, 0.0), (6.0, 0.0), (6.0, 6.0)], Some(0.0));
    let unicycle = Unicycle::guarded(Pose2::identity());
    let run = follow(params.tuning(&robot, 0.1), unicycle, &path, 60.0, exactly).unwrap();
    let off_m = run.trail.iter().map(|pose| off_path_m(&path, pose)).fold(0.0, f64::max);
    assert!(off_m < 0.06, "{off_m}");
    let most_x = run.trail.iter().map(|pose| pose.translation.x).fold(0.0, f64::max);
    assert!(most_x < 6.06, "{most_x}");
}
