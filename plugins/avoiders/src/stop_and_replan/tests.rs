//! The avoider as the engine sees it: what it does about readings, paths and their absence.

mod by_sound_and_touch;
mod people;

use super::*;
use crate::sightings::Sightings;
use front_watch::Scene;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist, flatten, lift, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{
    Data, Estimate, LaserScan, Observation, Obstacle, Path, PathPoint, RangeRing, Seen, SensorId,
};
use rumbo_core::registry::{Built, Params, Registry, Stage};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, Cx, Steering};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;

const PERIOD_S: f64 = 0.1;

/// A robot with an avoider, in a plane with discs that only the scanner knows.
struct Bench {
    avoider: StopAndReplan,
    robot: Robot,
    pose: Pose2,
    twist: Twist,
    now: Time,
    grid: Option<Grid>,
    path: Option<Path>,
    path_number: u64,
    map_from_odom: Pose2,
    discs: Vec<(Point2, f64)>,
    obstacles: Vec<Obstacle>,
}

impl Bench {
    fn new(params: StopAndReplanParams) -> Bench {
        let robot = Robot::default();
        Bench {
            avoider: StopAndReplan::new(&params, &robot, 1.0 / PERIOD_S),
            robot,
            pose: Pose2::identity(),
            twist: Twist::ZERO,
            now: Time::from_secs(100.0),
            grid: None,
            path: None,
            path_number: 0,
            map_from_odom: pose2(-3.0, 5.0, 2.0),
            discs: Vec::new(),
            obstacles: Vec::new(),
        }
    }

    fn thesis_params() -> StopAndReplanParams {
        StopAndReplanParams { thesis_mode: true, ..StopAndReplanParams::default() }
    }

    fn thesis() -> Bench {
        Bench::new(Bench::thesis_params())
    }

    fn follow(&mut self, points: &[(f64, f64)]) {
        self.path = Path::through(points.iter().map(|(x, y)| Point2::new(*x, *y)), 0.0);
        self.path_number += 1;
    }

    /// One call; the robot does not move.
    fn steer(&mut self, seen: &[Observation]) -> Result<Steering, AvoidError> {
        let odom_from_base = self.map_from_odom.inverse() * self.pose;
        let estimate = Estimate::planar(self.now, self.pose, odom_from_base, nalgebra::Matrix3::zeros());
        let input = AvoidInput {
            map_from_base: self.pose,
            estimate: &estimate,
            twist: self.twist,
            seen: Seen::sorted(seen),
            map: &Map::default(),
            grid: self.grid.as_ref(),
            path: self.path.as_ref(),
            path_number: self.path_number,
            arrival_radius_m: 0.10,
            obstacles: &self.obstacles,
            robot: &self.robot,
        };
        self.avoider.steer(&mut Cx { now: self.now, trace: &Trace::unwatched() }, &input)
    }

    /// The robot obeys for one period.
    fn obey(&mut self, twist: Twist) {
        self.twist = twist;
        self.pose *= twist.integrate(PERIOD_S);
        self.now = self.now + Span::from_secs(PERIOD_S);
    }

    fn scan(&self) -> Observation {
        let map_from_laser = self.pose;
        let bearings = (-90..=90).map(|deg| f64::from(deg).to_radians());
        let ranges = bearings.map(|bearing| {
            let rays = self.discs.iter().filter_map(|(middle, radius_m)| {
                let in_laser = map_from_laser.inverse() * middle;
                let (sin, cos) = bearing.sin_cos();
                let (along, beside) =
                    (in_laser.x * cos + in_laser.y * sin, in_laser.y * cos - in_laser.x * sin);
                let half = (radius_m * radius_m - beside * beside).sqrt();
                (along - half > 0.0).then_some(along - half)
            });
            rays.fold(f64::INFINITY, f64::min) as f32
        });
        observe(self.now, scan_of(ranges.collect()))
    }

    /// Drives with a scan every `scan_every` periods until the avoider says something else than `Drive`.
    fn drive(&mut self, scan_every: usize, limit_s: f64) -> Option<Steering> {
        for step in 0..(limit_s / PERIOD_S) as usize {
            let seen = if step % scan_every == 0 { vec![self.scan()] } else { Vec::new() };
            match self.steer(&seen).unwrap() {
                Steering::Drive(twist) => self.obey(twist),
                other => return Some(other),
            }
            for (middle, radius_m) in &self.discs {
                let clearance_m = (middle.coords - self.pose.translation.vector).norm() - radius_m - 0.20;
                assert!(clearance_m > 0.0, "contact at {}", self.pose);
            }
        }
        None
    }
}

fn scan_of(ranges: Vec<f32>) -> Data {
    Data::LaserScan(LaserScan {
        first_bearing_rad: -90f64.to_radians(),
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 8.0,
        ranges_m: Buffer::from(ranges),
        ..LaserScan::default()
    })
}

