//! What sensors should not do, and some do.

use super::hall::{BEAMS, Drive, apart, lane, observation, tracker, update};
use crate::rbpf_slam::RbpfSlamParams;
use crate::rbpf_slam::follower::Followed;
use crate::rbpf_slam::particle::{Doubt, KeyScan};
use crate::rbpf_slam::saved::save;
use crate::rbpf_slam::tracker::Tracker;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::{Check, Data, LaserScan, Observation, Odometry, Status};
use rumbo_core::registry::Params;
use rumbo_core::time::Time;
use rumbo_kit::scan_match::ScanPoints;

const SCAN_M: f64 = 0.138;

fn params() -> RbpfSlamParams {
    RbpfSlamParams { particles: 8, ..RbpfSlamParams::default() }
}

/// Drives so many scans.
fn driven(n: u32, seed: u64) -> (Tracker, Drive) {
    let (mut tracker, mut drive) = (tracker(&params(), seed), Drive::new(seed));
    for k in 0..n {
        let seconds = 0.1 * f64::from(k);
        let seen = drive.seen(seconds, &lane(SCAN_M * f64::from(k)));
        update(&mut tracker, seconds, &seen);
    }
    (tracker, drive)
}

fn spoil(seen: &mut [Observation], reading: f32) {
    for observation in seen {
        if let Data::LaserScan(scan) = &mut observation.data {
            scan.ranges_m = vec![reading; BEAMS].into();
        }
    }
}

fn off(tracker: &Tracker, seconds: f64, pose: &Pose2) -> [f64; 2] {
    let estimate = tracker.estimate(Time::from_secs(seconds));
    estimate.check().unwrap();
    apart(pose, &estimate.pose2())
}

#[test]
fn scans_without_readings_move_particles_by_the_odometer_and_decide_nothing() {
    for reading in [f32::NAN, f32::INFINITY] {
        let (mut tracker, mut drive) = driven(40, 1);
        let (tiles, resampled) = (tracker.filter().best().unwrap().map.clone(), tracker.counters().resampled);
        let weights = tracker.filter().weights();
        for k in 40..60 {
            let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * f64::from(k)));
            let mut seen = drive.seen(seconds, &pose);
            spoil(&mut seen, reading);
            update(&mut tracker, seconds, &seen);
            assert!(off(&tracker, seconds, &pose)[0] < 0.4, "{seconds}");
        }
        assert_eq!(tracker.counters().resampled, resampled);
        assert_eq!(tracker.filter().weights(), weights, "no weighing");
        let map = &tracker.filter().best().unwrap().map;
        let same = map.levels().iter().zip(tiles.levels());
        assert!(
            same.flat_map(|(a, b)| a.tiles().map(|(at, tile)| b.tile(at) == Some(tile))).all(|same| same)
        );
        let estimate = tracker.estimate(Time::from_secs(5.9));
        assert_eq!(estimate.status, Status::Lost, "20 scans in a row matched nothing");
    }
}

#[test]
fn readings_that_are_no_numbers_are_left_out_beam_by_beam() {
    let (mut tracker, mut drive) = driven(1, 2);
    for k in 1..60 {
        let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * f64::from(k)));
        let mut seen = drive.seen(seconds, &pose);
        if let Data::LaserScan(scan) = &mut seen[1].data {
            scan.ranges_m.make_mut().iter_mut().step_by(3).for_each(|range| *range = f32::NAN);
        }
        update(&mut tracker, seconds, &seen);
        assert!(off(&tracker, seconds, &pose)[0] < 0.12, "{seconds}");
    }
}

#[test]
fn a_tenth_of_the_scans_may_be_rubbish() {
    let (mut tracker, mut drive) = driven(30, 3);
    for k in 30..160 {
        let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * f64::from(k)));
        let mut seen = drive.seen(seconds, &pose);
        if k % 10 == 0 {
            spoil(&mut seen, 0.5 + 0.02 * (k % 70) as f32);
        }
        update(&mut tracker, seconds, &seen);
        assert!(off(&tracker, seconds, &pose)[0] < 0.25, "{seconds}: {:?}", off(&tracker, seconds, &pose));
    }
    assert_eq!(tracker.estimate(Time::from_secs(15.9)).status, Status::Tracking);
}

