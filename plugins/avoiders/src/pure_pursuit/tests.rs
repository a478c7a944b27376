//! Robots that drive what pure pursuit steers, exactly.

use super::pursuit::{Motion, Pursuit};
use super::way_ahead::{WayAhead, WayTuning};
use super::*;
use crate::sightings::Sightings;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist, pose2};
use rumbo_core::messages::{Data, LaserScan, Observation, Path, PathPoint, SensorId};
use rumbo_core::robot::{Drive, Hull, Robot, SteeredWheel};
use rumbo_core::time::Time;

const STEP_S: f64 = 0.05;
const ARRIVAL_RADIUS_M: f64 = 0.1;

fn forklift() -> Robot {
    let drive = Drive::Tricycle {
        wheelbase_m: 1.3,
        track_m: 0.9,
        max_steer_deg: 60.0,
        max_steer_rate_deg_s: 60.0,
        steered: SteeredWheel::Rear,
    };
    Robot { drive, max_speed_m_s: 1.0, max_turn_deg_s: 45.0, ..Robot::default() }
}

fn scout() -> Robot {
    Robot { max_speed_m_s: 0.5, max_turn_deg_s: 60.0, ..Robot::default() }
}

fn path(points: &[(f64, f64)]) -> Path {
    Path::through(points.iter().map(|(x, y)| Point2::new(*x, *y)), 0.0).unwrap()
}

/// What came of a drive: the pose and time at its end, the places on the way, and the last motion.
struct Driven {
    pose: Pose2,
    time_s: f64,
    places: Vec<Point2>,
    twists: Vec<Twist>,
    motion: Motion,
}

fn drive(robot: &Robot, params: &PurePursuitParams, start: Pose2, path: &Path) -> Driven {
    drive_where(true, robot, params, start, path)
}

/// Where there is room to turn around, or not.
fn drive_where(
    has_room: bool,
    robot: &Robot,
    params: &PurePursuitParams,
    start: Pose2,
    path: &Path,
) -> Driven {
    let mut pursuit = Pursuit::new(params.pursuit(robot));
    pursuit.follow(path);
    let (mut pose, mut twist, mut places, mut twists) = (start, Twist::ZERO, Vec::new(), Vec::new());
    for k in 0..6000 {
        let motion = pursuit.steer(&pose, twist, ARRIVAL_RADIUS_M);
        let wanted = match motion {
            Motion::Drive(wanted) | Motion::Turn(wanted) => wanted,
            Motion::TurnAround { around, .. } if has_room => around,
            Motion::TurnAround { back, .. } => back,
            _ => return Driven { pose, time_s: f64::from(k) * STEP_S, places, twists, motion },
        };
        assert!(wanted.speed_m_s() <= robot.max_speed_m_s + 1e-12, "{wanted:?}");
        assert!(wanted.turn_rad_s.abs() <= robot.max_turn_rad_s() + 1e-12, "{wanted:?}");
        assert!((robot.drive.feasible(wanted).turn_rad_s - wanted.turn_rad_s).abs() < 1e-9, "{wanted:?}");
        twist = wanted;
        pose *= twist.integrate(STEP_S);
        places.push(pose.translation.vector.into());
        twists.push(twist);
    }
    panic!("still on its way at {pose}");
}

fn off_m(pose: &Pose2, point: (f64, f64)) -> f64 {
    (Point2::from(pose.translation.vector) - Point2::new(point.0, point.1)).norm()
}

#[test]
fn a_robot_on_its_path_stays_on_it_and_stops_at_its_end() {
    let driven = drive(
        &scout(),
        &PurePursuitParams::default(),
        pose2(0.0, 0.0, 0.0),
        &path(&[(0.0, 0.0), (6.0, 0.0)]),
    );
    assert!(driven.motion == Motion::Arrived && off_m(&driven.pose, (6.0, 0.0)) <= ARRIVAL_RADIUS_M);
    assert!(driven.places.iter().all(|place| place.y.abs() < 1e-9));
    // 5.9 m at 0.5 m/s, and a little for the end.
    assert!((11.8..15.0).contains(&driven.time_s), "{}", driven.time_s);
}