fn ring_of(ranges: [f32; 16]) -> Data {
    Data::RangeRing(RangeRing {
        first_bearing_rad: 0.0,
        bearing_step_rad: 22.5f64.to_radians(),
        cone_rad: 25f64.to_radians(),
        ring_radius_m: 0.20,
        max_range_m: 6.0,
        ranges_m: Buffer::from(ranges.as_slice()),
        ..RangeRing::default()
    })
}

fn observe(stamp: Time, data: Data) -> Observation {
    let sensor = SensorId(u16::from(matches!(data, Data::RangeRing(_))));
    Observation { sensor, stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

/// A scan with these hits (degrees, meters) and nothing else within reach.
fn hits(stamp: Time, hits: &[(f64, f64)]) -> Observation {
    let mut ranges = vec![f32::INFINITY; 181];
    for (deg, range_m) in hits {
        ranges[(deg + 90.0).round() as usize] = *range_m as f32;
    }
    observe(stamp, scan_of(ranges))
}

/// A ring with these echoes (degrees, meters) and nothing else within reach.
fn echoes(stamp: Time, echoes: &[(f64, f64)]) -> Observation {
    let mut ranges = [f32::INFINITY; 16];
    for (deg, range_m) in echoes {
        ranges[(deg / 22.5).round().rem_euclid(16.0) as usize] = *range_m as f32;
    }
    observe(stamp, ring_of(ranges))
}

fn is_blocked(steering: &Result<Steering, AvoidError>) -> bool {
    matches!(steering, Ok(Steering::Blocked { .. }))
}

/// Free cells of 5 cm around the origin; cells whose middle lies within `within_m` of a point are occupied.
fn grid_with(points: &[(f64, f64)], within_m: f64) -> Grid {
    let header = rumbo_core::map::GridHeader {
        origin: [-2.0, -2.0, 0.0],
        ..*Grid::unknown(160, 80, 0.05).unwrap().header()
    };
    let mut grid = Grid::new(header, Buffer::filled(160 * 80, -Grid::CERTAIN)).unwrap();
    for (x, y) in points {
        grid.occupy_disc(Point2::new(*x, *y), within_m);
    }
    grid
}

#[test]
fn the_front_watch_answers_every_vector() {
    let vectors: toml::Table = include_str!("../../tests/data/control_and_watch.toml").parse().unwrap();
    for vector in vectors["front_watch"].as_array().unwrap() {
        let pairs = |key: &str| -> Vec<(f64, f64)> {
            let pair = |v: &toml::Value| (v[0].as_float().unwrap(), v[1].as_float().unwrap());
            vector[key].as_array().unwrap().iter().map(pair).collect()
        };
        let mut bench = Bench::thesis();
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let seen = [hits(bench.now, &pairs("laser")), echoes(bench.now, &pairs("sonar"))];
        let mut sightings = Sightings::new(10.0);
        seen.iter().for_each(|observation| sightings.see(observation, &bench.pose, &[]));
        let scene =
            Scene { now: bench.now, odom_from_base: bench.pose, map_from_base: bench.pose, grid: None };
        let watch = StopAndReplanParams::default().watch(&bench.robot);
        let minimum = vector["minimum"].as_float().unwrap();
        assert!((watch.nearest_ahead_m(&sightings, &scene) - minimum).abs() < 1e-6, "{}", vector["name"]);
        let obstacle = vector["obstacle"].as_bool().unwrap();
        assert_eq!(is_blocked(&bench.steer(&seen)), obstacle, "{}", vector["name"]);
    }
}

#[test]
fn driving_along_a_wall_at_the_least_clearance_raises_no_alarm() {
    // The check of the source's parameters: a wall 0.30 m beside the robot, on either side, for both kinds of sensor.
    for side in [1.0, -1.0] {
        let mut bench = Bench::thesis();
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let laser: Vec<(f64, f64)> =
            (5..=90).map(|deg| (side * f64::from(deg), 0.3001 / f64::from(deg).to_radians().sin())).collect();
        // The outermost ray of the cone, 35 degrees from ahead, meets the wall first.
        let transducer_m = 0.20 * 22.5f64.to_radians().sin();
        let echo_m = (0.30 - transducer_m) / 35f64.to_radians().sin();
        let seen = [hits(bench.now, &laser), echoes(bench.now, &[(side * 22.5, echo_m)])];
        assert!(matches!(bench.steer(&seen), Ok(Steering::Drive(twist)) if twist.forward_m_s > 0.0));
    }
}

#[test]
fn a_laser_that_sits_elsewhere_is_watched_from_where_it_sits() {
    let blocked_by = |mount: Pose3, hit: (f64, f64)| {
        let mut bench = Bench::thesis();
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let seen = [Observation { base_from_sensor: mount, ..hits(bench.now, &[hit]) }];
        is_blocked(&bench.steer(&seen))
    };
    let ahead = lift(&pose2(0.15, 0.0, 0.0));
    assert!(blocked_by(ahead, (0.0, 0.29)) && !blocked_by(ahead, (0.0, 0.31)));
    // Looks back: a hit behind the scanner's back is ahead of nobody.
    assert!(!blocked_by(lift(&pose2(-0.1, 0.0, std::f64::consts::PI)), (0.0, 0.2)));
    // Looks left: what is at its right end lies ahead of the robot.
    assert!(blocked_by(lift(&pose2(0.0, 0.0, std::f64::consts::FRAC_PI_2)), (-90.0, 0.2)));
    // Hangs upside down on the robot's left side: its left is the robot's right.
    let roll = nalgebra::UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    let hanging = Pose3::from_parts(nalgebra::Translation3::new(0.0, 0.2, 0.5), roll);
    assert!(blocked_by(hanging, (60.0, 0.25)), "at (0.125, -0.017) m");
    assert!(!blocked_by(hanging, (-60.0, 0.25)), "at (0.125, 0.417) m, outside the strip");
}

#[test]
fn what_the_map_explains_stops_the_robot_only_below_the_hard_limit() {
    let at = |range_m: f64, params: StopAndReplanParams, wall_m: f64| {
        let mut bench = Bench::new(params);
        bench.grid = Some(grid_with(&[(wall_m, 0.0)], 0.02));
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let seen = [hits(bench.now, &[(0.0, range_m)])];
        is_blocked(&bench.steer(&seen))
    };
    let default = StopAndReplanParams::default;
    assert!(!at(0.29, default(), 0.29) && !at(0.24, default(), 0.29), "expected");
    assert!(at(0.22, default(), 0.24), "below the hard limit");
    assert!(at(0.29, default(), 0.60), "the map says it is farther away");
    assert!(at(0.29, StopAndReplanParams { ignore_expected: false, ..default() }, 0.29));
    assert!(at(0.29, StopAndReplanParams { thesis_mode: true, ..default() }, 0.29));
}

#[test]
fn a_known_wall_beside_the_robot_stops_nobody_however_near() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    let wall: Vec<(f64, f64)> = (-20..60).map(|k| (f64::from(k) * 0.05, 0.225)).collect();
    bench.grid = Some(grid_with(&wall, 0.0));
    bench.follow(&[(0.0, 0.0), (2.0, 0.0)]);
    bench.discs = wall.iter().map(|(x, y)| (Point2::new(*x, *y), 0.01)).collect();
    assert_eq!(bench.drive(2, 60.0), Some(Steering::Arrived));
}

/// Drives along a wall whose face is `room_m` beside the hull, on the side given, and says how near the hull came once
/// it had the time to give way, and where it ended.
fn along_a_wall(params: StopAndReplanParams, side: f64, room_m: f64, end_m: f64) -> (f64, Pose2) {
    let mut bench = Bench::new(params);
    let wall: Vec<(f64, f64)> =
        (-20..60).map(|k| (f64::from(k) * 0.05, side * (0.20 + room_m + 0.01))).collect();
    // On the map the wall is farther away: the estimate is off.
    bench.grid = Some(grid_with(&wall.iter().map(|(x, y)| (*x, y + side * 0.05)).collect::<Vec<_>>(), 0.0));
    bench.discs = wall.iter().map(|(x, y)| (Point2::new(*x, *y), 0.01)).collect();
    bench.follow(&[(0.0, 0.0), (end_m, 0.0)]);
    let mut nearest_m = f64::INFINITY;
    while let Steering::Drive(twist) = bench.steer(&[bench.scan()]).unwrap() {
        bench.obey(twist);
        let (x, y) = (bench.pose.translation.x, bench.pose.translation.y);
        if x > 0.7 && x < end_m - 0.6 {
            nearest_m = nearest_m.min((side * (0.20 + room_m) - y).abs() - 0.20);
        }
        assert!(bench.now.as_secs() < 200.0, "never arrives");
    }
    (nearest_m, bench.pose)
}

#[test]
fn a_robot_gives_way_to_a_wall_beside_it_and_still_ends_where_it_shall() {
    for side in [1.0, -1.0] {
        let (nearest_m, end) = along_a_wall(StopAndReplanParams::default(), side, 0.04, 2.5);
        assert!((0.065..0.09).contains(&nearest_m), "{nearest_m}");
        assert!((end.translation.x - 2.5).abs() < 0.01 && end.translation.y.abs() < 0.03, "{end}");
        let (nearest_m, _) = along_a_wall(StopAndReplanParams::default(), side, 0.10, 2.5);
        assert!((nearest_m - 0.10).abs() < 0.002, "enough room: {nearest_m}");
        let keeps_on = StopAndReplanParams { keep_off_m: 0.0, ..StopAndReplanParams::default() };
        let (nearest_m, _) = along_a_wall(keeps_on, side, 0.04, 2.5);
        assert!((nearest_m - 0.04).abs() < 0.002, "{nearest_m}");
    }
}

#[test]
fn the_lane_counts_what_is_beside_the_next_half_meter_of_the_way() {
    let lowest = |moved_m: f64, left_m: f64, point: (f64, f64)| {
        let (x, y) = (point.0 + moved_m, point.1);
        let mut sightings = Sightings::new(10.0);
        // The nearest whole degree is near enough to the point.
        let hit = (y.atan2(x).to_degrees().round(), x.hypot(y));
        sightings.see(&hits(Time::ZERO, &[hit]), &Pose2::identity(), &[]);
        let moved = pose2(moved_m, 0.0, 0.0);
        let scene = Scene { now: Time::ZERO, odom_from_base: moved, map_from_base: moved, grid: None };
        let tuning = StopAndReplanParams::default().lane(&Robot::default());
        lane::Lane::between(&sightings, &scene, &tuning, left_m).lowest_m
    };
    assert!((lowest(0.0, 2.0, (0.3, -0.23)) - 0.05).abs() < 0.01);
    assert_eq!(lowest(0.0, 2.0, (0.6, -0.23)), f64::NEG_INFINITY, "far ahead");
    assert_eq!(lowest(0.0, 0.2, (0.3, -0.23)), f64::NEG_INFINITY, "beyond the checkpoint");
    assert_eq!(lowest(0.5, 2.0, (-0.1, -0.23)), f64::NEG_INFINITY, "passed already");
    assert_eq!(lowest(0.0, 2.0, (0.3, -0.10)), f64::NEG_INFINITY, "in front, not beside");
    assert_eq!(lowest(0.0, 2.0, (0.3, 0.23)), f64::NEG_INFINITY, "on the left");
}

#[test]
fn what_nobody_expects_is_reported_even_where_the_robot_could_turn_away() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    assert!(!is_blocked(&bench.steer(&[hits(bench.now, &[])])));
    bench.obey(Twist::ZERO);
    let seen = [hits(bench.now, &[(0.0, 0.22), (-70.0, 0.24)])];
    assert!(is_blocked(&bench.steer(&seen)));
}

