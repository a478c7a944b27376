//! Observations of the framework become readings of the filter.

use super::close;
use crate::line_filter::*;
use crate::lines::LineSettings;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, lift, pose2};
use rumbo_core::map::Line;
use rumbo_core::messages::{
    Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status, SteeringAngle,
    WheelSpeeds,
};
use rumbo_core::robot::{Drive, SteeredWheel};
use rumbo_core::time::{Span, Time};

const TRICYCLE: Drive = Drive::Tricycle {
    wheelbase_m: 1.3,
    track_m: 0.9,
    max_steer_deg: 80.0,
    max_steer_rate_deg_s: 90.0,
    steered: SteeredWheel::Front,
};

fn settings() -> TrackerSettings {
    let steering = Steering { behind_m: -1.3, ..Steering::default() };
    TrackerSettings {
        filter: FilterSettings { steering, ..FilterSettings::default() },
        lines: LineSettings::default(),
        drive: TRICYCLE,
        start_motion: [0.5, 0.5],
        clock: Clock::new(Span::from_secs(0.1)),
        look_every: [0.0; 2],
        odometer: OdometerNoise::default(),
        lost_after_scans: 5,
    }
}

fn at(pose: Pose2) -> Prior {
    Prior::Pose {
        map_from_base: pose,
        odom_from_base: pose2(3.0, -1.0, 0.4),
        covariance: Matrix3::identity() * 1e-6,
    }
}

fn observation(seconds: f64, base_from_sensor: Pose3, data: Data) -> Observation {
    Observation { sensor: SensorId(0), stamp: Time::from_secs(seconds), base_from_sensor, valid: true, data }
}

fn odometry(seconds: f64, odom_from_base: Pose2) -> Observation {
    observation(
        seconds,
        Pose3::identity(),
        Data::Odometry(Odometry { odom_from_base, ..Odometry::default() }),
    )
}

/// A room from (-4, -3) to (5, 3).
fn room() -> Vec<Line> {
    let corners = [[-4.0, -3.0], [-4.0, 3.0], [5.0, 3.0], [5.0, -3.0]];
    (0..4).map(|k| Line { from: corners[k], to: corners[(k + 1) % 4], covariance: [0.0; 3] }).collect()
}

/// What a laser that looks all around sees of the room.
fn scan(seconds: f64, map_from_base: Pose2, base_from_sensor: Pose2) -> Observation {
    let map_from_sensor = map_from_base * base_from_sensor;
    let (place, yaw) = (map_from_sensor.translation.vector, map_from_sensor.rotation.angle());
    let range = |k: usize| {
        let (sin, cos) = (yaw + (k as f64).to_radians()).sin_cos();
        let x_m = if cos > 0.0 { (5.0 - place.x) / cos } else { (-4.0 - place.x) / cos };
        let y_m = if sin > 0.0 { (3.0 - place.y) / sin } else { (-3.0 - place.y) / sin };
        x_m.abs().min(y_m.abs()) as f32
    };
    let scan = LaserScan {
        first_bearing_rad: 0.0,
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..360).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    };
    observation(seconds, lift(&base_from_sensor), Data::LaserScan(scan))
}

fn update(tracker: &mut LineTracker, seconds: f64, seen: &[Observation]) -> Result<Estimate, TrackFault> {
    tracker.update(Time::from_secs(seconds), Seen::sorted(seen))
}

const TWIST: Twist = Twist { forward_m_s: 0.6, left_m_s: 0.0, turn_rad_s: 0.2 };

/// The room driven through for four seconds; `wheels` makes what they say from the time.
fn drive(
    tracker: &mut LineTracker,
    start: Pose2,
    sensor: Pose2,
    wheels: impl Fn(f64) -> Vec<Observation>,
) -> f64 {
    let mut worst_m: f64 = 0.0;
    for k in 0..80 {
        let seconds = 0.05 * f64::from(k);
        let truth = start * TWIST.integrate(seconds);
        let mut seen = wheels(seconds);
        if k % 4 == 0 {
            seen.push(scan(seconds, truth, sensor));
        }
        let estimate = update(tracker, seconds, &seen).unwrap();
        if k % 4 == 0 {
            assert_eq!(estimate.stamp, Time::from_secs(seconds));
            let off_m = (estimate.pose2().translation.vector - truth.translation.vector).norm();
            worst_m = worst_m.max(off_m);
        }
    }
    worst_m
}

