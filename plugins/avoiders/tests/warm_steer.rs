//! A warm control step of an avoider allocates nothing.
#![allow(clippy::unwrap_used, clippy::panic)]

use rumbo_avoiders::stop_and_replan::{StopAndReplan, StopAndReplanParams};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Path, Seen, SensorId};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidInput, Avoider, Cx, Steering};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;

/// A corridor whose walls come into reach and leave it again.
fn scan(stamp: Time, step: usize) -> Observation {
    let half_width_m = 0.45 + 0.3 * (step as f64 * 0.37).sin().abs();
    let range = |beam: i32| half_width_m / (f64::from(beam - 180) * 0.5).to_radians().sin().abs().max(0.01);
    let ranges: Vec<f32> = (0..=360).map(|beam| range(beam) as f32).collect();
    let data = Data::LaserScan(LaserScan {
        first_bearing_rad: -90f64.to_radians(),
        bearing_step_rad: 0.5f64.to_radians(),
        max_range_m: 8.0,
        ranges_m: Buffer::from(ranges),
        ..LaserScan::default()
    });
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

#[test]
fn a_warm_steer_allocates_nothing_on_turns_straights_and_new_paths() {
    let corners = [[-0.15, -0.2], [0.25, -0.2], [0.25, 0.2], [-0.15, 0.2]];
    let robot = Robot { footprint_m: corners.to_vec(), ..Robot::default() };
    let mut avoider = StopAndReplan::new(&StopAndReplanParams::default(), &robot, 10.0);
    let (map, grid, trace) = (Map::default(), Grid::unknown(100, 100, 0.05).unwrap(), Trace::unwatched());
    let path = |k: usize| {
        let side = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        Path::through((0..40).map(|i| Point2::new(0.05 * i as f64, 0.03 * side * i as f64)), 0.0).unwrap()
    };
    let paths: Vec<Path> = (0..5).map(path).collect();
    let (mut pose, mut twist, mut now) = (Pose2::identity(), Twist::ZERO, Time::ZERO);
    let mut moved = [false; 2];
    for step in 0..600 {
        let seen = [scan(now, step)];
        let estimate = Estimate::planar(now, pose, pose, nalgebra::Matrix3::zeros());
        let input = AvoidInput {
            map_from_base: pose,
            estimate: &estimate,
            twist,
            seen: Seen::sorted(&seen),
            map: &map,
            grid: Some(&grid),
            path: Some(&paths[step / 120]),
            path_number: step as u64 / 120,
            arrival_radius_m: 0.1,
            obstacles: &[],
            robot: &robot,
        };
        let mut answer = None;
        let counted = allocation_counter::measure(|| {
            answer = Some(avoider.steer(&mut Cx { now, trace: &trace }, &input));
        });
        match answer.unwrap().unwrap() {
            Steering::Drive(wanted) => twist = wanted,
            Steering::Blocked { .. } => panic!("blocked in step {step}"),
            _ => twist = Twist::ZERO,
        }
        if step > 1 {
            assert_eq!(counted.count_total, 0, "step {step}");
            moved[usize::from(twist.forward_m_s > 0.0)] |= twist != Twist::ZERO;
        }
        pose *= twist.integrate(0.1);
        now = now + Span::from_secs(0.1);
    }
    assert_eq!(moved, [true; 2], "the robot turned and drove");
}
