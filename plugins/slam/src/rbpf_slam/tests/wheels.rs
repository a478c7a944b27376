//! Wheels that say what is not so: scans know better.

use super::hall::{Drive, apart, lane, observation, tracker, update};
use crate::rbpf_slam::RbpfSlamParams;
use crate::rbpf_slam::tracker::Tracker;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::{Data, Imu, Observation, Odometry, Status};
use rumbo_core::time::Time;

const SCAN_M: f64 = 0.138;

/// Drives to the 40th scan with wheels that err little, and then so many scans with wheels of one's own.
fn drive_on(
    seed: u64,
    n: u32,
    pose: impl Fn(u32) -> Pose2,
    before_from_after: impl Fn(u32) -> Pose2,
) -> Tracker {
    let params = RbpfSlamParams { particles: 8, ..RbpfSlamParams::default() };
    let (mut tracker, mut drive) = (tracker(&params, seed), Drive::new(seed));
    for k in 0..40 {
        let seconds = 0.1 * f64::from(k);
        let seen = drive.seen(seconds, &lane(SCAN_M * f64::from(k)));
        update(&mut tracker, seconds, &seen);
    }
    for k in 0..n {
        let (seconds, at) = (0.1 * f64::from(40 + k), pose(k));
        drive.odom_from_base *= before_from_after(k);
        let odometry = Odometry { odom_from_base: drive.odom_from_base, ..Odometry::default() };
        let scan = drive.hall.scan(&at, &mut drive.rng);
        let seen =
            [observation(seconds, Data::Odometry(odometry)), observation(seconds, Data::LaserScan(scan))];
        update(&mut tracker, seconds, &seen);
        let estimate = tracker.estimate(Time::from_secs(seconds));
        let [off_m, off_deg] = apart(&at, &estimate.pose2());
        assert!(off_m < 0.15 && off_deg < 3.0, "{seconds} s: {off_m} m, {off_deg} degrees");
    }
    tracker
}

fn is_tracking_after(tracker: &Tracker, n: u32) -> bool {
    tracker.estimate(Time::from_secs(0.1 * f64::from(39 + n))).status == Status::Tracking
}

#[test]
fn wheels_that_spin_in_place_move_nobody() {
    let here = lane(SCAN_M * 39.0);
    let tracker = drive_on(11, 60, |_| here, |_| pose2(0.1, 0.0, 0.0));
    assert!(is_tracking_after(&tracker, 60));
}

#[test]
fn an_odometer_that_says_forward_of_a_robot_that_goes_back_is_not_believed() {
    let pose = |k: u32| lane(SCAN_M * f64::from(39 - k.min(35)));
    let tracker = drive_on(12, 35, pose, |_| pose2(SCAN_M, 0.0, 0.0));
    assert!(is_tracking_after(&tracker, 35));
}

#[test]
fn a_turn_that_the_wheels_have_not_seen_is_found_by_the_scan() {
    for side in [-1.0, 1.0] {
        let here = lane(SCAN_M * 39.0);
        // 15 degrees from one scan to the next, three times.
        let pose = |k: u32| here * pose2(0.0, 0.0, side * f64::from(15 * k.min(3)).to_radians());
        let tracker = drive_on(13, 12, pose, |_| Pose2::identity());
        assert!(is_tracking_after(&tracker, 12), "{side}");
    }
}

/// Turns by 50 degrees from scan to scan, which the wheels do not see and a unit that hangs head down does; the largest
/// error of the heading, degrees.
fn turned_fast(has_unit: bool) -> f64 {
    let params = RbpfSlamParams { particles: 8, ..RbpfSlamParams::default() };
    let (mut tracker, mut drive) = (tracker(&params, 14), Drive::new(14));
    let here = lane(SCAN_M * 39.0);
    let mut worst = 0f64;
    for k in 0u32..48 {
        let seconds = 0.1 * f64::from(k);
        let turns = f64::from(k.saturating_sub(40).min(4));
        let at = if k < 40 {
            lane(SCAN_M * f64::from(k))
        } else {
            here * pose2(0.0, 0.0, turns * 50f64.to_radians())
        };
        let rate_rad_s =
            if (41..45).contains(&k) { 500f64.to_radians() } else { drive.turn_since(&at) / 0.1 };
        let mut seen = Vec::new();
        for part in (1..=5u32).filter(|_| has_unit) {
            let imu = Imu { rates_rad_s: [0.0, 0.0, -rate_rad_s], ..Imu::default() };
            let base_from_sensor = Pose3::rotation(nalgebra::Vector3::x() * std::f64::consts::PI);
            let stamp_s = seconds - 0.1 + 0.02 * f64::from(part);
            seen.push(Observation { base_from_sensor, ..observation(stamp_s, Data::Imu(imu)) });
        }
        if k < 40 {
            seen.extend(drive.seen(seconds, &at));
        } else {
            let odometry = Odometry { odom_from_base: drive.odom_from_base, ..Odometry::default() };
            seen.push(observation(seconds, Data::Odometry(odometry)));
            seen.push(observation(seconds, Data::LaserScan(drive.hall.scan(&at, &mut drive.rng))));
            drive.last = at;
        }
        update(&mut tracker, seconds, &seen);
        worst = worst.max(apart(&at, &tracker.estimate(Time::from_secs(seconds)).pose2())[1]);
    }
    worst
}

#[test]
fn a_turn_that_only_the_gyroscope_has_seen_is_followed() {
    let (with_unit, without) = (turned_fast(true), turned_fast(false));
    assert!(with_unit < 2.0, "{with_unit} degrees");
    assert!(without > 20.0, "{without} degrees: the scans alone find such a turn, and prove nothing");
}
