//! What single scans give, and places where landmarks do not suffice.

use super::super::params::TriangulationParams;
use super::super::scan::SeenScan;
use super::super::tracker::{Anchor, Tracker};
use super::drive::{CLAIMED, Hardship, error, fan, scan};
use super::place::Office;
use nalgebra::{Matrix3, Vector2, Vector3};
use rand::RngExt;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::Status;
use rumbo_core::rng::{Rng, stream};
use rumbo_core::time::Time;
use std::f64::consts::PI;

const QUIET: Hardship = Hardship {
    odometer_errs: false,
    odometer_boasts: false,
    has_walker: false,
    tilted: 0.0,
    start_is_off: false,
    n_beams: 361,
};

fn tracker_at(pose: &Pose2) -> Tracker {
    let covariance = Matrix3::from_diagonal(&Vector3::new(2.5e-5, 2.5e-5, 4e-6));
    let anchor = Anchor { map_from_base: *pose, covariance, odom_from_base: *pose };
    Tracker::new(TriangulationParams::default().settings(), anchor, stream(1, "landmarks"))
}

/// Shows what is seen at `truth`, while the odometer says `odom_from_base`.
fn look(
    tracker: &mut Tracker,
    office: &Office,
    (truth, odom_from_base): (&Pose2, &Pose2),
    (time_s, noise): (f64, [f64; 3]),
    error_m: f64,
    rng: &mut Rng,
) {
    let ranges = scan(office, truth, (time_s, &QUIET), error_m, rng);
    let stamp = Time::from_secs(time_s);
    let seen = SeenScan { stamp, fan: fan(361), ranges_m: &ranges, base_from_sensor: Pose2::identity() };
    tracker.look(&seen, odom_from_base, noise, Some((1, &office.grid)));
}

#[test]
fn a_place_is_found_also_with_the_odometer_off_by_20_cm_and_5_degrees() {
    for name in ["5x5", "10x10", "20x20"] {
        let office = Office::exact(name);
        for (off_m, off_deg) in [(0.0, 0.0), (0.2, 5.0)] {
            let (mut n, mut n_good, mut n_starved) = (0, 0, 0);
            for k in 0..200 {
                let mut rng = stream(k, "displacement");
                let truth = office.free_place(&mut rng);
                let side: f64 = rng.random_range(-PI..PI);
                let sign = if rng.random() { 1.0 } else { -1.0 };
                let believed = Pose2::new(
                    truth.translation.vector + off_m * Vector2::new(side.cos(), side.sin()),
                    truth.rotation.angle() + sign * f64::to_radians(off_deg),
                );
                let covariance = Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.008));
                let anchor = Anchor { map_from_base: believed, covariance, odom_from_base: believed };
                let settings = TriangulationParams::default().settings();
                let mut tracker = Tracker::new(settings, anchor, stream(1, "landmarks"));
                look(&mut tracker, &office, (&truth, &believed), (0.0, CLAIMED), 0.0, &mut rng);
                let off = error(&tracker.carried_to(&believed, CLAIMED).0, &truth);
                n += 1;
                n_good += usize::from(off[0].hypot(off[1]) <= 0.02 && off[2].abs() <= 0.5);
                n_starved += usize::from(tracker.report().n_starved > 0);
            }
            assert!(n_good + n_starved >= n * 95 / 100, "{name} {off_m}: {n_good} of {n}");
        }
    }
}

#[test]
fn a_robot_that_is_surer_of_its_start_than_it_should_be_comes_back() {
    for name in ["5x5", "10x10", "20x20"] {
        let office = Office::like(name, 5);
        let n_back = (0..20).filter(|k| {
            let mut rng = stream(*k, "overconfident");
            let route = office.route(4.0, &mut rng);
            let side: f64 = rng.random_range(-PI..PI);
            let off = 0.15 * Vector2::new(side.cos(), side.sin());
            let told = Pose2::new(route[0].translation.vector + off, route[0].rotation.angle() + 0.03);
            let mut tracker = tracker_at(&told);
            let mut odom_from_base = told;
            for (n, ends) in route.windows(2).enumerate() {
                odom_from_base *= ends[0].inverse() * ends[1];
                let at = (0.5 * n as f64, CLAIMED);
                look(&mut tracker, &office, (&ends[1], &odom_from_base), at, 0.015, &mut rng);
            }
            let off = error(&tracker.carried_to(&odom_from_base, CLAIMED).0, &route[route.len() - 1]);
            off[0].hypot(off[1]) < 0.03 && off[2].abs() < 0.5
        });
        let n_back = n_back.count();
        assert!(n_back >= 18, "{name}: {n_back} of 20");
    }
}