#[test]
fn a_robot_that_is_held_beside_a_wall_turns_away_and_drives_on() {
    for side in [1.0, -1.0] {
        let mut bench = Bench::new(StopAndReplanParams::default());
        let wall: Vec<(f64, f64)> = (-20..60).map(|k| (f64::from(k) * 0.05, side * 0.245)).collect();
        bench.grid = Some(grid_with(&wall, 0.0));
        bench.discs = wall.iter().map(|(x, y)| (Point2::new(*x, *y), 0.01)).collect();
        bench.follow(&[(0.0, 0.0), (2.0, 0.0)]);
        // The guard lets a robot turn in place, and drive only once it looks away from the wall.
        let mut turned_away = false;
        let arrived = (0..400).any(|_| {
            let seen = [bench.scan()];
            match bench.steer(&seen).unwrap() {
                Steering::Drive(twist) => {
                    let yaw_deg = bench.pose.rotation.angle().to_degrees();
                    turned_away |= side * yaw_deg < -3.0;
                    let held = !turned_away && twist.forward_m_s > 0.0;
                    bench.obey(if held { Twist::ZERO } else { twist });
                    false
                }
                Steering::Arrived => true,
                other => panic!("{other:?} after {}", bench.now),
            }
        });
        assert!(arrived && turned_away);
    }
}

