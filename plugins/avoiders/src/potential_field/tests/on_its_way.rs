//! The avoider as a stage: what it answers in situations of its own.

use super::super::*;
use super::pioneer;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Path, PathPoint, Seen, SensorId};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, Cx, Steering};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

struct Situation {
    avoider: PotentialField,
    robot: Robot,
    path: Option<Path>,
    step: i64,
}

/// Half a turn of beams, all alike.
fn scan(range_m: f32, stamp: Time, valid: bool) -> Observation {
    let data = Data::LaserScan(LaserScan {
        first_bearing_rad: -90f64.to_radians(),
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 8.0,
        ranges_m: Buffer::filled(181, range_m),
        ..LaserScan::default()
    });
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid, data }
}

impl Situation {
    fn new(params: &PotentialFieldParams, robot: Robot, path: Option<Path>) -> Situation {
        Situation { avoider: PotentialField::new(params, &robot).unwrap(), robot, path, step: 0 }
    }

    /// 50 ms later, somewhere.
    fn steer(
        &mut self,
        pose: Pose2,
        seen: impl Fn(Time) -> Option<Observation>,
    ) -> Result<Steering, AvoidError> {
        let now = Time(self.step * 50_000_000);
        self.step += 1;
        let seen: Vec<Observation> = seen(now).into_iter().collect();
        let estimate = Estimate::planar(now, pose, pose, nalgebra::Matrix3::zeros());
        let (map, trace) = (Map::default(), Trace::unwatched());
        let input = AvoidInput {
            map_from_base: pose,
            estimate: &estimate,
            twist: Twist::ZERO,
            seen: Seen::sorted(&seen),
            map: &map,
            grid: None,
            path: self.path.as_ref(),
            path_number: 1,
            arrival_radius_m: 0.55,
            obstacles: &[],
            robot: &self.robot,
        };
        self.avoider.steer(&mut Cx { now, trace: &trace }, &input)
    }
}

fn ahead(yaw_rad: Option<f64>) -> Option<Path> {
    let point = |x: f64, yaw_rad| PathPoint { position: Point2::new(x, 0.0), yaw_rad };
    Path::new(vec![point(0.0, None), point(5.0, yaw_rad)], 0.0)
}

#[test]
fn a_blind_camera_stops_the_robot_at_once_and_is_named_after_a_second() {
    let mut situation = Situation::new(&PotentialFieldParams::default(), pioneer(), ahead(None));
    let at = pose2(0.0, 0.0, 0.0);
    let Ok(Steering::Drive(twist)) = situation.steer(at, |now| Some(scan(7.0, now, true))) else { panic!() };
    assert!(twist.forward_m_s > 0.0);
    for _ in 0..20 {
        let answer = situation.steer(at, |now| Some(scan(f32::NAN, now, false)));
        assert_eq!(answer, Ok(Steering::Drive(Twist::ZERO)));
    }
    let mut answers = (0..25).map(|_| situation.steer(at, |now| Some(scan(f32::NAN, now, false))));
    assert!(answers.any(|answer| matches!(answer, Err(AvoidError::NoReading { kind: "laser_scan", .. }))));
}

#[test]
fn a_robot_that_is_held_says_that_it_is_blocked_and_by_what() {
    let mut situation = Situation::new(&PotentialFieldParams::default(), pioneer(), ahead(None));
    let at = pose2(0.0, 0.0, 0.0);
    let mut answers = (0..100).map(|_| situation.steer(at, |now| Some(scan(0.7, now, true))).unwrap());
    let blocked = answers.find(|answer| matches!(answer, Steering::Blocked { .. }));
    let Some(Steering::Blocked { obstacles }) = blocked else { panic!("it never said so") };
    assert!(obstacles.len() > 100);
    assert!(obstacles.iter().all(|o| (o.position.coords.norm() - 0.7).abs() < 1e-6 && o.position.x > 0.0));
    // Said once; then it stands until another path comes.
    assert_eq!(answers.next(), Some(Steering::Drive(Twist::ZERO)));
}

#[test]
fn at_the_end_of_the_path_it_turns_to_its_heading_and_arrives() {
    let mut situation = Situation::new(&PotentialFieldParams::default(), pioneer(), ahead(Some(-1.0)));
    let clear = |now: Time| Some(scan(7.0, now, true));
    let Ok(Steering::Drive(twist)) = situation.steer(pose2(4.5, 0.0, 0.0), clear) else { panic!() };
    assert!(twist.forward_m_s == 0.0 && twist.turn_rad_s < 0.0);
    // Also when it was pushed a little out of the radius.
    assert!(matches!(situation.steer(pose2(4.4, 0.0, -0.5), clear), Ok(Steering::Drive(_))));
    assert_eq!(situation.steer(pose2(4.4, 0.0, -0.99), clear), Ok(Steering::Arrived));
    let mut free = Situation::new(&PotentialFieldParams::default(), pioneer(), ahead(None));
    assert_eq!(free.steer(pose2(4.5, 0.0, 3.0), clear), Ok(Steering::Arrived));
}

#[test]
fn it_steers_two_driven_wheels_and_nothing_else() {
    let robot = Robot { drive: rumbo_core::robot::Drive::Omnidirectional {}, ..pioneer() };
    assert!(PotentialField::new(&PotentialFieldParams::default(), &robot).is_none());
}
