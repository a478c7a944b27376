//! The avoider as the engine asks it.

use super::*;
use rumbo_core::frames::{Pose3, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Path, Seen};
use rumbo_core::trace::Trace;

/// A half-circle of beams that all meet something at these ranges.
fn scan(seconds: f64, range_m: impl Fn(f64) -> f64) -> Observation {
    let mut scan = LaserScan {
        first_bearing_rad: -1.57,
        bearing_step_rad: 0.02,
        min_range_m: 0.05,
        max_range_m: 8.0,
        ..LaserScan::default()
    };
    scan.ranges_m = (0..158).map(|idx| range_m(scan.bearing_rad(idx)) as f32).collect::<Vec<f32>>().into();
    Observation {
        sensor: SensorId(0),
        stamp: Time::from_secs(seconds),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::LaserScan(scan),
    }
}

struct Bench {
    avoider: Box<dyn Avoider>,
    robot: Robot,
    map: Map,
}

impl Bench {
    fn new() -> Bench {
        let avoider = FollowGapParams::default().build(&BuildContext::bare("avoider")).unwrap();
        Bench { avoider, robot: Robot::default(), map: Map::default() }
    }

    fn steer(&mut self, at_s: f64, pose: Pose2, seen: &[Observation]) -> Result<Steering, AvoidError> {
        let now = Time::from_secs(at_s);
        let path = Path::through([Point2::origin(), Point2::new(4.0, 0.0)], 4.0);
        let estimate = Estimate::planar(now, pose, pose, Default::default());
        let input = AvoidInput {
            map_from_base: pose,
            estimate: &estimate,
            twist: Twist::ZERO,
            seen: Seen::sorted(seen),
            map: &self.map,
            grid: None,
            path: path.as_ref(),
            path_number: 1,
            arrival_radius_m: 0.1,
            obstacles: &[],
            robot: &self.robot,
        };
        self.avoider.steer(&mut Cx { now, trace: &Trace::unwatched() }, &input)
    }

    fn twist(&mut self, at_s: f64, pose: Pose2, seen: &[Observation]) -> Twist {
        match self.steer(at_s, pose, seen) {
            Ok(Steering::Drive(twist)) => twist,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_free_way_is_driven_straight_and_at_full_speed() {
    let twist = Bench::new().twist(1.0, Pose2::identity(), &[scan(1.0, |_| 7.0)]);
    assert_eq!(twist, Twist::new(Robot::default().max_speed_m_s, 0.0));
}

#[test]
fn something_ahead_is_passed_on_the_free_side() {
    for side in [1.0, -1.0] {
        let pillar = move |bearing: f64| if (bearing * side + 0.1).abs() < 0.3 { 0.5 } else { 7.0 };
        let twist = Bench::new().twist(1.0, Pose2::identity(), &[scan(1.0, pillar)]);
        assert!(twist.turn_rad_s * side > 0.1, "{side}: {twist:?}");
    }
}

#[test]
fn a_closed_way_is_blocked_by_what_is_seen() {
    let blocked = Bench::new().steer(1.0, Pose2::identity(), &[scan(1.0, |_| 0.4)]).unwrap();
    let Steering::Blocked { obstacles } = blocked else { panic!("{blocked:?}") };
    assert!(obstacles.len() > 50 && obstacles.iter().all(|o| o.position.x > 0.0));
}

#[test]
fn no_progress_for_long_asks_for_another_path() {
    let mut bench = Bench::new();
    let mut at_s = 0.0;
    let stopped_s = loop {
        at_s += 0.1;
        let steering = bench.steer(at_s, Pose2::identity(), &[scan(at_s, |_| 7.0)]).unwrap();
        if let Steering::Blocked { obstacles } = steering {
            assert!(obstacles.is_empty());
            break at_s;
        }
    };
    assert!((stopped_s - 15.0).abs() < 0.5, "{stopped_s}");
}

#[test]
fn the_end_of_the_path_is_an_arrival() {
    let at_end = Bench::new().steer(1.0, pose2(3.95, 0.0, 2.0), &[scan(1.0, |_| 7.0)]);
    assert_eq!(at_end, Ok(Steering::Arrived));
}

#[test]
fn a_silent_scanner_stops_the_robot_and_is_named() {
    let mut bench = Bench::new();
    assert_eq!(bench.twist(1.0, Pose2::identity(), &[]), Twist::ZERO);
    assert!(bench.twist(1.5, Pose2::identity(), &[scan(1.5, |_| 7.0)]).forward_m_s > 0.0);
    let silent = bench.steer(3.0, Pose2::identity(), &[]);
    assert!(matches!(silent, Err(AvoidError::NoReading { kind: "laser scan", .. })), "{silent:?}");
}

#[test]
fn numbers_that_are_none_are_refused() {
    let error = Bench::new().steer(1.0, pose2(f64::NAN, 0.0, 0.0), &[scan(1.0, |_| 7.0)]).unwrap_err();
    assert!(error.to_string().contains("map_from_base"), "{error}");
}
