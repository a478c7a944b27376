//! What is wrong with the input is said, and does no harm.

use super::course::{Mapper, off_m};
use super::world::{LoopWorld, lane, laser, observation, rubbish, stream};
use nalgebra::Matrix3;
use rand::RngExt;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{Check, Data, LaserScan, Odometry, Prior, Status};
use rumbo_core::registry::Params;
use rumbo_slam::scan_match_slam::ScanMatchSlamParams;

/// The first quarter of the loop, at ten scans a second; the robot stands then at this time and this far on the lane.
fn mapped(world: &LoopWorld) -> (Mapper, f64, f64) {
    mapped_with(&ScanMatchSlamParams::default(), world)
}

fn mapped_with(params: &ScanMatchSlamParams, world: &LoopWorld) -> (Mapper, f64, f64) {
    let mut rng = stream(9);
    let mut mapper = Mapper::start_at(params, lane(0.0));
    for k in 0..100 {
        let t = f64::from(k);
        mapper.see(&[laser(1.0 + 0.1 * t, world.scan(&lane(0.1 * t), &mut rng))]);
    }
    (mapper, 10.9, 9.9)
}

#[test]
fn scans_without_readings_change_nothing_and_the_pose_is_the_predicted_one() {
    let world = LoopWorld::load();
    let (mut mapper, time_s, s_m) = mapped(&world);
    let before = mapper.map.clone();
    for (k, value) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0].into_iter().enumerate() {
        let mut scan = world.scan(&lane(s_m), &mut stream(3));
        scan.ranges_m = vec![value; 541].into();
        let estimate = mapper.see(&[laser(time_s + 0.01 * (k as f64 + 1.0), scan)]);
        assert!(estimate.check().is_ok() && off_m(&estimate.pose2(), &lane(s_m)) < 0.2);
        assert_eq!(estimate.status, Status::Converging);
    }
    mapper.see(&[laser(time_s + 0.05, LaserScan { max_range_m: 30.0, ..LaserScan::default() })]);
    assert_eq!(mapper.count("scans not matched: too few points"), 5.0);
    assert_eq!(before, mapper.map);
}

#[test]
fn a_scan_that_is_not_newer_is_dropped_and_counted() {
    let world = LoopWorld::load();
    let (mut mapper, time_s, s_m) = mapped(&world);
    let before = mapper.see(&[]);
    for age_s in [0.0, 0.5] {
        let scan = world.scan(&lane(s_m + 3.0), &mut stream(3));
        assert_eq!(mapper.see(&[laser(time_s - age_s, scan)]).map_from_base, before.map_from_base);
    }
    assert_eq!(mapper.count("scans dropped: not newer than the last"), 2.0);
}

#[test]
fn one_reading_in_ten_may_be_anything() {
    let world = LoopWorld::load();
    let mut rng = stream(12);
    let mut mapper = Mapper::start_at(&ScanMatchSlamParams::default(), lane(0.0));
    for k in 0..150 {
        let truth = lane(0.1 * f64::from(k));
        let mut scan = world.scan(&truth, &mut rng);
        let corrupted = scan
            .ranges_m
            .iter()
            .map(|range| if rng.random::<f64>() < 0.1 { rng.random::<f32>() * 30.0 } else { *range });
        scan.ranges_m = corrupted.collect::<Vec<f32>>().into();
        let estimate = mapper.see(&[laser(1.0 + 0.1 * f64::from(k), scan)]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.12, "{k}: {}", estimate.pose2());
        assert_eq!(estimate.status, Status::Tracking);
    }
}

/// Every tenth scan has nothing to do with the world.
#[test]
fn one_scan_in_ten_may_be_rubbish() {
    let world = LoopWorld::load();
    let mut rng = stream(13);
    let mut mapper = Mapper::start_at(&ScanMatchSlamParams::default(), lane(0.0));
    for k in 0..200 {
        let truth = lane(0.1 * f64::from(k));
        let mut scan = world.scan(&truth, &mut rng);
        let is_rubbish = k % 10 == 7;
        if is_rubbish {
            scan.ranges_m = rubbish(&mut rng).into();
        }
        let estimate = mapper.see(&[laser(1.0 + 0.1 * f64::from(k), scan)]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.15, "{k}: {}", estimate.pose2());
        assert_eq!(estimate.status == Status::Tracking, !is_rubbish, "{k}");
    }
}