#[test]
fn an_echo_is_expected_where_the_map_has_something_in_its_cone() {
    let at = |echo: (f64, f64), known: (f64, f64)| {
        let params = StopAndReplanParams { sonar_decay_s: 0.0, ..StopAndReplanParams::default() };
        let mut bench = Bench::new(params);
        bench.grid = Some(grid_with(&[known], 0.0));
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let seen = [echoes(bench.now, &[echo])];
        is_blocked(&bench.steer(&seen))
    };
    assert!(at((0.0, 0.28), (3.0, 0.0)), "nothing near on the map");
    assert!(!at((0.0, 0.28), (0.52, 0.02)), "on the map");
    assert!(!at((0.0, 0.28), (0.52, 0.08)), "on the map, inside the cone");
    assert!(at((0.0, 0.28), (0.52, 0.25)), "on the map, outside the cone");
    assert!(at((0.0, 0.28), (0.68, 0.02)), "too short for what is on the map");
    assert!(at((0.0, 0.04), (0.27, 0.02)), "below the hard limit");
    assert!(!at((45.0, 0.05), (3.0, 0.0)), "not a front sonar");
    assert!(at((-22.5, 0.28), (3.0, 0.0)) && at((22.5, 0.28), (3.0, 0.0)));
}

#[test]
fn sonar_alone_reports_the_arc_of_its_cone() {
    let mut bench = Bench::thesis();
    bench.pose = pose2(1.0, 0.5, 0.3);
    bench.follow(&[(1.0, 0.5), (1.0 + 3.0 * 0.3f64.cos(), 0.5 + 3.0 * 0.3f64.sin())]);
    bench.grid = Some(grid_with(&[], 0.0));
    let seen = [hits(bench.now, &[]), echoes(bench.now, &[(22.5, 0.25), (90.0, 0.1)])];
    let Ok(Steering::Blocked { obstacles }) = bench.steer(&seen) else { panic!("not blocked") };
    let tip = bench.pose * Point2::new(0.2 * 22.5f64.to_radians().cos(), 0.2 * 22.5f64.to_radians().sin());
    let mut widest_rad = 0f64;
    for obstacle in &obstacles {
        let from_tip = obstacle.position - tip;
        assert!((from_tip.norm() - 0.25).abs() < 1e-6 && obstacle.radius_m == 0.0);
        let off = from_tip.y.atan2(from_tip.x) - (0.3 + 22.5f64.to_radians());
        widest_rad = widest_rad.max(off.abs());
    }
    assert!(widest_rad <= 12.5f64.to_radians() + 1e-9 && widest_rad > 10f64.to_radians(), "{widest_rad}");
    let grid = bench.grid.as_ref().unwrap();
    let cells: Vec<_> = obstacles.iter().map(|o| grid.cell_at(o.position)).collect();
    let neighbors = cells.iter().enumerate().all(|(i, a)| !cells[..i].contains(a));
    assert!(neighbors && obstacles.len() >= 2, "one obstacle a cell: {cells:?}");
}