#[test]
fn in_a_long_corridor_only_the_way_along_it_becomes_unsure() {
    for seed in 0..5 {
        let (office, middle_m) = Office::corridor(40.0, seed);
        let mut rng = stream(seed, "corridor");
        let start = pose2(9.0, middle_m, 0.0);
        let mut tracker = tracker_at(&start);
        let (mut truth, mut odom_from_base) = (start, start);
        let scale = 1.0 + rng.random_range(-0.05..0.05);
        for k in 0..200 {
            truth *= pose2(0.1, 0.0, 0.0);
            odom_from_base *= pose2(0.1 * scale, 0.0, 0.001);
            let at = (0.5 * f64::from(k), CLAIMED);
            look(&mut tracker, &office, (&truth, &odom_from_base), at, 0.015, &mut rng);
        }
        let (found, covariance) = tracker.carried_to(&odom_from_base, CLAIMED);
        let off = error(&found, &truth);
        let [x, y, yaw] = [0, 1, 2].map(|k| covariance[(k, k)].sqrt());
        assert!(off[1].abs() < 0.03 && off[2].abs() < 0.5 && off[0].abs() < 1.1, "{off:?}");
        assert!(y < 0.02 && yaw < 0.01, "{y} {yaw}");
        // Twenty meters by an odometer of 3 %.
        assert!((0.3..0.9).contains(&x) && off[0].abs() < 3.0 * x, "{x} {off:?}");
        assert_eq!(tracker.status(), Status::Tracking, "two walls are landmarks");
    }
}

#[test]
fn a_robot_carried_elsewhere_is_lost_and_one_that_was_not_is_not() {
    for name in ["5x5", "10x10", "20x20"] {
        let office = Office::like(name, 3);
        let (mut n_lost, mut n_scans) = (0, 0);
        for k in 0..20 {
            let mut rng = stream(k, "kidnapped");
            let route = office.route(3.0, &mut rng);
            let other = office.route(12.0, &mut rng);
            let mut tracker = tracker_at(&route[0]);
            let mut odom_from_base = route[0];
            let mut time_s = 0.0;
            let mut go = |tracker: &mut Tracker, poses: &[Pose2], rng: &mut Rng| {
                for (n, ends) in poses.windows(2).enumerate() {
                    odom_from_base *= ends[0].inverse() * ends[1];
                    time_s += 0.5;
                    let at = (time_s, CLAIMED);
                    look(tracker, &office, (&ends[1], &odom_from_base), at, 0.015, rng);
                    if tracker.status() == Status::Lost {
                        return Some(n);
                    }
                }
                None
            };
            assert_eq!(go(&mut tracker, &route, &mut rng), None, "{name} {k}");
            if let Some(n) = go(&mut tracker, &other, &mut rng) {
                n_lost += 1;
                n_scans += n;
            }
        }
        assert!(n_lost >= 18 && n_scans <= 40 * n_lost, "{name}: {n_lost} after {n_scans}");
    }
}

#[test]
fn where_the_map_knows_nothing_tracking_degrades_and_in_the_end_the_robot_is_lost() {
    let office = Office::exact("5x5");
    // The robot believes to be far outside of the map.
    let start = pose2(100.0, 100.0, 0.0);
    let truth = pose2(2.0, 2.0, 0.0);
    let mut tracker = tracker_at(&start);
    let (mut odom_from_base, mut statuses) = (start, Vec::new());
    let mut rng = stream(1, "outside");
    for k in 0..200 {
        odom_from_base *= pose2(0.1, 0.0, 0.05);
        look(&mut tracker, &office, (&truth, &odom_from_base), (0.5 * f64::from(k), CLAIMED), 0.01, &mut rng);
        statuses.push(tracker.status());
    }
    let first = |status: Status| statuses.iter().position(|s| *s == status).unwrap();
    assert_eq!(first(Status::Converging), 2, "the third starved scan");
    let (lost, report) = (first(Status::Lost), tracker.report());
    assert!(lost > 10 && report.n_starved == 200, "{lost} {report:?}");
    let (_, covariance) = tracker.carried_to(&odom_from_base, CLAIMED);
    assert!(covariance[(0, 0)].sqrt() > 0.3, "{covariance}");
}

#[test]
fn without_a_map_and_through_a_jump_of_the_odometer_the_pose_is_carried_on() {
    let start = pose2(2.0, 1.5, 0.3);
    let mut tracker = tracker_at(&start);
    let ranges = vec![f32::INFINITY; 361];
    let seen =
        SeenScan { stamp: Time::ZERO, fan: fan(361), ranges_m: &ranges, base_from_sensor: Pose2::identity() };
    let gone = start * pose2(0.3, 0.0, 0.1);
    tracker.look(&seen, &gone, CLAIMED, None);
    let (found, before) = tracker.carried_to(&gone, CLAIMED);
    assert!(error(&found, &gone).iter().all(|off| off.abs() < 1e-9));
    // The odometer begins anew at zero; the robot may have come 0.1 m and 0.2 radians meanwhile.
    tracker.rebase(&gone, &Pose2::identity(), CLAIMED, [0.1, 0.2]);
    let (found, after) = tracker.carried_to(&Pose2::identity(), CLAIMED);
    assert!(error(&found, &gone).iter().all(|off| off.abs() < 1e-9));
    let widened = before + Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.04));
    assert!((after - widened).norm() < 1e-12, "{after} {widened}");
    let further = pose2(0.2, 0.0, 0.0);
    let (found, _) = tracker.carried_to(&further, CLAIMED);
    assert!(error(&found, &(gone * further)).iter().all(|off| off.abs() < 1e-9));
}