/// The odometer counts three meters while the robot stands for five seconds.
#[test]
fn wheels_that_spin_in_place_move_nothing() {
    let world = LoopWorld::load();
    let mut rng = stream(14);
    let (mut mapper, time_s, s_m) = mapped(&world);
    for k in 0..=80 {
        let t = 0.1 * f64::from(k);
        let x_m = 0.6 * t.min(5.0);
        let truth = lane(s_m + (t - 5.0).max(0.0));
        let driven = lane(s_m).inverse() * truth;
        let odometry = Odometry { odom_from_base: pose2(x_m, 0.0, 0.0) * driven, ..Odometry::default() };
        let scan = laser(time_s + 0.01 + t, world.scan(&truth, &mut rng));
        let estimate = mapper.see(&[observation(0, time_s + 0.01 + t, Data::Odometry(odometry)), scan]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{k}: {}", estimate.pose2());
    }
}

/// The operator's word counts, whatever the clock said before.
#[test]
fn a_robot_that_is_told_where_it_is_goes_on_with_a_clock_that_began_anew() {
    let world = LoopWorld::load();
    let (mut mapper, _, _) = mapped(&world);
    let before = mapper.map.clone();
    let prior = Prior::Pose {
        map_from_base: lane(3.0),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::identity() * 1e-2,
    };
    mapper.slam.relocate(&prior, &mut mapper.map).unwrap();
    for k in 0..20 {
        let truth = lane(3.1 + 0.1 * f64::from(k));
        let scan = laser(0.1 * f64::from(k), world.scan(&truth, &mut stream(60 + k as u64)));
        let estimate = mapper.see(&[scan]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{k}: {}", estimate.pose2());
        assert_eq!(estimate.status, Status::Tracking);
    }
    assert_eq!(before.grid.unwrap().header(), mapper.map.grid.as_ref().unwrap().header());
    mapper.slam.relocate(&Prior::Unknown, &mut mapper.map).unwrap();
    let truth = lane(8.0);
    let estimate = mapper.see(&[laser(0.0, world.scan(&truth, &mut stream(90)))]);
    assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{}", estimate.pose2());
}

#[test]
fn after_thirty_seconds_without_scans_the_odometer_brings_it_back_to_the_map() {
    let world = LoopWorld::load();
    let (mut mapper, time_s, s_m) = mapped(&world);
    // Half a meter a second backwards, with an odometer that counts 4 percent too much.
    let odometer = |s: f64| {
        let way = lane(s_m).inverse() * lane(s);
        pose2(way.translation.x * 1.04, way.translation.y, way.rotation.angle())
    };
    mapper.see(&[observation(0, time_s, Data::Odometry(Odometry::default()))]);
    for k in 1..=300 {
        let s = s_m - 0.02 * f64::from(k);
        let odometry = Odometry { odom_from_base: odometer(s), ..Odometry::default() };
        mapper.see(&[observation(0, time_s + 0.1 * f64::from(k), Data::Odometry(odometry))]);
    }
    let truth = lane(s_m - 6.0);
    let estimate = mapper.see(&[laser(time_s + 30.0, world.scan(&truth, &mut stream(8)))]);
    assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{} {truth}", estimate.pose2());
    assert_eq!(estimate.status, Status::Tracking);
}

#[test]
fn a_robot_that_was_carried_away_says_it_is_lost_and_finds_itself() {
    let world = LoopWorld::load();
    let (mut mapper, time_s, _) = mapped(&world);
    let mut rng = stream(4);
    let (mut was_lost, mut found) = (false, false);
    for k in 1..=80 {
        let truth = lane(1.5) * pose2(0.0, 0.0, 2.5);
        let estimate = mapper.see(&[laser(time_s + 0.1 * f64::from(k), world.scan(&truth, &mut rng))]);
        was_lost |= estimate.status == Status::Lost;
        found = estimate.status == Status::Tracking && off_m(&estimate.pose2(), &truth) < 0.1;
        // What it says it tracks must not be another place.
        assert!(found || estimate.status != Status::Tracking || k < 3, "{k}: {}", estimate.pose2());
    }
    assert!(was_lost && found, "lost: {was_lost}, found: {found}");
}

#[test]
fn a_state_that_was_saved_is_gone_on_from_with_the_same_map() {
    goes_on(&ScanMatchSlamParams::default());
}

#[test]
fn so_is_one_with_surfaces() {
    goes_on(&ScanMatchSlamParams { polish: true, ..ScanMatchSlamParams::default() });
}

fn goes_on(params: &ScanMatchSlamParams) {
    let world = LoopWorld::load();
    let (mut mapper, time_s, s_m) = mapped_with(params, &world);
    let saved = mapper.slam.save().unwrap();
    let mut resumed = Mapper::new(params);
    resumed.slam.start(&Prior::Saved(saved.clone().into()), &mut resumed.map).unwrap();
    assert_eq!(resumed.map.grid, mapper.map.grid);
    let (again, before) = (resumed.slam.trajectory().unwrap(), mapper.slam.trajectory().unwrap());
    assert_eq!(again.len(), before.len());
    for (again, before) in again.iter().zip(&before) {
        assert_eq!(again.stamp, before.stamp);
        assert!((again.map_from_base.inverse() * before.map_from_base).translation.vector.norm() < 1e-9);
    }
    for k in 1..=30 {
        let truth = lane(s_m + 0.1 * f64::from(k));
        let scan = world.scan(&truth, &mut stream(200 + k as u64));
        let estimate = resumed.see(&[laser(time_s + 0.1 * f64::from(k), scan.clone())]);
        let other = mapper.see(&[laser(time_s + 0.1 * f64::from(k), scan)]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{k}: {}", estimate.pose2());
        assert!(off_m(&estimate.pose2(), &other.pose2()) < 1e-9, "{k}: {}", other.pose2());
    }
    assert_eq!(resumed.map.grid, mapper.map.grid);
    // Another day, by a clock that began anew: where it was.
    resumed.slam.start(&Prior::Saved(saved.clone().into()), &mut resumed.map).unwrap();
    for k in 0..10 {
        let truth = lane(s_m + 0.1 * f64::from(k)) * pose2(-0.05, 0.03, 0.04);
        let estimate =
            resumed.see(&[laser(0.1 * f64::from(k), world.scan(&truth, &mut stream(300 + k as u64)))]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{k}: {}", estimate.pose2());
        assert_eq!(estimate.status, Status::Tracking);
    }
    for n in [0, 10, saved.len() - 1] {
        let cut = Prior::Saved(saved[..n].to_vec().into());
        assert!(resumed.slam.start(&cut, &mut resumed.map).is_err());
    }
}

#[test]
fn poses_that_are_no_numbers_are_refused() {
    let (mut mapper, ..) = mapped(&LoopWorld::load());
    let prior = Prior::Pose {
        map_from_base: pose2(f64::NAN, 0.0, 0.0),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::identity(),
    };
    assert!(mapper.slam.relocate(&prior, &mut mapper.map).is_err());
    let not_definite = Prior::Pose {
        map_from_base: lane(9.9),
        odom_from_base: Pose2::identity(),
        covariance: -Matrix3::identity(),
    };
    mapper.slam.relocate(&not_definite, &mut mapper.map).unwrap();
    let estimate = mapper.see(&[]);
    assert!(estimate.covariance2().cholesky().is_some());
}

#[test]
fn impossible_parameters_are_all_named() {
    let params = ScanMatchSlamParams {
        resolution_m: 0.0,
        levels: 0,
        min_known: 2.0,
        min_points: 1,
        odometer_way: f64::NAN,
        update_factor_free: 0.7,
        lost_after_scans: 0,
        lowest_m: f64::NEG_INFINITY,
        odometer_doubt: 0.0,
        ..ScanMatchSlamParams::default()
    };
    let keys: Vec<String> = params.check().iter().map(|fault| format!("{fault:?}")).collect();
    for key in [
        "resolution_m",
        "levels",
        "min_known",
        "min_points",
        "odometer_way",
        "update_factor_free",
        "lost_after_scans",
        "lowest_m",
        "odometer_doubt",
    ] {
        assert!(keys.iter().any(|fault| fault.contains(key)), "{key}: {keys:?}");
    }
    assert!(ScanMatchSlamParams::default().check().is_empty());
}