#[test]
fn where_the_laser_says_what_it_is_the_sonar_adds_nothing() {
    let n_reported = |laser: &[(f64, f64)]| {
        let params = StopAndReplanParams { sonar_decay_s: 0.0, ..StopAndReplanParams::default() };
        let mut bench = Bench::new(params);
        bench.grid = Some(grid_with(&[], 0.0));
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let seen = [hits(bench.now, laser), echoes(bench.now, &[(0.0, 0.09)])];
        let Ok(Steering::Blocked { obstacles }) = bench.steer(&seen) else { panic!("not blocked") };
        obstacles.len()
    };
    assert_eq!(n_reported(&[(0.0, 0.29)]), 1);
    assert!(n_reported(&[]) > 1, "the arc");
}

#[test]
fn every_unexpected_hit_in_the_strip_is_reported_up_to_the_insertion_range() {
    let scene = [(0.0, 0.25), (10.0, 0.9), (-10.0, 1.1), (40.0, 0.5), (-25.0, 0.6)];
    let found = |params: StopAndReplanParams| {
        let mut bench = Bench::new(params);
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let seen = [hits(bench.now, &scene)];
        let Ok(Steering::Blocked { obstacles }) = bench.steer(&seen) else { panic!("not blocked") };
        let mut ranges: Vec<f64> = obstacles.iter().map(|o| o.position.coords.norm()).collect();
        ranges.sort_by(f64::total_cmp);
        ranges.iter().map(|range| (range * 100.0).round() as i32).collect::<Vec<_>>()
    };
    let thesis = StopAndReplanParams { thesis_mode: true, ..StopAndReplanParams::default() };
    assert_eq!(found(thesis), [25, 60, 90], "the hit at 40 degrees is 0.32 m to the side");
    assert_eq!(found(StopAndReplanParams::default()), [25, 50, 60, 90]);
}

#[test]
fn a_hit_comes_nearer_with_the_robot_until_a_newer_scan_says_otherwise() {
    for newer_scan in [false, true] {
        let params = StopAndReplanParams { stale_after_s: 5.0, ..StopAndReplanParams::default() };
        let mut bench = Bench::new(StopAndReplanParams { thesis_mode: true, ..params });
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
        let mut blocked_at = None;
        for step in 0..60 {
            let far_scan = newer_scan && step == 3;
            let seen = match step {
                0 => vec![hits(bench.now, &[(0.0, 0.5)])],
                _ if far_scan => vec![hits(bench.now, &[(0.0, 2.0)])],
                _ => Vec::new(),
            };
            // The estimate is corrected on the way; the hit stays where the odometer saw it.
            if step == 5 {
                bench.map_from_odom = pose2(0.3, 0.0, 0.0) * bench.map_from_odom;
                bench.pose = pose2(0.3, 0.0, 0.0) * bench.pose;
            }
            match bench.steer(&seen) {
                Ok(Steering::Drive(twist)) => bench.obey(twist),
                Ok(_) => {
                    blocked_at = Some(bench.pose.translation.x - 0.3);
                    break;
                }
                Err(_) => break,
            }
        }
        match blocked_at {
            Some(x) => assert!(!newer_scan && (x - 0.20).abs() < 0.02, "{x}"),
            // Some time after its last scan the robot stops for want of another.
            None => assert!(newer_scan),
        }
    }
}

