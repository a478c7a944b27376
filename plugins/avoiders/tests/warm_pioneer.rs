//! A warm control step of the avoiders that see everything near allocates nothing.
#![allow(clippy::unwrap_used, clippy::panic)]

use rumbo_avoiders::braitenberg::{Braitenberg, BraitenbergParams};
use rumbo_avoiders::potential_field::{PotentialField, PotentialFieldParams};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Path, PointCloud, Seen, SensorId};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidInput, Avoider, Cx, Steering};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;

/// A scan ahead and a cloud around it whose things come and go.
fn seen(stamp: Time, step: usize) -> [Observation; 2] {
    let range = |beam: usize| 0.6 + 2.0 * (0.05 * beam as f64 + 0.11 * step as f64).sin().abs();
    let scan = LaserScan {
        first_bearing_rad: -0.5,
        bearing_step_rad: 0.01,
        max_range_m: 8.0,
        ranges_m: (0..101).map(|beam| range(beam) as f32).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    };
    let point = |k: usize| {
        let (bearing, distance) = (0.004 * k as f64 - 0.5, range(k));
        [(distance * bearing.cos()) as f32, (distance * bearing.sin()) as f32, 0.2]
    };
    let cloud = PointCloud { points_m: Buffer::from((0..250).map(point).collect::<Vec<_>>()) };
    [(0, Data::LaserScan(scan)), (1, Data::PointCloud(cloud))].map(|(sensor, data)| {
        let sensor = SensorId(sensor);
        Observation { sensor, stamp, base_from_sensor: Pose3::identity(), valid: true, data }
    })
}

fn allocates_nothing(avoider: &mut dyn Avoider, robot: &Robot) {
    let (map, trace) = (Map::default(), Trace::unwatched());
    let path = Path::through((0..40).map(|k| Point2::new(0.5 * f64::from(k), 0.3)), 0.0);
    let (mut pose, mut now) = (Pose2::identity(), Time::ZERO);
    let mut most_m_s = 0f64;
    for step in 0..400 {
        let seen = seen(now, step);
        let estimate = Estimate::planar(now, pose, pose, nalgebra::Matrix3::zeros());
        let input = AvoidInput {
            map_from_base: pose,
            estimate: &estimate,
            twist: Twist::ZERO,
            seen: Seen::sorted(&seen),
            map: &map,
            grid: None,
            path: path.as_ref(),
            path_number: 1,
            arrival_radius_m: 0.1,
            obstacles: &[],
            robot,
        };
        let mut answer = None;
        let counted = allocation_counter::measure(|| {
            answer = Some(avoider.steer(&mut Cx { now, trace: &trace }, &input));
        });
        let Steering::Drive(twist) = answer.unwrap().unwrap() else { panic!("step {step}") };
        if step > 1 {
            assert_eq!(counted.count_total, 0, "step {step}");
        }
        most_m_s = most_m_s.max(twist.forward_m_s);
        pose *= twist.integrate(0.05);
        now = now + Span::from_secs(0.05);
    }
    assert!(most_m_s > 0.1, "it never drove");
}

#[test]
fn a_warm_step_allocates_nothing() {
    let robot = Robot::default();
    allocates_nothing(&mut PotentialField::new(&PotentialFieldParams::default(), &robot).unwrap(), &robot);
    allocates_nothing(&mut Braitenberg::new(&BraitenbergParams::default(), &robot).unwrap(), &robot);
}