#[test]
fn stamps_that_do_not_rise_are_dropped_and_counted() {
    let (mut tracker, mut drive) = driven(20, 4);
    let saved = save(&tracker);
    let late = drive.seen(1.0, &lane(SCAN_M * 19.0));
    update(&mut tracker, 1.9, &late);
    assert!(tracker.counters().scans_dropped == 1 && tracker.counters().odometry_dropped == 1);
    assert!(save(&tracker) == saved, "nothing else changed");
}

#[test]
fn readings_that_cannot_be_are_refused() {
    let (mut tracker, _) = driven(20, 5);
    let before = tracker.estimate(Time::from_secs(1.9)).pose2();
    let bad_scan = LaserScan { max_range_m: f32::NAN, ranges_m: vec![1.0; 5].into(), ..LaserScan::default() };
    let bad_odometry = Odometry { odom_from_base: pose2(f64::NAN, 0.0, 0.0), ..Odometry::default() };
    let seen = [observation(2.0, Data::LaserScan(bad_scan)), observation(2.0, Data::Odometry(bad_odometry))];
    update(&mut tracker, 2.0, &seen);
    assert_eq!(tracker.counters().scans_dropped, 1);
    assert_eq!(tracker.counters().odometry_dropped, 1);
    assert!(apart(&before, &tracker.estimate(Time::from_secs(2.0)).pose2())[0] < 1e-9);
}

#[test]
fn a_robot_that_was_carried_away_says_that_it_is_lost_and_its_map_stays() {
    let (mut tracker, mut drive) = driven(60, 6);
    let tiles = tracker.filter().best().unwrap().map.clone();
    let mut is_lost = false;
    // Into another hall: a narrow one of which nothing is on the map.
    for k in 60..100 {
        let seconds = 0.1 * f64::from(k);
        let mut seen = drive.seen(seconds, &lane(SCAN_M * 59.0));
        spoil(&mut seen, 0.9);
        update(&mut tracker, seconds, &seen);
        is_lost |= tracker.estimate(Time::from_secs(seconds)).status == Status::Lost;
    }
    assert!(is_lost);
    let map = &tracker.filter().best().unwrap().map;
    assert_eq!(map.n_tiles(), tiles.n_tiles());
    // Somebody carries it back and says where it is.
    tracker.relocate(&lane(SCAN_M * 30.0), &(Matrix3::identity() * 1e-3));
    drive.last = lane(SCAN_M * 30.0);
    for k in 100..130 {
        let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * f64::from(k - 70)));
        let seen = drive.seen(seconds, &pose);
        update(&mut tracker, seconds, &seen);
    }
    assert_eq!(tracker.estimate(Time::from_secs(12.9)).status, Status::Tracking);
    assert!(
        off(&tracker, 12.9, &lane(SCAN_M * 59.0))[0] < 0.15,
        "{:?}",
        off(&tracker, 12.9, &lane(SCAN_M * 59.0))
    );
}

#[test]
fn half_a_minute_without_a_scanner_is_dead_reckoning_and_then_a_match() {
    let (mut tracker, mut drive) = driven(40, 7);
    let before = tracker.estimate(Time::from_secs(3.9));
    for k in 40..340 {
        let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * 39.0 + 0.01 * f64::from(k - 39)));
        let seen = drive.seen(seconds, &pose);
        update(&mut tracker, seconds, &seen[..1]);
    }
    let blind = tracker.estimate(Time::from_secs(33.9));
    assert_eq!(blind.status, Status::Converging);
    assert!(blind.covariance2().trace() > 2.0 * before.covariance2().trace());
    for k in 340..360 {
        let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * 39.0 + 0.01 * f64::from(k - 39)));
        let seen = drive.seen(seconds, &pose);
        update(&mut tracker, seconds, &seen);
    }
    let pose = lane(SCAN_M * 39.0 + 3.2);
    assert_eq!(tracker.estimate(Time::from_secs(35.9)).status, Status::Tracking);
    assert!(off(&tracker, 35.9, &pose)[0] < 0.15, "{:?}", off(&tracker, 35.9, &pose));
}

