//! The plugin on drives through the building.

use super::building::{log, rounds};
use crate::graph_slam::GraphSlamParams;
use nalgebra::Matrix3;
use rumbo_core::frames::{Point2, Pose2, flatten, pose2};
use rumbo_core::map::{CellClass, Map};
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Prior, Seen, Status};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::stages::{BuildContext, Cx, Slam, SlamError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

pub fn built(params: &GraphSlamParams) -> Box<dyn Slam> {
    assert_eq!(params.check(), []);
    params.build(&BuildContext::bare("slam")).unwrap()
}

pub fn at(map_from_base: Pose2) -> Prior {
    Prior::Pose { map_from_base, odom_from_base: Pose2::identity(), covariance: Matrix3::identity() * 1e-6 }
}

pub fn step(slam: &mut dyn Slam, map: &mut Map, seen: &[Observation]) -> Estimate {
    let now = seen.last().map_or(Time::ZERO, |observation| observation.stamp);
    slam.update(&mut Cx { now, trace: &Trace::unwatched() }, Seen::sorted(seen), map).unwrap()
}

pub fn off_m(a: &Pose2, b: &Pose2) -> f64 {
    (a.translation.vector - b.translation.vector).norm()
}

/// Drives through the log: the last estimate.
fn drive(slam: &mut dyn Slam, map: &mut Map, log: &[Vec<Observation>]) -> Estimate {
    log.iter().map(|seen| step(slam, map, seen)).last().unwrap()
}

#[test]
fn two_rounds_with_a_bad_odometer_end_on_the_truth_and_so_do_all_scans_and_walls() {
    let (poses, params) = (rounds(2), GraphSlamParams::default());
    let (mut slam, mut map) = (built(&params), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    let log = log(&poses, true);
    let end = drive(&mut *slam, &mut map, &log);
    let Data::Odometry(last) = &log.last().unwrap()[0].data else { panic!() };
    assert!(off_m(&(poses[0] * last.odom_from_base), poses.last().unwrap()) > 1.0, "the odometer is bad");
    assert_eq!(end.status, Status::Tracking);
    assert!(
        off_m(&end.pose2(), poses.last().unwrap()) < 0.05,
        "{}",
        off_m(&end.pose2(), poses.last().unwrap())
    );
    let trajectory = slam.trajectory().unwrap();
    assert_eq!(trajectory.len(), poses.len());
    let errors: Vec<f64> = trajectory
        .iter()
        .zip(&poses)
        .map(|(found, truth)| off_m(&flatten(&found.map_from_base), truth))
        .collect();
    let (most, mean) =
        (errors.iter().copied().fold(0.0, f64::max), errors.iter().sum::<f64>() / errors.len() as f64);
    assert!(most < 0.06 && mean < 0.025, "{most} m, mean {mean} m");
    let grid = map.grid.unwrap();
    let class = |x: f64, y: f64| grid.class(grid.cell_at(Point2::new(x, y)).unwrap());
    assert_eq!(class(10.0, 1.5), CellClass::Free);
    assert_eq!(class(10.0, 7.0), CellClass::Unknown);
    let walls_at =
        |x: f64, y: f64| [-0.1, -0.05, 0.0, 0.05, 0.1].iter().any(|d| class(x, y + d) == CellClass::Occupied);
    for y in [0.0, 14.0] {
        let n_seen = (1..19).filter(|x| walls_at(f64::from(*x), y)).count();
        assert!(n_seen >= 14, "{n_seen} of 18 places on the wall at {y}");
    }
}

/// Bytes of the whole state after each round, and how far off the robot is at the end.
fn patrol(params: &GraphSlamParams, n_rounds: usize) -> (Vec<usize>, f64) {
    let poses = rounds(n_rounds);
    let (mut slam, mut map) = (built(params), Map::default());
    slam.keep_no_trajectory();
    slam.start(&at(poses[0]), &mut map).unwrap();
    let mut off = 0.0;
    let sizes = log(&poses, true)
        .chunks(poses.len() / n_rounds)
        .zip(poses.chunks(poses.len() / n_rounds))
        .map(|(log, poses)| {
            off = off_m(&drive(&mut *slam, &mut map, log).pose2(), poses.last().unwrap());
            slam.save().unwrap().len()
        })
        .collect();
    (sizes, off)
}

#[test]
fn a_place_that_was_mapped_twice_needs_no_more_key_frames() {
    let (sizes, end_m) = patrol(&GraphSlamParams { most_visits: 2, ..GraphSlamParams::default() }, 5);
    let growth = sizes[4] as f64 / sizes[2] as f64 - 1.0;
    assert!(growth < 0.02 && end_m < 0.05, "{sizes:?}: {growth}, {end_m} m");
    let (sizes, _) = patrol(&GraphSlamParams { most_visits: 9, ..GraphSlamParams::default() }, 4);
    assert!(sizes[3] as f64 > 1.25 * sizes[2] as f64, "without that it grows: {sizes:?}");
}

#[test]
fn without_an_odometer_it_goes_on() {
    let poses = rounds(1);
    let (mut slam, mut map) = (built(&GraphSlamParams::default()), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    let end = drive(&mut *slam, &mut map, &log(&poses, false));
    assert!(
        off_m(&end.pose2(), poses.last().unwrap()) < 0.15,
        "{}",
        off_m(&end.pose2(), poses.last().unwrap())
    );
    let map_from_base = flatten(&end.map_from_odom) * Pose2::identity();
    assert!(
        off_m(&map_from_base, &end.pose2()) < 1e-9,
        "an engine without an odometer takes it to stand still"
    );
}

#[test]
fn a_saved_state_goes_on_as_if_nothing_had_happened() {
    let (poses, params) = (rounds(1), GraphSlamParams::default());
    let log = log(&poses, true);
    let (mut slam, mut map) = (built(&params), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    drive(&mut *slam, &mut map, &log[..300]);
    let bytes = slam.save().unwrap();
    let (mut again, mut other_map) = (built(&params), Map::default());
    again.start(&Prior::Saved(bytes.clone().into()), &mut other_map).unwrap();
    assert_eq!(again.save().unwrap().len(), bytes.len());
    for seen in &log[300..360] {
        let (a, b) = (step(&mut *slam, &mut map, seen), step(&mut *again, &mut other_map, seen));
        assert!(off_m(&a.pose2(), &b.pose2()) < 1e-9 && a.status == b.status);
    }
    assert_eq!(slam.trajectory().unwrap().len(), again.trajectory().unwrap().len());
    for n in [0, 5, 40, bytes.len() - 1] {
        let cut = built(&params).start(&Prior::Saved(bytes[..n].to_vec().into()), &mut Map::default());
        assert!(matches!(cut, Err(SlamError::Other(_))), "{n} bytes");
    }
}

#[test]
fn a_robot_that_was_carried_away_finds_itself() {
    let poses = rounds(1);
    let log = log(&poses, true);
    let (mut slam, mut map) = (built(&GraphSlamParams::default()), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    drive(&mut *slam, &mut map, &log);
    slam.relocate(&Prior::Unknown, &mut map).unwrap();
    // On from the middle of the first corridor, with other stamps.
    let mut estimates = Vec::new();
    for (k, seen) in log[60..100].iter().enumerate() {
        let mut seen = seen.clone();
        seen.iter_mut().for_each(|observation| observation.stamp = Time::from_secs(1000.0 + 0.1 * k as f64));
        estimates.push(step(&mut *slam, &mut map, &seen));
    }
    let last = estimates.last().unwrap();
    assert_eq!(last.status, Status::Tracking);
    assert!(off_m(&last.pose2(), &poses[99]) < 0.1, "{}", off_m(&last.pose2(), &poses[99]));
    slam.relocate(&at(poses[200] * pose2(0.1, -0.1, 0.05)), &mut map).unwrap();
    let told = drive(&mut *slam, &mut map, &log[200..230]);
    assert!(
        off_m(&told.pose2(), &poses[229]) < 0.1,
        "stamps may begin anew: {}",
        off_m(&told.pose2(), &poses[229])
    );
}

#[test]
fn scans_that_say_nothing_are_gaps_that_the_odometer_bridges() {
    let poses = rounds(1);
    let mut log = log(&poses, true);
    for seen in &mut log[100..112] {
        let Data::LaserScan(scan) = &mut seen[1].data else { panic!() };
        *scan = LaserScan { ranges_m: vec![f32::NAN; 270].into(), ..scan.clone() };
    }
    log[120].clear();
    log[121].iter_mut().for_each(|observation| observation.valid = false);
    if let Data::LaserScan(scan) = &mut log[122][1].data {
        scan.bearing_step_rad = f64::NAN;
    }
    let (mut slam, mut map) = (built(&GraphSlamParams::default()), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    for (k, seen) in log[..160].iter().enumerate() {
        let estimate = step(&mut *slam, &mut map, seen);
        let off = off_m(&estimate.pose2(), &poses[k]);
        // Two moments without any reading, at 1 m/s.
        let most_m = if (120..=122).contains(&k) { 0.35 } else { 0.15 };
        assert!(off < most_m, "{k}: {off}");
        let is_blind = (100..112).contains(&k);
        assert_eq!(estimate.status == Status::Converging, is_blind, "{k}");
    }
}

#[test]
fn impossible_parameters_are_all_named() {
    let params = GraphSlamParams {
        resolution_m: 0.0,
        gate_m: f64::NAN,
        least_overlap: 1.5,
        optimize_every: 0,
        update_factor_free: 0.7,
        min_range_m: 50.0,
        ..GraphSlamParams::default()
    };
    let keys: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
    let expected =
        ["resolution_m", "gate_m", "least_overlap", "optimize_every", "max_range_m", "update_factor_free"];
    assert_eq!(keys, expected);
}

#[test]
fn the_map_that_is_saved_lies_where_the_trajectory_says() {
    let poses = &rounds(2)[..700];
    // It finds no loop until it is asked for what it knows.
    let mut params = GraphSlamParams { optimize_every: 10_000, ..GraphSlamParams::default() };
    (params.loops.places, params.loops.trusted_way_m) = (0, 0.01);
    let (mut slam, mut map) = (built(&params), Map::default());
    slam.start(&at(poses[0]), &mut map).unwrap();
    let log = log(poses, true);
    drive(&mut *slam, &mut map, &log);
    let mut saved = map.clone();
    slam.save_map(&mut saved).unwrap();
    let trajectory = slam.trajectory().unwrap();
    assert_eq!(trajectory.len(), log.len());
    // Share of what was seen from the known way that lies on walls of the map.
    let share = |map: &Map| {
        let grid = map.grid.as_ref().unwrap();
        let is_wall = |x: f64, y: f64| {
            grid.cell_at(Point2::new(x, y)).is_some_and(|cell| grid.class(cell) == CellClass::Occupied)
        };
        let mut seen = Vec::new();
        for (stamped, observations) in trajectory.iter().zip(&log).step_by(9) {
            let Data::LaserScan(scan) = &observations[1].data else { panic!() };
            for (beam, range_m) in scan.ranges_m.iter().enumerate().step_by(5) {
                let (sin, cos) = scan.bearing_rad(beam).sin_cos();
                let range_m = f64::from(*range_m);
                let end = flatten(&stamped.map_from_base) * Point2::new(range_m * cos, range_m * sin);
                let near = [-0.05, 0.0, 0.05];
                seen.push(near.iter().any(|dx| near.iter().any(|dy| is_wall(end.x + dx, end.y + dy))));
            }
        }
        seen.iter().filter(|is_on_wall| **is_on_wall).count() as f64 / seen.len() as f64
    };
    let (lies, lay) = (share(&saved), share(&map));
    assert!(lies > 0.97 && lay < 0.9, "{lies} on walls of the saved map, {lay} of the one before");
    let (mut again, mut other) = (built(&params), Map::default());
    again.start(&Prior::Saved(slam.save().unwrap().into()), &mut other).unwrap();
    again.save_map(&mut other).unwrap();
    assert!(share(&other) > lies - 0.01, "a state that was saved knows the same");
    let other_way = again.trajectory().unwrap();
    for (a, b) in trajectory.iter().zip(&other_way) {
        assert!(off_m(&flatten(&a.map_from_base), &flatten(&b.map_from_base)) < 1e-6);
    }
}