#[test]
fn a_late_scan_is_placed_where_the_robot_was_and_an_older_one_changes_nothing() {
    let mut bench = Bench::thesis();
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let seen = [hits(bench.now - Span::from_secs(0.6), &[])];
    assert!(!is_blocked(&bench.steer(&seen)));
    bench.twist = Twist::new(0.2, 0.0);
    let then = bench.now - Span::from_secs(0.5);
    // Half a second ago it was 0.35 m away; 0.10 m were driven since.
    let seen = [hits(then, &[(0.0, 0.35)])];
    assert!(is_blocked(&bench.steer(&seen)));

    let mut bench = Bench::thesis();
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let seen = [hits(bench.now, &[(0.0, 2.0)])];
    assert!(!is_blocked(&bench.steer(&seen)));
    let seen = [hits(then, &[(0.0, 0.1)])];
    assert!(!is_blocked(&bench.steer(&seen)), "older than the last");
    let invalid = Observation { valid: false, ..hits(bench.now + Span::from_secs(1.0), &[(0.0, 0.1)]) };
    assert!(!is_blocked(&bench.steer(&[invalid])), "the device does not stand by it");
}

#[test]
fn a_missing_reading_is_waited_for_and_then_an_error() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    for _ in 0..10 {
        assert_eq!(bench.steer(&[]), Ok(Steering::Drive(Twist::ZERO)));
        bench.obey(Twist::ZERO);
    }
    bench.obey(Twist::ZERO);
    assert!(matches!(bench.steer(&[]), Err(AvoidError::NoReading { age_s, .. }) if age_s > 1.0));
    let seen = [hits(bench.now, &[]), echoes(bench.now, &[])];
    assert!(matches!(bench.steer(&seen), Ok(Steering::Drive(twist)) if twist.forward_m_s > 0.0));
    for _ in 0..11 {
        bench.obey(Twist::ZERO);
        let seen = [hits(bench.now, &[])];
        let result = bench.steer(&seen);
        let age_s = (bench.now - Time::from_secs(101.1)).as_secs();
        assert_eq!(result.is_err(), age_s > 1.0 + 1e-9, "{age_s}");
        if let Err(error) = result {
            assert!(error.to_string().starts_with("no range ring for 1.1"), "{error}");
        }
    }
}

#[test]
fn readings_that_nobody_asked_for_do_not_count_as_missing() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let seen = [hits(bench.now, &[])];
    assert!(bench.steer(&seen).is_ok());
    // A minute without a goal: the engine does not ask, and the avoider sees no scans.
    bench.now = bench.now + Span::from_secs(60.0);
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    assert_eq!(bench.steer(&[]), Ok(Steering::Drive(Twist::ZERO)));
}

#[test]
fn without_a_path_the_robot_stands() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    for _ in 0..30 {
        assert_eq!(bench.steer(&[]), Ok(Steering::Drive(Twist::ZERO)));
        bench.obey(Twist::ZERO);
    }
}

#[test]
fn a_path_of_one_point_at_the_robot_is_already_finished() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.02, -0.05)]);
    assert_eq!(bench.steer(&[]), Ok(Steering::Arrived));
    bench.path = Path::new(vec![PathPoint { position: Point2::new(0.0, 0.0), yaw_rad: Some(-1.0) }], 0.0);
    bench.path_number += 1;
    assert!(matches!(bench.steer(&[]), Ok(Steering::Drive(twist)) if twist.turn_rad_s < 0.0));
    assert_eq!(bench.drive(1, 60.0), Some(Steering::Arrived));
    assert!((bench.pose.rotation.angle() + 1.0).abs() < 1f64.to_radians());
}

#[test]
fn turning_in_place_needs_no_watch_and_no_readings() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.0, 0.0), (0.0, 4.0)]);
    for _ in 0..30 {
        let seen = [hits(bench.now, &[(0.0, 0.21)])];
        let Ok(Steering::Drive(twist)) = bench.steer(&seen) else { panic!("does not turn") };
        assert!(twist.turn_rad_s > 0.0 && twist.forward_m_s == 0.0);
        bench.obey(twist);
    }
}

#[test]
fn numbers_that_are_none_are_refused() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    bench.twist = Twist::new(f64::NAN, 0.0);
    assert!(matches!(bench.steer(&[]), Err(AvoidError::Message(_))));
    bench.twist = Twist::ZERO;
    bench.pose = pose2(f64::INFINITY, 0.0, 0.0);
    assert!(matches!(bench.steer(&[]), Err(AvoidError::Message(_))));
    // Beams without a reading are none, and nothing else in the scan is lost by them.
    let mut bench = Bench::thesis();
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let mut ranges = vec![f32::NAN; 181];
    assert!(!is_blocked(&bench.steer(&[observe(bench.now, scan_of(ranges.clone()))])));
    bench.obey(Twist::ZERO);
    ranges[90] = 0.25;
    assert!(is_blocked(&bench.steer(&[observe(bench.now, scan_of(ranges))])));
}