#[test]
fn an_odometer_that_jumps_is_counted_and_the_scan_says_where_the_robot_is() {
    let (mut tracker, mut drive) = driven(40, 8);
    drive.odom_from_base = pose2(-80.0, 40.0, -2.0);
    for k in 40..60 {
        let (seconds, pose) = (0.1 * f64::from(k), lane(SCAN_M * f64::from(k)));
        let seen = drive.seen(seconds, &pose);
        update(&mut tracker, seconds, &seen);
        assert!(off(&tracker, seconds, &pose)[0] < 0.2, "{seconds}: {:?}", off(&tracker, seconds, &pose));
    }
    assert_eq!(tracker.counters().odometry_jumps, 1);
}

/// Distances of a corridor along x, 2 m wide and without ends.
fn corridor(pose: &Pose2) -> LaserScan {
    let range = |k: usize| {
        let bearing = pose.rotation.angle() - 1.57 + (k as f64).to_radians();
        let wall = if bearing.sin() > 0.0 { 1.0 - pose.translation.y } else { -1.0 - pose.translation.y };
        let range = wall / bearing.sin();
        if range < 20.0 { range as f32 } else { f32::INFINITY }
    };
    LaserScan {
        first_bearing_rad: -1.57,
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..181).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

#[test]
fn along_a_corridor_the_odometer_decides_and_the_spread_is_kept() {
    let params = RbpfSlamParams { particles: 20, ..RbpfSlamParams::default() };
    let mut tracker = tracker(&params, 9);
    tracker.start(&Pose2::identity(), &(Matrix3::identity() * 1e-6));
    for k in 0..100 {
        let (seconds, pose) = (0.1 * f64::from(k), pose2(0.1 * f64::from(k), 0.0, 0.0));
        let odometry = Odometry { odom_from_base: pose, ..Odometry::default() };
        let seen = [
            observation(seconds, Data::Odometry(odometry)),
            observation(seconds, Data::LaserScan(corridor(&pose))),
        ];
        update(&mut tracker, seconds, &seen);
    }
    let estimate = tracker.estimate(Time::from_secs(9.9));
    let covariance = estimate.covariance2();
    assert!(tracker.counters().degenerate > 50, "{:?}", tracker.counters());
    assert!(covariance[(0, 0)] > 25.0 * covariance[(1, 1)], "{covariance}");
    let places: Vec<f64> =
        tracker.filter().particles().iter().map(|p| p.map_from_base.translation.x).collect();
    let spread = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    assert!(spread(&places) > 0.03, "{places:?}");
    assert!((estimate.pose2().translation.x - 9.9).abs() < 1.0);
}

#[test]
fn weights_that_are_no_numbers_count_nothing_and_when_none_is_left_all_are_equal() {
    let (mut tracker, mut drive) = driven(10, 10);
    let seen = drive.seen(1.0, &lane(SCAN_M * 10.0));
    let Data::LaserScan(scan) = &seen[1].data else { panic!() };
    let mut points = ScanPoints::default();
    tracker.filter().settings().preparation.clone().prepare(scan, &Pose3::identity(), &mut points);
    let take = |tracker: &mut Tracker| {
        tracker.filter.take(&KeyScan {
            scan,
            base_from_sensor: Pose3::identity(),
            points: &points,
            followed: Followed {
                before_from_after: Pose2::identity(),
                covariance: Matrix3::identity() * 1e-4,
            },
            explores: true,
            doubt: Doubt::None,
        })
    };
    tracker.filter.particles[0].ln_weight = f64::NAN;
    assert!(!take(&mut tracker).is_degenerate);
    tracker.filter.particles.iter_mut().for_each(|p| p.ln_weight = f64::NEG_INFINITY);
    let outcome = take(&mut tracker);
    assert!(outcome.is_degenerate && !outcome.is_resampled);
    let weights = tracker.filter().weights();
    assert!(weights.iter().all(|weight| (weight - 0.125).abs() < 1e-12), "{weights:?}");
}

#[test]
fn all_faults_of_the_keys_are_told() {
    assert!(RbpfSlamParams::default().check().is_empty());
    let wrong = RbpfSlamParams {
        particles: 0,
        alpha: [0.1, -1.0, 0.1, f64::NAN],
        resample_threshold: 1.5,
        update_factor_free: 0.7,
        likelihood_variance: 0.0,
        min_range_m: 100.0,
        ..RbpfSlamParams::default()
    };
    let keys: Vec<String> = wrong.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "likelihood_variance",
        "resample_threshold",
        "particles",
        "alpha",
        "alpha",
        "min_range_m",
        "update_factor_free",
    ];
    assert_eq!(keys, expected);
}