#[test]
fn a_map_is_built_and_followed_with_wheels_or_with_an_odometer_from_any_mount() {
    let start = pose2(-1.0, -1.0, 0.3);
    let odom_start = pose2(3.0, -1.0, 0.4);
    let speeds = |seconds| {
        let rim_m_s = [-9.0, 0.6 - 0.2 * 0.45, 0.6 + 0.2 * 0.45, 0.0];
        let wheels = Data::WheelSpeeds(WheelSpeeds { n_wheels: 3, rim_m_s });
        let angle_rad = (1.3f64 * 0.2 / 0.6).atan();
        let steering = Data::SteeringAngle(SteeringAngle { angle_rad });
        vec![
            observation(seconds, Pose3::identity(), wheels),
            observation(seconds, Pose3::identity(), steering),
        ]
    };
    let odometer = |seconds: f64| vec![odometry(seconds, odom_start * TWIST.integrate(seconds))];
    for sensor in [Pose2::identity(), pose2(0.5, -0.2, 2.0)] {
        for has_wheels in [true, false] {
            let wheels = |seconds: f64| if has_wheels { speeds(seconds) } else { odometer(seconds) };
            let mut slam = LineTracker::new(settings());
            slam.build_map(&at(start)).unwrap();
            let worst_m = drive(&mut slam, start, sensor, wheels);
            assert!(worst_m < 0.01, "{worst_m} {has_wheels}");
            assert_eq!(slam.filter().unwrap().walls().len(), 4);
            assert_eq!((slam.n_scans(), slam.left_out()), (20, LeftOut::default()));
            // What it has built is a map to follow.
            let map = WallMap::new(&slam.filter().unwrap().layer());
            let mut localizer = LineTracker::new(settings());
            localizer.follow(&at(start), &map).unwrap();
            let worst_m = drive(&mut localizer, start, sensor, wheels);
            assert!(worst_m < 0.01, "on the map: {worst_m} {has_wheels}");
        }
    }
}

#[test]
fn walls_are_where_they_are_and_face_the_robot() {
    let start = pose2(-1.0, -1.0, 0.3);
    let mut tracker = LineTracker::new(settings());
    tracker.build_map(&at(start)).unwrap();
    update(&mut tracker, 0.0, &[scan(0.0, start, pose2(0.3, 0.1, -1.0))]).unwrap();
    let filter = tracker.filter().unwrap();
    for expected in room() {
        let found = filter.layer().into_iter().find(|line| {
            let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            apart(line.from, expected.from) < 0.5 && apart(line.to, expected.to) < 0.5
        });
        assert!(found.is_some(), "{expected:?} in {:?}", filter.layer());
    }
}

#[test]
fn the_odometers_mean_speed_is_that_of_an_arc() {
    let mut tracker = LineTracker::new(settings());
    tracker.build_map(&at(Pose2::identity())).unwrap();
    for k in 0..200 {
        let seconds = 0.1 * f64::from(k);
        let odom_from_base = pose2(7.0, 7.0, 3.0) * Twist::new(-0.5, 0.9).integrate(seconds);
        update(&mut tracker, seconds, &[odometry(seconds, odom_from_base)]).unwrap();
    }
    let robot = tracker.filter().unwrap().state().robot;
    close(robot[3], -0.5, 1e-6, "speed");
    close(robot[4], 0.9, 1e-6, "turn");
    assert!(tracker.left_out().slipping == 0);
}

#[test]
fn the_odometers_frame_stays_where_the_prior_put_it() {
    let start = pose2(-1.0, -1.0, 0.3);
    let odom_start = pose2(3.0, -1.0, 0.4);
    let mut tracker = LineTracker::new(settings());
    tracker.build_map(&at(start)).unwrap();
    let expected = start * odom_start.inverse();
    for k in 0..40 {
        let seconds = 0.05 * f64::from(k);
        let way = TWIST.integrate(seconds);
        let seen = [odometry(seconds, odom_start * way), scan(seconds, start * way, Pose2::identity())];
        let estimate = update(&mut tracker, seconds, &seen).unwrap();
        let found = rumbo_core::frames::flatten(&estimate.map_from_odom);
        let off = found.inverse() * expected;
        assert!(off.translation.vector.norm() < 0.02 && off.rotation.angle().abs() < 0.01, "{off}");
    }
}