#[test]
fn a_blocked_robot_stands_until_a_new_path_comes_and_then_goes_around() {
    for scan_every in [1, 4] {
        let mut bench = Bench::new(StopAndReplanParams::default());
        bench.discs = vec![(Point2::new(1.5, 0.05), 0.15)];
        bench.grid = Some(grid_with(&[], 0.0));
        bench.follow(&[(0.0, 0.0), (3.0, 0.0)]);
        let Some(Steering::Blocked { obstacles }) = bench.drive(scan_every, 60.0) else {
            panic!("not blocked")
        };
        assert!(obstacles.len() > 3);
        for obstacle in &obstacles {
            assert!(((obstacle.position - bench.discs[0].0).norm() - 0.15).abs() < 0.02);
        }
        let stopped_at = bench.pose.translation.x;
        assert!(stopped_at > 0.55 && stopped_at < 0.75, "looks ahead: {stopped_at}");
        for _ in 0..20 {
            let seen = [bench.scan()];
            assert_eq!(bench.steer(&seen), Ok(Steering::Drive(Twist::ZERO)));
            bench.obey(Twist::ZERO);
        }
        let grid = bench.grid.as_mut().unwrap();
        obstacles.iter().for_each(|obstacle| grid.occupy_disc(obstacle.position, obstacle.radius_m));
        bench.follow(&[(stopped_at, 0.0), (1.2, -0.5), (2.0, -0.5), (3.0, 0.0)]);
        assert_eq!(bench.drive(scan_every, 120.0), Some(Steering::Arrived));
        assert!((bench.pose.translation.x - 3.0).abs() < 0.1 && bench.pose.translation.y.abs() < 0.1);
    }
}

#[test]
fn a_robot_that_stopped_at_the_stop_distance_can_leave_along_a_new_path() {
    let mut bench = Bench::new(StopAndReplanParams { look_ahead_m: 0.0, ..StopAndReplanParams::default() });
    bench.discs = (-5..=5).map(|k| (Point2::new(1.0, 0.1 * f64::from(k)), 0.06)).collect();
    bench.grid = Some(grid_with(&[], 0.0));
    bench.follow(&[(0.0, 0.0), (3.0, 0.0)]);
    let Some(Steering::Blocked { obstacles }) = bench.drive(1, 60.0) else { panic!("not blocked") };
    let gap_m = 1.0 - 0.06 - bench.pose.translation.x;
    assert!((0.27..0.30).contains(&gap_m), "{gap_m}");
    let grid = bench.grid.as_mut().unwrap();
    obstacles.iter().for_each(|obstacle| grid.occupy_disc(obstacle.position, obstacle.radius_m));
    // Along the obstacle, nearer than the stop distance, then past its end.
    let x = bench.pose.translation.x;
    bench.follow(&[(x, 0.0), (x, 1.2), (2.0, 1.2)]);
    assert_eq!(bench.drive(1, 120.0), Some(Steering::Arrived));
}

#[test]
fn thesis_mode_looks_no_farther_than_the_stop_distance() {
    let mut bench = Bench::thesis();
    bench.discs = vec![(Point2::new(1.5, 0.0), 0.15)];
    bench.follow(&[(0.0, 0.0), (3.0, 0.0)]);
    assert!(matches!(bench.drive(1, 60.0), Some(Steering::Blocked { .. })));
    let gap_m = 1.5 - 0.15 - bench.pose.translation.x;
    assert!((0.27..0.30).contains(&gap_m), "{gap_m}");
}

#[test]
fn a_single_far_hit_is_taken_for_noise_and_one_beyond_the_checkpoint_for_no_matter() {
    let closed = |seen_hits: &[(f64, f64)], end_m: f64| {
        let mut bench = Bench::new(StopAndReplanParams::default());
        bench.follow(&[(0.0, 0.0), (end_m, 0.0)]);
        let seen = [hits(bench.now, seen_hits)];
        is_blocked(&bench.steer(&seen))
    };
    assert!(!closed(&[(0.0, 0.65)], 3.0));
    assert!(closed(&[(0.0, 0.65), (1.0, 0.65)], 3.0));
    assert!(!closed(&[(0.0, 0.65), (1.0, 0.65)], 0.35), "beyond the checkpoint and the hull around it");
    assert!(!closed(&[(25.0, 0.65), (26.0, 0.65)], 3.0), "0.27 m to the side");
    assert!(!closed(&[(0.0, 0.75), (1.0, 0.75)], 3.0), "too far to be sure");
}

#[test]
fn a_fast_robot_stops_as_early_as_its_brakes_need() {
    let mut bench = Bench::new(StopAndReplanParams { look_ahead_m: 0.0, ..StopAndReplanParams::default() });
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let seen = [hits(bench.now, &[(0.0, 0.45)])];
    assert!(!is_blocked(&bench.steer(&seen)));
    // 0.5 m/s: 0.25 m to brake, 0.05 m until the brakes act, 0.20 m hull, 0.05 m margins.
    bench.twist = Twist::new(0.5, 0.0);
    assert!(is_blocked(&bench.steer(&[])));
    // 0.15 m before its checkpoint it stops anyway, 0.05 m short of the hit.
    let mut bench = Bench::new(StopAndReplanParams { look_ahead_m: 0.0, ..StopAndReplanParams::default() });
    bench.follow(&[(0.0, 0.0), (0.15, 0.0)]);
    let seen = [hits(bench.now, &[(0.0, 0.45)])];
    assert!(!is_blocked(&bench.steer(&seen)));
    bench.twist = Twist::new(0.5, 0.0);
    assert!(!is_blocked(&bench.steer(&[])));
}

