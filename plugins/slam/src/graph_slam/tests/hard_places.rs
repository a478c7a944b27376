//! What search robots meet: carried away, blind, scans that are rubbish, wheels that spin.

use super::building::{log, rounds, scattered};
use super::drives::{at, built, off_m, step};
use crate::graph_slam::GraphSlamParams;
use nalgebra::Vector3;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Estimate, Imu, Observation, Status};
use rumbo_core::stages::Slam;
use rumbo_core::time::Time;

fn started(poses: &[Pose2]) -> (Box<dyn Slam>, Map) {
    let (mut slam, mut map) = (built(&GraphSlamParams::default()), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    (slam, map)
}

/// Spoils the odometer from a step on: what it says is moved on by a motion that the robot does not make.
fn mislead(log: &mut [Vec<Observation>], extra: impl Fn(usize) -> Pose2) {
    let mut wrong = Pose2::identity();
    for (k, seen) in log.iter_mut().enumerate() {
        wrong *= extra(k);
        for observation in seen {
            if let Data::Odometry(odometry) = &mut observation.data {
                odometry.odom_from_base *= wrong;
            }
        }
    }
}

/// The same readings at other times.
fn at_times(mut log: Vec<Vec<Observation>>) -> Vec<Vec<Observation>> {
    for (k, seen) in log.iter_mut().enumerate() {
        let stamp = Time::from_secs(0.1 * k as f64);
        seen.iter_mut().for_each(|observation| observation.stamp = stamp);
    }
    log
}

/// A round up to some step, and then, in no time, once more what was seen on other steps of it. The odometer has felt
/// nothing of it.
fn carried_away(n_before: usize, again: std::ops::Range<usize>) -> (Vec<Pose2>, Vec<Vec<Observation>>) {
    let mut poses = rounds(1);
    let carried: Vec<Pose2> = poses[again.clone()].to_vec();
    let all = log(&poses, true);
    poses.truncate(n_before);
    poses.extend(carried);
    let odometer = |seen: &[Observation]| {
        let Data::Odometry(odometry) = seen[0].data else { panic!() };
        odometry.odom_from_base
    };
    let (last, first) = (odometer(&all[n_before - 1]), odometer(&all[again.start]));
    let mut log = all[..n_before].to_vec();
    for mut seen in all[again].iter().cloned() {
        if let Data::Odometry(odometry) = &mut seen[0].data {
            odometry.odom_from_base = last * first.inverse() * odometry.odom_from_base;
        }
        log.push(seen);
    }
    (poses, at_times(log))
}

/// It is hardly ever sure of a wrong place, and finds itself in the end.
fn finds_itself(n_before: usize, again: std::ops::Range<usize>) {
    let (poses, log) = carried_away(n_before, again);
    let (mut slam, mut map) = started(&poses);
    let estimates: Vec<Estimate> = log.iter().map(|seen| step(&mut *slam, &mut map, seen)).collect();
    let is_wrong = |k: &usize| {
        estimates[*k].status == Status::Tracking && off_m(&estimates[*k].pose2(), &poses[*k]) > 0.3
    };
    let n_wrong = (n_before..poses.len()).filter(is_wrong).count();
    assert!(n_wrong <= 3, "sure of a wrong place {n_wrong} times");
    let (end, truth) = (estimates.last().unwrap(), poses.last().unwrap());
    assert_eq!(end.status, Status::Tracking);
    assert!(off_m(&end.pose2(), truth) < 0.1, "{}", off_m(&end.pose2(), truth));
}

#[test]
fn a_robot_that_is_carried_away_says_that_it_is_lost_or_finds_itself() {
    // From the last corner into the second corridor, and on from there for 8 meters.
    finds_itself(rounds(1).len(), 220..300);
}

#[test]
fn so_does_one_that_is_carried_six_meters_back_along_its_corridor() {
    finds_itself(140, 80..135);
}

#[test]
fn with_neither_scans_nor_an_odometer_for_long_it_is_not_sure_of_a_wrong_place() {
    let poses = rounds(1);
    let mut log = log(&poses, false);
    let blind = 100..180;
    for seen in &mut log[blind.clone()] {
        seen[0].valid = false;
    }
    let (mut slam, mut map) = started(&poses);
    for (k, seen) in log.iter().enumerate() {
        let estimate = step(&mut *slam, &mut map, seen);
        let off = off_m(&estimate.pose2(), &poses[k]);
        let is_sure = estimate.status == Status::Tracking;
        assert!(k < blind.start + 15 || !blind.contains(&k) || !is_sure, "{k}: it sees nothing");
        assert!(!is_sure || off < 0.4 || blind.contains(&k), "{k}: sure of a place that is {off} m off");
    }
}

#[test]
fn after_thirty_seconds_without_scans_it_is_not_sure_of_a_wrong_place() {
    let poses = rounds(2);
    let mut log = log(&poses, true);
    let blind = poses.len() / 2 + 50..poses.len() / 2 + 350;
    for seen in &mut log[blind.clone()] {
        seen.truncate(1);
    }
    let (mut slam, mut map) = started(&poses);
    for (k, seen) in log.iter().enumerate() {
        let estimate = step(&mut *slam, &mut map, seen);
        let off = off_m(&estimate.pose2(), &poses[k]);
        let is_sure = estimate.status == Status::Tracking;
        if blind.contains(&k) {
            assert!(k < blind.start + 15 || !is_sure, "{k}: it sees nothing");
        }
        assert!(!is_sure || off < 0.4, "{k}: sure of a place that is {off} m off");
        assert!(k >= blind.start || is_sure, "{k}");
    }
}

#[test]
fn every_tenth_scan_may_be_rubbish() {
    let poses = rounds(1);
    let mut log = log(&poses, true);
    for (k, seen) in log.iter_mut().enumerate().filter(|(k, _)| k % 10 == 7) {
        let Data::LaserScan(scan) = &mut seen[1].data else { panic!() };
        let rubbish = (0..270).map(|beam| 8.0 * (0.5 + scattered(k * 270 + beam)) as f32);
        scan.ranges_m = rubbish.collect::<Vec<f32>>().into();
    }
    let (mut slam, mut map) = started(&poses);
    for (k, seen) in log.iter().enumerate() {
        let off = off_m(&step(&mut *slam, &mut map, seen).pose2(), &poses[k]);
        assert!(off < 0.2, "{k}: {off}");
    }
    let off = off_m(&step(&mut *slam, &mut map, &[]).pose2(), poses.last().unwrap());
    assert!(off < 0.06, "{off}");
}

#[test]
fn wheels_that_spin_in_place_move_nothing() {
    let mut poses = rounds(1);
    poses.truncate(120);
    poses.extend(std::iter::repeat_n(poses[119], 50));
    let mut log = log(&poses, true);
    mislead(&mut log, |k| if k >= 120 { pose2(0.1, 0.0, 0.02) } else { Pose2::identity() });
    let (mut slam, mut map) = started(&poses);
    for (k, seen) in log.iter().enumerate() {
        let off = off_m(&step(&mut *slam, &mut map, seen).pose2(), &poses[k]);
        assert!(off < 0.15, "{k}: {off}");
    }
}

#[test]
fn a_gyroscope_tells_turns_that_the_wheels_do_not() {
    let poses = rounds(1);
    let mut log = log(&poses, true);
    // Wheels that see nothing of the turn at the first corner, which the robot makes without a scan.
    let turn_of = |k: usize| if k == 0 { 0.0 } else { (poses[k - 1].inverse() * poses[k]).rotation.angle() };
    mislead(&mut log, |k| pose2(0.0, 0.0, -turn_of(k)));
    for seen in &mut log[171..200] {
        seen.truncate(1);
    }
    let off_rad = |log: &[Vec<Observation>]| {
        let (mut slam, mut map) = started(&poses);
        let end = log[..203].iter().map(|seen| step(&mut *slam, &mut map, seen)).last().unwrap();
        (poses[202].inverse() * end.pose2()).rotation.angle().abs()
    };
    let without = off_rad(&log);
    for (k, seen) in log.iter_mut().enumerate() {
        let rates_rad_s = Vector3::new(0.0, 0.0, turn_of(k) / 0.1).into();
        let data = Data::Imu(Imu { rates_rad_s, ..Imu::default() });
        let imu = Observation { data, ..seen[0].clone() };
        seen.insert(1, imu);
    }
    let with = off_rad(&log);
    assert!(with < 0.02 && without > 0.5, "{with} rad with a gyroscope, {without} without");
}
