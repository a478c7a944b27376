//! The plugin as the framework uses it; the filter has its own tests.

use super::EkfLineSlamParams;
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, LaserScan, Observation, Odometry, Prior, Seen, SensorId};
use rumbo_core::registry::{Params, Plugin, Registry, Stage};
use rumbo_core::robot::{Drive, Robot, SteeredWheel};
use rumbo_core::stages::{BuildContext, Cx, Slam, SlamError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::line_filter::Integration;

fn built(params: &EkfLineSlamParams) -> Box<dyn Slam> {
    params.build(&BuildContext::bare("slam")).unwrap()
}

fn at(map_from_base: Pose2) -> Prior {
    Prior::Pose { map_from_base, odom_from_base: Pose2::identity(), covariance: Matrix3::identity() * 1e-6 }
}

/// Odometry and a scan of a room of 9 m x 6 m around the robot.
fn seen(seconds: f64, start: Pose2) -> Vec<Observation> {
    let odom_from_base = Twist::new(0.3, 0.1).integrate(seconds);
    let (place, yaw) = {
        let pose = start * odom_from_base;
        (pose.translation.vector, pose.rotation.angle())
    };
    let range = |k: usize| {
        let (sin, cos) = (yaw + (k as f64).to_radians()).sin_cos();
        let x_m = if cos > 0.0 { (5.0 - place.x) / cos } else { (-4.0 - place.x) / cos };
        let y_m = if sin > 0.0 { (3.0 - place.y) / sin } else { (-3.0 - place.y) / sin };
        x_m.abs().min(y_m.abs()) as f32
    };
    let scan = LaserScan {
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..360).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    };
    let data = [Data::Odometry(Odometry { odom_from_base, ..Odometry::default() }), Data::LaserScan(scan)];
    let stamp = Time::from_secs(seconds);
    let observation = |data| Observation {
        sensor: SensorId(0),
        stamp,
        base_from_sensor: Pose3::identity(),
        valid: true,
        data,
    };
    data.into_iter().map(observation).collect()
}

#[test]
fn the_layer_has_the_walls_of_the_room_and_its_version_goes_up() {
    let start = pose2(1.0, -1.0, 0.5);
    let (mut slam, mut map) = (built(&EkfLineSlamParams::default()), Map::default());
    slam.start(&at(start), &mut map).unwrap();
    assert!(map.lines.as_ref().is_some_and(|lines| lines.lines.is_empty()));
    let trace = Trace::counting();
    for k in 0..50 {
        let seconds = 0.1 * f64::from(k);
        let before = map.version;
        let mut cx = Cx { now: Time::from_secs(seconds), trace: &trace };
        let estimate = slam.update(&mut cx, Seen::sorted(&seen(seconds, start)), &mut map).unwrap();
        assert!(map.version > before);
        let off = (start * Twist::new(0.3, 0.1).integrate(seconds)).inverse() * estimate.pose2();
        assert!(off.translation.vector.norm() < 0.01, "{seconds}: {off}");
    }
    let lines = map.lines.unwrap().lines;
    assert_eq!(lines.len(), 4, "{lines:?}");
    for line in lines.iter() {
        let middle = [(line.from[0] + line.to[0]) / 2.0, (line.from[1] + line.to[1]) / 2.0];
        let is_wall = (middle[0] - 5.0).abs() < 0.01
            || (middle[0] + 4.0).abs() < 0.01
            || (middle[1] - 3.0).abs() < 0.01
            || (middle[1] + 3.0).abs() < 0.01;
        assert!(is_wall, "{line:?}");
        // The wall is to the left of its way, the robot to the right.
        let (dx, dy) = (line.to[0] - line.from[0], line.to[1] - line.from[1]);
        assert!(dx * (-1.0 - line.from[1]) - dy * (1.0 - line.from[0]) < 0.0, "{line:?}");
    }
    let (_, counters) = trace.take();
    assert!(counters.contains(&("walls", 4.0)), "{counters:?}");
}

