//! The grid as a stage: what is inserted, from where, and everything that must not be.

use super::*;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose3, Twist, pose2};
use rumbo_core::map::{CellClass, Grid};
use rumbo_core::messages::{Data, Estimate, Odometry, Seen};
use rumbo_core::trace::Trace;

fn params() -> OccupancyGridParams {
    OccupancyGridParams { size_cells: 128, grow_block_cells: 64, levels: 3, ..OccupancyGridParams::default() }
}

fn build(params: &OccupancyGridParams) -> (Box<dyn MapBuilder>, Map) {
    let mut builder = params.build(&BuildContext::bare("map")).unwrap();
    let mut map = Map::default();
    builder.start(&mut map).unwrap();
    (builder, map)
}

/// A scan of a round room of this radius around the sensor.
fn scan_at(seconds: f64, ranges_m: Buffer<f32>) -> Observation {
    let scan = LaserScan {
        first_bearing_rad: -1.5,
        bearing_step_rad: 3.0 / 180.0,
        max_range_m: 8.0,
        ranges_m,
        ..LaserScan::default()
    };
    Observation {
        sensor: SensorId(1),
        stamp: Time::from_secs(seconds),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::LaserScan(scan),
    }
}

fn round(seconds: f64, radius_m: f32) -> Observation {
    scan_at(seconds, Buffer::filled(181, radius_m))
}

fn odometry(seconds: f64, odom_from_base: Pose2) -> Observation {
    let data = Data::Odometry(Odometry { odom_from_base, twist: Twist::ZERO, noise: [0.0; 3] });
    Observation { sensor: SensorId(0), data, ..round(seconds, 1.0) }
}

fn known(seconds: f64, pose: Pose2) -> Estimate {
    Estimate::planar(Time::from_secs(seconds), pose, Pose2::identity(), nalgebra::Matrix3::identity() * 1e-4)
}

/// Inserts, and gives the counters.
fn insert(
    builder: &mut dyn MapBuilder,
    map: &mut Map,
    seen: &[Observation],
    estimate: &Estimate,
) -> Vec<&'static str> {
    let trace = Trace::watched();
    let mut cx = Cx { now: Time::from_secs(99.0), trace: &trace };
    builder.insert(&mut cx, &MapInput { seen: Seen::sorted(seen), estimate }, map).unwrap();
    trace.take().1.into_iter().map(|(name, _)| name).collect()
}

const INSERTED: [&str; 1] = ["scans inserted"];

fn class(map: &Map, x: f64, y: f64) -> CellClass {
    let grid = map.grid.as_ref().unwrap();
    grid.cell_at(Point2::new(x, y)).map_or(CellClass::Unknown, |cell| grid.class(cell))
}

#[test]
fn a_scan_frees_what_it_passed_and_marks_what_it_hit_on_every_level() {
    let (mut builder, mut map) = build(&params());
    let version = map.version;
    let given = insert(builder.as_mut(), &mut map, &[round(1.0, 2.02)], &known(1.0, pose2(40.0, 41.02, 0.0)));
    assert_eq!(given, INSERTED);
    assert!(map.version > version);
    assert_eq!(class(&map, 41.0, 41.3), CellClass::Free);
    assert_eq!(class(&map, 42.02, 41.02), CellClass::Occupied);
    assert_eq!(class(&map, 42.5, 41.0), CellClass::Unknown, "behind what was hit");
    assert_eq!(class(&map, 39.0, 41.0), CellClass::Unknown, "behind the robot");
    assert_eq!(map.coarse_grids.len(), 2);
    for coarse in &map.coarse_grids {
        let at = |x: f64| coarse.class(coarse.cell_at(Point2::new(x, 41.1)).unwrap());
        assert_eq!((at(41.0), at(42.02)), (CellClass::Free, CellClass::Occupied));
    }
}

#[test]
fn the_first_pose_lies_where_the_parameters_say() {
    let wanted = OccupancyGridParams { start_x: 0.25, start_y: 0.75, ..params() };
    let (mut builder, mut map) = build(&wanted);
    insert(builder.as_mut(), &mut map, &[round(1.0, 0.5)], &known(1.0, pose2(100.0, -50.0, 0.0)));
    let cell = map.grid.as_ref().unwrap().cell_at(Point2::new(100.0, -50.0)).unwrap();
    assert!(cell.col.abs_diff(32) <= 2 && cell.row.abs_diff(96) <= 2, "{cell:?}");
}