#[test]
fn a_robot_that_is_held_says_that_it_is_blocked() {
    for points in [[(0.0, 0.0), (4.0, 0.0)], [(0.0, 0.0), (0.0, 4.0)]] {
        let mut bench = Bench::new(StopAndReplanParams::default());
        bench.follow(&points);
        let blocked_after = (0..100).find(|_| {
            let seen = [hits(bench.now, &[])];
            let blocked = is_blocked(&bench.steer(&seen));
            bench.obey(Twist::ZERO);
            blocked
        });
        assert_eq!(blocked_after, Some(30));
    }
}

#[test]
fn a_path_that_is_only_renewed_does_not_stop_the_robot() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let mut slowest_m_s = f64::INFINITY;
    for step in 0..150 {
        let seen = [hits(bench.now, &[])];
        let Ok(Steering::Drive(twist)) = bench.steer(&seen) else { panic!("not driving") };
        if step > 60 {
            slowest_m_s = slowest_m_s.min(twist.forward_m_s);
        }
        bench.obey(twist);
        if step % 10 == 9 {
            bench.follow(&[(bench.pose.translation.x, bench.pose.translation.y), (4.0, 0.01)]);
        }
    }
    assert_eq!(slowest_m_s, 0.20);
    bench.follow(&[(bench.pose.translation.x, 0.0), (4.0, 2.0)]);
    let seen = [hits(bench.now, &[])];
    assert_eq!(bench.steer(&seen), Ok(Steering::Drive(Twist::ZERO)), "another direction needs a stop");
}

#[test]
fn a_staircase_of_cells_is_one_straight_piece_but_not_in_thesis_mode() {
    let stops = |thesis_mode: bool| {
        let mut bench = Bench::new(StopAndReplanParams { thesis_mode, ..StopAndReplanParams::default() });
        bench.grid = Some(grid_with(&[], 0.0));
        bench.pose = pose2(0.0, 0.0, 0.46);
        // Two cells ahead, one up, again and again: a slant of one in two.
        let cells: Vec<(f64, f64)> = (0..=10)
            .flat_map(|k| {
                [(0.1, 0.05), (0.15, 0.05)].map(|(x, y)| (x + 0.1 * f64::from(k), y * f64::from(k + 1)))
            })
            .collect();
        bench.follow(&[&[(0.0, 0.0)], cells.as_slice()].concat());
        let mut n_stops = 0;
        for _ in 0..4000 {
            match bench.steer(&[hits(bench.now, &[])]).unwrap() {
                Steering::Drive(twist) => {
                    n_stops += u32::from(twist == Twist::ZERO && bench.twist != Twist::ZERO);
                    bench.obey(twist);
                }
                _ => break,
            }
        }
        n_stops
    };
    assert!(stops(false) <= 2, "{}", stops(false));
    assert!(stops(true) > 10, "{}", stops(true));
}

#[test]
fn the_registry_builds_it_from_its_defaults_and_every_bad_value_is_named() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Avoider, "stop_and_replan").unwrap();
    let configured = entry.source.parse(entry.source.defaults()).ok().unwrap();
    assert!(configured.check().is_empty());
    assert!(matches!(configured.build(&BuildContext::bare("avoider")), Ok(Built::Avoider(_))));
    let keys: toml::Table = "linear_speed_m_s = [1, 2, 3]".parse().unwrap();
    assert!(entry.source.parse(keys).is_err());
    let bad = StopAndReplanParams {
        linear_speeds_m_s: [0.2, 0.1, 0.3],
        turn_ramps_deg: [5.0, f64::NAN],
        stop_distance_m: -0.3,
        heading_gain_per_s: f64::INFINITY,
        heading_tolerance_deg: 7.0,
        ..StopAndReplanParams::default()
    };
    let keys: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    let expected = [
        "linear_speeds_m_s",
        "turn_ramps_deg",
        "stop_distance_m",
        "heading_gain_per_s",
        "heading_tolerance_deg",
    ];
    assert_eq!(keys, expected);
}

#[test]
fn the_estimate_of_the_bench_is_consistent() {
    let bench = Bench::thesis();
    let odom_from_base = bench.map_from_odom.inverse() * bench.pose;
    let estimate = Estimate::planar(bench.now, bench.pose, odom_from_base, nalgebra::Matrix3::zeros());
    let again = flatten(&estimate.map_from_odom) * odom_from_base;
    assert!((again.to_homogeneous() - bench.pose.to_homogeneous()).norm() < 1e-12);
}