/// The arc to a point (x, y) has the curvature 2 y / (x² + y²): driven to its end it meets the point.
#[test]
fn the_arc_leads_through_the_point_ahead() {
    let params =
        PurePursuitParams { look_ahead_m: [2.0, 2.0], turn_above_deg: 170.0, ..PurePursuitParams::default() };
    for (x, y) in [(1.2, 0.4), (0.3, -1.1), (0.9, 0.9)] {
        let mut pursuit = Pursuit::new(params.pursuit(&scout()));
        pursuit.follow(&path(&[(x, y)]));
        let Motion::Drive(twist) = pursuit.steer(&pose2(0.0, 0.0, 0.0), Twist::ZERO, 0.01) else { panic!() };
        let nearest = (1..2000)
            .map(|k| off_m(&twist.integrate(0.01 * f64::from(k)), (x, y)))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.005, "{nearest} {twist:?}");
    }
}

#[test]
fn a_robot_beside_its_path_comes_back_to_it() {
    let way = path(&[(0.0, 0.0), (8.0, 0.0)]);
    for robot in [scout(), forklift()] {
        let driven = drive(&robot, &PurePursuitParams::default(), pose2(0.0, 0.8, 0.3), &way);
        assert_eq!(driven.motion, Motion::Arrived);
        let late = driven.places.iter().filter(|place| place.x > 4.0).map(|place| place.y.abs());
        assert!(late.fold(0.0, f64::max) < 0.08, "{:?}", robot.drive.kind());
    }
}

#[test]
fn corners_are_cut_by_less_than_the_look_ahead() {
    let way = path(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)]);
    let driven = drive(&scout(), &PurePursuitParams::default(), pose2(0.0, 0.0, 0.0), &way);
    let off = driven.places.iter().map(|place| place.y.abs().min((place.x - 4.0).abs()));
    assert!(off.fold(0.0, f64::max) < 0.35);
    assert!(off_m(&driven.pose, (4.0, 4.0)) <= ARRIVAL_RADIUS_M);
}

#[test]
fn a_robot_that_can_turns_in_place_first_and_to_the_heading_at_last() {
    let points = [(0.0, 0.0, None), (-3.0, 0.0, Some(std::f64::consts::FRAC_PI_2))];
    let points = points.map(|(x, y, yaw_rad)| PathPoint { position: Point2::new(x, y), yaw_rad });
    let way = Path::new(points.to_vec(), 0.0).unwrap();
    let driven = drive(&scout(), &PurePursuitParams::default(), pose2(0.0, 0.0, 0.0), &way);
    assert_eq!(driven.twists[0].forward_m_s, 0.0);
    assert!(driven.places.iter().all(|place| place.x < 0.05 && place.y.abs() < 0.1));
    assert!((driven.pose.rotation.angle().to_degrees() - 90.0).abs() <= 3.0);
}

/// From a hundred places around a goal, in every direction: a robot that cannot turn in place gets to all of them.
#[test]
fn a_forklift_reaches_what_is_beside_and_behind_it() {
    let robot = forklift();
    let (mut n_backed, radius_m) = (0, robot.drive.turning_radius_m());
    for k in 0..100 {
        let (angle, distance_m) = (2.399963 * f64::from(k), 0.3 + 0.05 * f64::from(k));
        let goal = (distance_m * angle.cos(), distance_m * angle.sin());
        let driven =
            drive(&robot, &PurePursuitParams::default(), pose2(0.0, 0.0, 0.0), &path(&[(0.0, 0.0), goal]));
        assert_eq!(driven.motion, Motion::Arrived, "{goal:?}");
        assert!(off_m(&driven.pose, goal) <= ARRIVAL_RADIUS_M, "{goal:?}");
        n_backed += usize::from(driven.twists.iter().any(|twist| twist.forward_m_s < 0.0));
        let far = driven.places.iter().map(|place| place.coords.norm()).fold(0.0, f64::max);
        assert!(far < distance_m + 5.0 * radius_m, "{goal:?}: {far}");
    }
    assert!((20..80).contains(&n_backed), "{n_backed}");
    let ahead_only = PurePursuitParams { backs_up: false, ..PurePursuitParams::default() };
    let behind = drive(&robot, &ahead_only, pose2(0.0, 0.0, 0.0), &path(&[(0.0, 0.0), (-3.0, 0.0)]));
    assert_eq!(behind.motion, Motion::CannotFollow);
}

#[test]
fn a_forklift_in_an_aisle_backs_out_of_it() {
    let way = path(&[(0.0, 0.0), (-6.0, 0.0), (-6.0, 3.0)]);
    let driven = drive_where(false, &forklift(), &PurePursuitParams::default(), pose2(0.0, 0.0, 0.0), &way);
    assert_eq!(driven.motion, Motion::Arrived);
    assert!(driven.places.iter().all(|place| place.x < -4.5 || place.y.abs() < 0.1), "straight back");
}