#[test]
fn a_scan_is_inserted_from_where_the_robot_was_when_it_was_taken() {
    let (mut builder, mut map) = build(&params());
    // The estimate is of 2 s; the scan was taken at 1.5 s, when the odometer was half a meter behind.
    let estimate = known(2.0, pose2(1.0, 0.0, 0.0));
    let estimate = Estimate { map_from_odom: Pose3::identity(), ..estimate };
    let seen = [odometry(1.0, pose2(0.0, 0.0, 0.0)), round(1.5, 2.0), odometry(2.0, pose2(1.0, 0.0, 0.0))];
    assert_eq!(insert(builder.as_mut(), &mut map, &seen, &estimate), INSERTED);
    assert_eq!(class(&map, 2.51, 0.0), CellClass::Occupied);
    let (mut builder, mut map) = build(&params());
    let old = Estimate { stamp: Time::from_secs(2.5), ..estimate.clone() };
    let given = insert(builder.as_mut(), &mut map, &seen, &old);
    assert_eq!(given, [Skipped::NoPose.counter()], "a second away");
    let (mut without_odometry, mut map) = build(&params());
    let given = insert(without_odometry.as_mut(), &mut map, &seen[1..2], &estimate);
    assert_eq!(given, [Skipped::NoPose.counter()]);
}

#[test]
fn a_robot_that_hardly_moves_inserts_once_unless_its_poses_are_known() {
    let poses = [pose2(0.0, 0.0, 0.0), pose2(0.3, 0.0, 0.1), pose2(0.5, 0.0, 0.1)];
    for (always, expected) in [(false, [true, false, true]), (true, [true, true, true])] {
        let (mut builder, mut map) = build(&OccupancyGridParams { map_with_known_poses: always, ..params() });
        for (k, (pose, expected)) in poses.iter().zip(expected).enumerate() {
            let seconds = k as f64;
            let given = insert(builder.as_mut(), &mut map, &[round(seconds, 2.0)], &known(seconds, *pose));
            assert_eq!(given == INSERTED, expected, "{given:?}");
        }
    }
}

#[test]
fn two_scanners_do_not_wait_for_each_other() {
    let (mut builder, mut map) = build(&params());
    let other = Observation { sensor: SensorId(2), ..round(1.0, 1.0) };
    let given = insert(builder.as_mut(), &mut map, &[round(1.0, 2.0), other], &known(1.0, Pose2::identity()));
    assert_eq!(given, ["scans inserted", "scans inserted"]);
}

#[test]
fn the_map_grows_to_what_is_seen_or_leaves_it_out() {
    let (mut builder, mut map) = build(&params());
    for (seconds, x) in [(0.0, 0.0), (1.0, 20.0)] {
        insert(builder.as_mut(), &mut map, &[round(seconds, 2.0)], &known(seconds, pose2(x, 0.0, 0.0)));
    }
    assert_eq!(class(&map, 2.01, 0.0), CellClass::Occupied);
    assert_eq!(class(&map, 22.01, 0.0), CellClass::Occupied);
    let rigid = OccupancyGridParams { auto_grow: false, ..params() };
    let (mut builder, mut map) = build(&rigid);
    insert(builder.as_mut(), &mut map, &[round(0.0, 2.0)], &known(0.0, Pose2::identity()));
    let before = map.grid.clone();
    let given = insert(builder.as_mut(), &mut map, &[round(1.0, 2.0)], &known(1.0, pose2(20.0, 0.0, 0.0)));
    assert_eq!(given, [Skipped::BesideTheMap.counter()]);
    assert_eq!(map.grid, before);
    let small = OccupancyGridParams { max_cells: 128 * 128, ..params() };
    let (mut builder, mut map) = build(&small);
    let (seen, estimate, trace) = ([round(0.0, 7.0)], known(0.0, Pose2::identity()), Trace::unwatched());
    let input = MapInput { seen: Seen::sorted(&seen), estimate: &estimate };
    let error = builder.insert(&mut Cx { now: Time(0), trace: &trace }, &input, &mut map).unwrap_err();
    assert!(error.to_string().contains("max_cells = 16384"), "{error}");
    // The engine hands the same scans in once more after a failure.
    let given = insert(builder.as_mut(), &mut map, &seen, &estimate);
    assert_eq!(given, INSERTED, "beams that leave a map that may not grow are cut at its edge");
    assert_eq!(map.grid.as_ref().map(Grid::width), Some(128));
    assert_eq!(class(&map, 2.5, 0.0), CellClass::Free);
}