#[test]
fn what_it_has_saved_is_a_start_and_nothing_else_is() {
    let start = pose2(1.0, -1.0, 0.5);
    let (mut slam, mut map) = (built(&EkfLineSlamParams::default()), Map::default());
    assert!(matches!(slam.save(), Err(SlamError::Other(_))), "there is nothing to save");
    slam.start(&at(start), &mut map).unwrap();
    let trace = Trace::unwatched();
    let update = |slam: &mut Box<dyn Slam>, map: &mut Map, k: i32| {
        let seconds = 0.1 * f64::from(k);
        let mut cx = Cx { now: Time::from_secs(seconds), trace: &trace };
        slam.update(&mut cx, Seen::sorted(&seen(seconds, start)), map).unwrap()
    };
    (0..20).for_each(|k| {
        update(&mut slam, &mut map, k);
    });
    let saved = slam.save().unwrap();
    let (mut other, mut other_map) = (built(&EkfLineSlamParams::default()), Map::default());
    other.start(&Prior::Saved(Buffer::from(saved.clone())), &mut other_map).unwrap();
    assert_eq!(other_map.lines, map.lines, "the map is there before the first reading");
    let off =
        update(&mut slam, &mut map, 20).pose2().inverse() * update(&mut other, &mut other_map, 20).pose2();
    assert!(off.translation.vector.norm() < 1e-12, "{off}");
    let mut damaged = saved;
    damaged[100] ^= 1;
    let refused = other.start(&Prior::Saved(Buffer::from(damaged)), &mut other_map).unwrap_err();
    assert!(refused.to_string().contains("damaged"), "{refused}");
    assert!(matches!(other.start(&Prior::Unknown, &mut other_map), Err(SlamError::Prior { .. })));
}

#[test]
fn all_faults_of_the_keys_are_told() {
    assert!(EkfLineSlamParams::default().check().is_empty());
    let mut params = EkfLineSlamParams {
        gate: -1.0,
        sigma_linear_acceleration: f64::NAN,
        confirm_hits: 0,
        bootstrap_length_m: f64::INFINITY,
        ..EkfLineSlamParams::default()
    };
    params.extraction.min_points = 1;
    params.noise.range_m = 0.0;
    params.periods.laser_s = 0.5;
    let paths: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "sigma_linear_acceleration",
        "gate",
        "noise.range_m",
        "extraction.min_points",
        "periods.wheels_s",
        "periods.steering_s",
        "confirm_hits",
        "bootstrap_length_m",
    ];
    assert_eq!(paths, expected);
}

#[test]
fn keys_and_robot_become_the_filters_numbers() {
    let tricycle = |steered| {
        let (wheelbase_m, track_m, max_steer_deg, max_steer_rate_deg_s) = (1.3, 0.9, 60.0, 90.0);
        let drive = Drive::Tricycle { wheelbase_m, track_m, max_steer_deg, max_steer_rate_deg_s, steered };
        Robot { drive, ..Robot::default() }
    };
    let params = EkfLineSlamParams {
        integration: Integration::Euler,
        max_gap_m: 0.7,
        merge: true,
        ..EkfLineSlamParams::default()
    };
    let filter = params.shared().tracker_settings(&tricycle(SteeredWheel::Rear), params.growth()).filter;
    assert_eq!((filter.wheels.half_track_m, filter.steering.behind_m), (0.45, 1.3));
    assert_eq!((filter.gates.gap_m, filter.growth.gap_m, filter.growth.merge), (0.7, 0.7, true));
    assert_eq!(filter.motion.integration, Integration::Euler);
    let front = EkfLineSlamParams::default();
    let filter = front.shared().tracker_settings(&tricycle(SteeredWheel::Front), front.growth()).filter;
    assert_eq!(filter.steering.behind_m, -1.3);
    assert!(Registry::linked().unwrap().get(Stage::Slam, "ekf_line_slam").is_some());
}