#[test]
fn curves_and_ends_slow_the_robot() {
    let params = PurePursuitParams { to_the_side_m_s2: 0.2, ..PurePursuitParams::default() };
    let circle: Vec<(f64, f64)> =
        (0..=60).map(|k| 0.05 * f64::from(k)).map(|a| (2.0 * a.sin(), 2.0 - 2.0 * a.cos())).collect();
    let driven = drive(&forklift(), &params, pose2(0.0, 0.0, 0.0), &path(&circle));
    let middle = driven.twists[driven.twists.len() / 2];
    assert!((middle.forward_m_s.powi(2) / 2.0 - 0.2).abs() < 0.03, "{middle:?}: v²/r is the acceleration");
    assert!(driven.twists.last().unwrap().forward_m_s < 0.4);
}

fn seen(points: &[(f64, f64)]) -> WayAhead {
    let hull = Hull::Disc { radius_m: 0.3 };
    let mut way = WayAhead::new(WayTuning {
        hull,
        clearance_m: 0.1,
        reach_m: 2.0,
        beside_m: 0.3,
        expected_within_m: 0.2,
    });
    let mut sightings = Sightings::new(10.0);
    for (idx, (x, y)) in points.iter().enumerate() {
        let scan = LaserScan {
            first_bearing_rad: y.atan2(*x),
            bearing_step_rad: 0.01,
            max_range_m: 20.0,
            ranges_m: Buffer::filled(1, x.hypot(*y) as f32),
            ..LaserScan::default()
        };
        let (sensor, base_from_sensor) = (SensorId(idx as u16), Pose3::identity());
        let data = Data::LaserScan(scan);
        let observation = Observation { sensor, stamp: Time(1), base_from_sensor, valid: true, data };
        sightings.see(&observation, &Pose2::identity(), &[]);
    }
    way.look(&sightings, &Pose2::identity());
    way
}

#[test]
fn the_way_along_an_arc_ends_where_the_hull_meets_something() {
    let ahead = seen(&[(1.5, 0.0)]);
    let straight = ahead.free(Twist::new(0.5, 0.0));
    assert!((straight.along_m - 1.1).abs() <= 0.041, "1.5 m less hull and clearance: {straight:?}");
    assert!((straight.beside_m - 1.2).abs() < 1e-6);
    assert_eq!(ahead.free(Twist::new(-0.5, 0.0)).along_m, 2.0, "behind is free");
    // A circle of radius 1 to the left goes around it.
    assert_eq!(ahead.free(Twist::new(0.5, 0.5)).along_m, 2.0);
    // And meets what lies on the circle a quarter of the way round.
    let beside = seen(&[(1.0, 1.0)]).free(Twist::new(0.5, 0.5)).along_m;
    let quarter_m = std::f64::consts::FRAC_PI_2 - 2.0 * (0.4f64 / 2.0).asin();
    assert!((beside - quarter_m).abs() <= 0.041, "{beside} {quarter_m}");
    let passed = seen(&[(0.5, 0.41)]).free(Twist::new(0.5, 0.0));
    assert_eq!(passed.along_m, 2.0, "beside the way");
}

#[test]
fn what_is_in_the_way_is_told_with_what_is_beside_it() {
    let way = seen(&[(1.0, 0.0), (1.0, 0.6), (1.0, 0.9), (-1.0, 0.0)]);
    let found = way.unexpected(Twist::new(0.5, 0.0), &pose2(10.0, 0.0, 0.0), None);
    let places: Vec<(f64, f64)> =
        found.iter().map(|o| (o.position.x, (o.position.y * 10.0).round() / 10.0)).collect();
    assert_eq!(places.len(), 2, "{places:?}");
    assert!(places.iter().all(|(x, _)| (x - 11.0).abs() < 1e-6));
}

#[test]
fn impossible_parameters_are_all_told() {
    use rumbo_core::registry::Params as _;
    assert!(PurePursuitParams::default().check().is_empty());
    let bad = PurePursuitParams {
        look_ahead_m: [2.0, 1.0],
        reach_m: f64::NAN,
        wait_s: -1.0,
        ..PurePursuitParams::default()
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["reach_m", "wait_s", "look_ahead_m"]);
}