#[test]
fn what_must_not_become_map_does_not() {
    let here = known(1.0, Pose2::identity());
    let unsure = Estimate { covariance: here.covariance * 1e5, ..here.clone() };
    let lost = Estimate { status: Status::Converging, ..here.clone() };
    let none = scan_at(1.0, Buffer::filled(181, f32::NAN));
    for (seen, estimate, expected) in [
        (round(1.0, 2.0), &unsure, Skipped::Unsure),
        (round(1.0, 2.0), &lost, Skipped::Unsure),
        (none, &here, Skipped::NoHits),
        (scan_at(1.0, Buffer::empty()), &here, Skipped::NoHits),
    ] {
        let (mut builder, mut map) = build(&params());
        assert_eq!(insert(builder.as_mut(), &mut map, &[seen], estimate), [expected.counter()]);
        assert!(map.grid.unwrap().cells.iter().all(|cell| *cell == 0.0));
    }
    let (mut builder, mut map) = build(&params());
    let invalid = Observation { valid: false, ..round(1.0, 2.0) };
    assert!(insert(builder.as_mut(), &mut map, &[invalid], &here).is_empty());
    insert(builder.as_mut(), &mut map, &[round(1.0, 2.0)], &here);
    let before = map.clone();
    let again = [round(1.0, 1.0), round(0.5, 1.0)];
    let given = insert(builder.as_mut(), &mut map, &again, &known(1.0, pose2(3.0, 0.0, 0.0)));
    assert_eq!(given, [Skipped::NotNewer.counter(); 2]);
    assert_eq!(map, before);
}

#[test]
fn a_pose_that_is_no_number_or_too_far_away_is_an_error_and_changes_nothing() {
    for x_m in [f64::NAN, f64::INFINITY, -1e300, 1e18] {
        let (mut builder, mut map) = build(&params());
        let before = map.clone();
        let trace = Trace::unwatched();
        let estimate = known(1.0, pose2(x_m, 0.0, 0.0));
        let seen = [round(1.0, 2.0)];
        let input = MapInput { seen: Seen::sorted(&seen), estimate: &estimate };
        let error = builder.insert(&mut Cx { now: Time(0), trace: &trace }, &input, &mut map).unwrap_err();
        assert!(error.to_string().contains("expected finite numbers"), "{error}");
        assert_eq!(map, before);
    }
}

#[test]
fn beams_without_an_end_free_space_only_when_they_may() {
    let open = |clear: bool, range_m: Option<f64>| {
        let wanted = OccupancyGridParams { clear_on_no_return: clear, clear_range_m: range_m, ..params() };
        let (mut builder, mut map) = build(&wanted);
        let mut ranges = vec![2.0f32; 181];
        ranges[60..120].fill(f32::INFINITY);
        let seen = [scan_at(1.0, ranges.into())];
        insert(builder.as_mut(), &mut map, &seen, &known(1.0, Pose2::identity()));
        [1.0, 2.9, 3.1].map(|x| class(&map, x, 0.0) == CellClass::Free)
    };
    assert!(!OccupancyGridParams::default().clear_on_no_return, "glass looks like nothing, too");
    assert_eq!(open(true, None), [true, true, true]);
    assert_eq!(open(true, Some(3.0)), [true, true, false]);
    assert_eq!(open(false, None), [false, false, false]);
}

#[test]
fn every_impossible_parameter_is_named() {
    let bad = OccupancyGridParams {
        resolution_m: 0.0,
        size_cells: 1001,
        start_x: 2.0,
        grow_block_cells: 0,
        update_factor_free: 0.5,
        update_factor_occupied: 1.0,
        p_min: 0.6,
        p_max: f64::NAN,
        map_update_distance_m: -1.0,
        max_range_m: -3.0,
        clear_range_m: Some(f64::NAN),
        ..OccupancyGridParams::default()
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "resolution_m",
        "max_range_m",
        "clear_range_m",
        "map_update_distance_m",
        "min_range_m",
        "start_x",
        "size_cells",
        "grow_block_cells",
        "update_factor_free",
        "update_factor_occupied",
        "p_min",
        "p_max",
    ];
    assert_eq!(keys, expected);
    let many = OccupancyGridParams { levels: 40, ..OccupancyGridParams::default() };
    assert!(many.check().iter().any(|fault| fault.path == "levels"));
    assert!(OccupancyGridParams::default().check().is_empty());
}