#[test]
fn late_scans_are_dropped_and_counted() {
    let mut tracker = LineTracker::new(settings());
    tracker.build_map(&at(Pose2::identity())).unwrap();
    update(&mut tracker, 1.0, &[scan(1.0, Pose2::identity(), Pose2::identity())]).unwrap();
    update(&mut tracker, 1.3, &[scan(0.89, Pose2::identity(), Pose2::identity())]).unwrap();
    assert_eq!((tracker.left_out().late, tracker.n_scans()), (1, 1));
    update(&mut tracker, 1.3, &[scan(0.91, Pose2::identity(), Pose2::identity())]).unwrap();
    assert_eq!((tracker.left_out().late, tracker.n_scans()), (1, 2), "a hair late is taken as it is");
}

#[test]
fn a_long_gap_is_told_once_and_the_speed_is_forgotten() {
    let mut tracker = LineTracker::new(settings());
    tracker.build_map(&at(Pose2::identity())).unwrap();
    let moving = |seconds| {
        let wheels = WheelSpeeds { n_wheels: 2, rim_m_s: [0.5, 0.5, 0.0, 0.0] };
        observation(seconds, Pose3::identity(), Data::WheelSpeeds(wheels))
    };
    (0..20).for_each(|k| {
        update(&mut tracker, 0.05 * f64::from(k), &[moving(0.05 * f64::from(k))]).unwrap();
    });
    let before = tracker.filter().unwrap().state().robot;
    assert!(before[3] > 0.4);
    let fault = update(&mut tracker, 1e6, &[moving(1e6)]).unwrap_err();
    assert!(matches!(fault, TrackFault::Gap { .. }), "{fault}");
    let after = tracker.filter().unwrap().state().robot;
    assert_eq!((after[0], after[3]), (before[0], 0.0));
    update(&mut tracker, 1e6 + 0.05, &[moving(1e6 + 0.05)]).unwrap();
    assert!(tracker.filter().unwrap().state().robot[3] > 0.4, "and learned again at once");
}

#[test]
fn a_robot_that_sees_none_of_the_known_walls_is_lost_until_it_does() {
    let mut tracker = LineTracker::new(settings());
    tracker.follow(&at(Pose2::identity()), &WallMap::new(&room())).unwrap();
    let elsewhere = pose2(0.5, 0.7, 0.6);
    for k in 0..8 {
        let seconds = 0.1 * f64::from(k);
        let estimate = update(&mut tracker, seconds, &[scan(seconds, elsewhere, Pose2::identity())]).unwrap();
        let expected = if k < 4 { Status::Tracking } else { Status::Lost };
        assert_eq!(estimate.status, expected, "{k}");
    }
    let estimate = update(&mut tracker, 0.8, &[scan(0.8, Pose2::identity(), Pose2::identity())]).unwrap();
    assert_eq!(estimate.status, Status::Tracking);
}

#[test]
fn what_it_cannot_start_from_is_named() {
    let mut tracker = LineTracker::new(settings());
    assert_eq!(update(&mut tracker, 0.0, &[]).unwrap_err(), TrackFault::NotStarted);
    assert!(tracker.save().is_none());
    assert!(matches!(tracker.build_map(&Prior::Unknown), Err(TrackFault::Prior { .. })));
    let saved = Prior::Saved(Buffer::from(b"nonsense".to_vec()));
    assert_eq!(tracker.build_map(&saved).unwrap_err(), TrackFault::Saved(SavedFault::Foreign));
    let map = WallMap::new(&room());
    for prior in [Prior::Unknown, saved] {
        assert!(matches!(tracker.follow(&prior, &map), Err(TrackFault::Prior { .. })));
    }
    let mut negative = Matrix3::identity();
    negative[(1, 1)] = -1.0;
    let place = Pose2::identity();
    let prior = Prior::Pose { map_from_base: place, odom_from_base: place, covariance: negative };
    assert!(matches!(tracker.build_map(&prior), Err(TrackFault::Message(_))));
    let sure = Prior::Pose { map_from_base: place, odom_from_base: place, covariance: Matrix3::zeros() };
    tracker.build_map(&sure).unwrap();
}

