//! What is wrong with the input is said, and does no harm.

use super::course::Mapper;
use super::world::{LoopWorld, lane, laser, observation, stream};
use nalgebra::Matrix3;
use rand::RngExt;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{Check, Data, LaserScan, Odometry, Prior, Status};
use rumbo_core::registry::Params;
use rumbo_slam::scan_match_slam::ScanMatchSlamParams;

impl Mapper {
    /// So surely that a match changes nothing.
    pub fn relocate_exactly(&mut self, map_from_base: Pose2) {
        let (odom_from_base, covariance) = (Pose2::identity(), Matrix3::identity() * 1e-12);
        let prior = Prior::Pose { map_from_base, odom_from_base, covariance };
        self.slam.relocate(&prior, &mut self.map).unwrap();
    }
}

/// The first quarter of the loop, at ten scans a second; the robot stands then at this time and this far on the lane.
fn mapped(world: &LoopWorld) -> (Mapper, f64, f64) {
    mapped_with(world, &ScanMatchSlamParams::default())
}

fn mapped_with(world: &LoopWorld, params: &ScanMatchSlamParams) -> (Mapper, f64, f64) {
    let mut rng = stream(9);
    let mut mapper = Mapper::start_at(params, lane(0.0));
    for k in 0..100 {
        let t = f64::from(k);
        mapper.see(&[laser(1.0 + 0.1 * t, world.scan(&lane(0.1 * t), &mut rng))]);
    }
    (mapper, 10.9, 9.9)
}

fn off_m(estimate: &Pose2, truth: &Pose2) -> f64 {
    (truth.inverse() * estimate).translation.vector.norm()
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
    // Stricter than the defaults, which real rooms full of things ask for: what hardly fits is no place.
    let strict =
        ScanMatchSlamParams { max_mean_cost: 0.25, min_known: 0.5, ..ScanMatchSlamParams::default() };
    let (mut mapper, time_s, _) = mapped_with(&world, &strict);
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
    let world = LoopWorld::load();
    let (mut mapper, time_s, s_m) = mapped(&world);
    let saved = mapper.slam.save().unwrap();
    let mut resumed = Mapper::new(&ScanMatchSlamParams::default());
    resumed.slam.start(&Prior::Saved(saved.clone().into()), &mut resumed.map).unwrap();
    assert_eq!(resumed.map.grid, mapper.map.grid);
    assert_eq!(resumed.map.coarse_grids, mapper.map.coarse_grids);
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
        mapper.see(&[laser(time_s + 0.1 * f64::from(k), scan)]);
        assert!(off_m(&estimate.pose2(), &truth) < 0.1, "{k}: {}", estimate.pose2());
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
    ] {
        assert!(keys.iter().any(|fault| fault.contains(key)), "{key}: {keys:?}");
    }
    assert!(ScanMatchSlamParams::default().check().is_empty());
}
