//! Laws of localizers and avoiders.

use crate::text_world::text_world;
use crate::{entries, twins};
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2};
use rumbo_core::messages::*;
use rumbo_core::registry::Stage;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidInput, Avoider, BuildContext, Cx, Localizer, Steering};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

fn prior(x: f64, y: f64, yaw: f64) -> Prior {
    Prior::Pose {
        map_from_base: pose2(x, y, yaw),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::identity() * 1e-3,
    }
}

fn odometry(k: i64) -> Observation {
    let odom_from_base = pose2(0.01 * k as f64, 0.0, 0.001 * k as f64);
    Observation {
        sensor: SensorId(0),
        stamp: Time(k * 50_000_000),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::Odometry(Odometry { odom_from_base, twist: Twist::new(0.2, 0.02), noise: [0.02; 3] }),
    }
}

fn scan(stamp: Time, range_m: f32) -> Observation {
    let scan = LaserScan {
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: std::f64::consts::PI / 180.0,
        max_range_m: 8.0,
        ranges_m: Buffer::filled(181, range_m),
        ..LaserScan::default()
    };
    let data = Data::LaserScan(scan);
    Observation { sensor: SensorId(1), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

const ROOM: &str = "
    ####################
    #..................#
    #..................#
    #...S..............#
    #..................#
    #..............G...#
    #..................#
    ####################";

#[test]
fn a_localizer_gives_finite_estimates_and_the_same_ones_twice() {
    for entry in entries(Stage::Localizer) {
        let (mut one, mut other): (Box<dyn Localizer>, Box<dyn Localizer>) =
            twins(&entry, &BuildContext::bare("localizer"));
        let world = text_world(0.5, ROOM);
        let trace = Trace::unwatched();
        let drive = |localizer: &mut Box<dyn Localizer>| {
            localizer.start(&prior(2.0, 2.0, 0.5), &world.map).unwrap_or_else(|e| panic!("{entry:?}: {e}"));
            let mut estimates = Vec::new();
            for k in 0..40 {
                let seen = [odometry(2 * k), odometry(2 * k + 1)];
                let mut cx = Cx { now: seen[1].stamp, trace: &trace };
                let estimate = localizer.update(&mut cx, Seen::sorted(&seen), &world.map);
                let estimate = estimate.unwrap_or_else(|e| panic!("{entry:?}: {e}"));
                assert_eq!(estimate.check(), Ok(()), "{entry:?}");
                assert!(estimate.stamp <= cx.now, "{entry:?} knows the future");
                estimates.push(estimate);
            }
            estimates
        };
        let first = drive(&mut one);
        assert_eq!(first, drive(&mut other), "{entry:?}");
        assert_eq!(first, drive(&mut one), "{entry:?} remembers the run before");
    }
}

#[test]
fn a_localizer_survives_an_update_with_nothing_new() {
    for entry in entries(Stage::Localizer) {
        let (mut localizer, _): (Box<dyn Localizer>, Box<dyn Localizer>) =
            twins(&entry, &BuildContext::bare("localizer"));
        let (world, trace) = (text_world(0.5, ROOM), Trace::unwatched());
        localizer.start(&prior(2.0, 2.0, 0.0), &world.map).unwrap();
        let estimate = localizer.update(&mut Cx { now: Time(1), trace: &trace }, Seen::NOTHING, &world.map);
        assert_eq!(estimate.unwrap_or_else(|e| panic!("{entry:?}: {e}")).check(), Ok(()), "{entry:?}");
    }
}

#[test]
fn an_avoider_is_finite_slow_enough_and_the_same_twice() {
    for entry in entries(Stage::Avoider) {
        let (mut one, mut other): (Box<dyn Avoider>, Box<dyn Avoider>) =
            twins(&entry, &BuildContext::bare("avoider"));
        let world = text_world(0.5, ROOM);
        let (robot, trace) = (Robot::default(), Trace::unwatched());
        let path = Path::through([world.start.translation.vector.into(), world.goal.position], 0.0).unwrap();
        let drive = |avoider: &mut Box<dyn Avoider>| {
            let (mut pose, mut commands) = (world.start, Vec::new());
            for k in 0..3000 {
                let now = Time(k * 100_000_000);
                let seen = [scan(now, 6.0)];
                let estimate = Estimate::planar(now, pose, pose, Matrix3::identity() * 1e-4);
                let input = AvoidInput {
                    map_from_base: pose,
                    estimate: &estimate,
                    twist: commands.last().copied().unwrap_or(Twist::ZERO),
                    seen: Seen::sorted(&seen),
                    map: &world.map,
                    grid: world.map.grid.as_ref(),
                    path: Some(&path),
                    path_number: 1,
                    arrival_radius_m: 0.1,
                    obstacles: &[],
                    robot: &robot,
                };
                match avoider.steer(&mut Cx { now, trace: &trace }, &input) {
                    Ok(Steering::Drive(twist)) => {
                        assert!(twist.is_finite(), "{entry:?}: {twist:?}");
                        pose *= twist.integrate(0.1);
                        commands.push(twist);
                    }
                    Ok(Steering::Arrived) => return (pose, commands),
                    other => panic!("{entry:?} at {pose}: {other:?}"),
                }
            }
            panic!("{entry:?} never arrived, stands at {pose}");
        };
        let (end, commands) = drive(&mut one);
        assert!(
            (end.translation.vector - world.goal.position.coords).norm() <= 0.1,
            "{entry:?} says arrived at {end}"
        );
        assert_eq!(commands, drive(&mut other).1, "{entry:?}");
    }
}

#[test]
fn an_avoider_without_a_path_needs_no_path() {
    for entry in entries(Stage::Avoider) {
        let (mut avoider, _): (Box<dyn Avoider>, Box<dyn Avoider>) =
            twins(&entry, &BuildContext::bare("avoider"));
        let (world, robot, trace) = (text_world(0.5, ROOM), Robot::default(), Trace::unwatched());
        let estimate =
            Estimate::planar(Time::ZERO, world.start, Pose2::identity(), Matrix3::identity() * 1e-4);
        let seen = [scan(Time::ZERO, 6.0)];
        let input = AvoidInput {
            map_from_base: world.start,
            estimate: &estimate,
            twist: Twist::ZERO,
            seen: Seen::sorted(&seen),
            map: &world.map,
            grid: world.map.grid.as_ref(),
            path: None,
            path_number: 0,
            arrival_radius_m: 0.1,
            obstacles: &[],
            robot: &robot,
        };
        let steering = avoider.steer(&mut Cx { now: Time::ZERO, trace: &trace }, &input);
        assert!(
            matches!(steering, Ok(Steering::Drive(twist)) if twist.is_finite()),
            "{entry:?}: {steering:?}"
        );
    }
}