#[test]
fn a_saved_tracker_goes_on() {
    let start = pose2(-1.0, -1.0, 0.3);
    let seen = |k: i32| {
        let seconds = 0.05 * f64::from(k);
        let way = TWIST.integrate(seconds);
        [odometry(seconds, pose2(3.0, -1.0, 0.4) * way), scan(seconds, start * way, pose2(0.2, 0.0, 0.0))]
    };
    let mut tracker = LineTracker::new(settings());
    tracker.build_map(&at(start)).unwrap();
    (0..30).for_each(|k| {
        update(&mut tracker, 0.05 * f64::from(k), &seen(k)).unwrap();
    });
    let mut other = LineTracker::new(settings());
    other.build_map(&Prior::Saved(Buffer::from(tracker.save().unwrap()))).unwrap();
    for k in 30..40 {
        let seconds = 0.05 * f64::from(k);
        let estimates = [&mut tracker, &mut other].map(|one| update(one, seconds, &seen(k)).unwrap());
        // The odometer's heading is saved as an angle.
        let off = estimates[0].pose2().inverse() * estimates[1].pose2();
        assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle().abs() < 1e-12);
        assert!((estimates[0].covariance - estimates[1].covariance).amax() < 1e-15);
    }
    assert_eq!(other.filter().unwrap().walls().len(), 4);
}

#[test]
fn a_tracker_that_is_told_where_the_robot_is_keeps_its_walls_and_takes_another_clock_and_odometer() {
    let start = pose2(-1.0, -1.0, 0.3);
    let mut tracker = LineTracker::new(settings());
    assert_eq!(tracker.relocate(&at(start)).unwrap_err(), TrackFault::NotStarted);
    tracker.build_map(&at(start)).unwrap();
    for k in 0..30 {
        let seconds = 100.0 + 0.05 * f64::from(k);
        let way = TWIST.integrate(0.05 * f64::from(k));
        let seen =
            [odometry(seconds, pose2(3.0, -1.0, 0.4) * way), scan(seconds, start * way, Pose2::identity())];
        update(&mut tracker, seconds, &seen).unwrap();
    }
    let before = tracker.filter().unwrap().layer();
    assert!(matches!(tracker.relocate(&Prior::Unknown), Err(TrackFault::Prior { .. })));
    assert_eq!(tracker.filter().unwrap().layer(), before);
    // Carried to another place of the room, and told of it with an error of some centimeters; clock and odometer begin anew.
    let (elsewhere, told) = (pose2(0.6, 0.4, -1.2), pose2(0.65, 0.36, -1.17));
    let spread = Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.0025));
    let prior = Prior::Pose { map_from_base: told, odom_from_base: Pose2::identity(), covariance: spread };
    tracker.relocate(&prior).unwrap();
    assert_eq!(tracker.filter().unwrap().walls().len(), 4);
    let first = update(&mut tracker, 0.0, &[]).unwrap();
    assert!((first.covariance2() - spread).amax() < 1e-9);
    let mut estimate = first;
    for k in 0..40 {
        let seconds = 0.05 * f64::from(k);
        let way = TWIST.integrate(seconds);
        // Its first reading is far off, and says nothing of the way.
        let seen = [
            odometry(seconds, pose2(70.0, 9.0, 2.0) * way),
            scan(seconds, elsewhere * way, Pose2::identity()),
        ];
        estimate = update(&mut tracker, seconds, &seen).unwrap();
    }
    let off = (elsewhere * TWIST.integrate(0.05 * 39.0)).inverse() * estimate.pose2();
    assert!(off.translation.vector.norm() < 0.02 && off.rotation.angle().abs() < 0.01, "{off}");
    assert_eq!(tracker.filter().unwrap().walls().len(), 4, "the same walls, not others");
    let moved = |(before, after): (&Line, &Line)| {
        let [a, b] = [before.from, before.to];
        let c = [after.from[0] - a[0], after.from[1] - a[1]];
        let along = [b[0] - a[0], b[1] - a[1]];
        ((along[0] * c[1] - along[1] * c[0]) / along[0].hypot(along[1])).abs()
    };
    let worst = before.iter().zip(&tracker.filter().unwrap().layer()).map(moved).fold(0.0, f64::max);
    assert!(worst < 0.02, "a wall moved by {worst} m");
}
