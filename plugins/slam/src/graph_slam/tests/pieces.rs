//! Surfaces, the table of nearest points, registration.

use super::building::{scan, scattered, walls};
use crate::graph_slam::GraphSlamParams;
use crate::graph_slam::atlas::{Atlas, KeyFrame};
use crate::graph_slam::contradiction::{View, denied_share};
use crate::graph_slam::nearest::NearestTable;
use crate::graph_slam::registration::{Expected, RegistrationSettings, register};
use crate::graph_slam::surface::{Surface, SurfaceLimits, SurfacePoint, surface_of};
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_kit::pose_graph::RobustKernel;

const LIMITS: SurfaceLimits = SurfaceLimits::SLANTED;
const SETTINGS: RegistrationSettings =
    RegistrationSettings { across_m: 0.02, along_m: 1.0, loose_m: 0.1, gate_m: 0.2, kernel_c: 3.0 };

fn surface(scan: &LaserScan) -> Vec<SurfacePoint> {
    surface_of(scan, &Pose3::identity(), &LIMITS)
}

fn table(scan: &LaserScan) -> NearestTable {
    let mut table = NearestTable::default();
    table.fill(surface(scan).into_iter());
    table
}

fn expected(reference_from_scan: Pose2) -> Expected<'static> {
    Expected {
        reference_from_scan,
        information: Matrix3::zeros(),
        half_at: 1.0,
        first_gate_m: 0.5,
        shape: None,
        least_pairs: 0.0,
    }
}

#[test]
fn surfaces_face_the_sensor_at_right_angles_to_their_walls() {
    let pose = pose2(1.5, 1.5, 0.3);
    let points = surface(&scan(&walls(), &pose, 1));
    assert!(points.len() > 250);
    let n_flat = points.iter().filter(|point| point.is_flat()).count();
    assert!(n_flat > 180, "{n_flat}");
    let mut n_off = 0;
    for point in points.iter().filter(|point| point.is_flat()) {
        let toward = point.normal[0] * point.at[0] + point.normal[1] * point.at[1];
        assert!(toward <= 0.0, "{point:?} faces away");
        // All walls are at right angles in the map.
        let angle = f64::from(point.normal[1]).atan2(f64::from(point.normal[0])) + 0.3;
        let off = (angle / std::f64::consts::FRAC_PI_2).rem_euclid(1.0);
        n_off += usize::from(off.min(1.0 - off) > 0.15);
    }
    assert!(n_off * 20 < n_flat, "{n_off} of {n_flat}");
}

/// How far points of a wall at x = 5 m are from it (root mean square), seen with a depth camera's noise; and how many are flat.
fn rough_m(noise_growing_1_m: f32) -> (f32, usize) {
    let step_rad = 0.36f64.to_radians();
    let bearing_rad = |k: usize| (k as f64 - 80.0) * step_rad;
    let mut rng = rumbo_core::rng::stream(7, "noise");
    let mut reading_m = |k: usize| {
        let range_m = 5.0 / bearing_rad(k).cos();
        let noise: f64 = StandardNormal.sample(&mut rng);
        (range_m + noise * 0.0015 * range_m * range_m) as f32
    };
    let scan = LaserScan {
        first_bearing_rad: bearing_rad(0),
        bearing_step_rad: step_rad,
        max_range_m: 8.0,
        ranges_m: (0..161).map(&mut reading_m).collect::<Vec<_>>().into(),
        ..LaserScan::default()
    };
    let limits = SurfaceLimits { noise_growing_1_m, ..SurfaceLimits::SLANTED };
    let points = surface_of(&scan, &Pose3::identity(), &limits);
    let sum: f32 = points.iter().map(|point| (point.at[0] - 5.0).powi(2)).sum();
    ((sum / points.len() as f32).sqrt(), points.iter().filter(|point| point.is_flat()).count())
}

#[test]
fn points_of_a_noisy_wall_are_moved_onto_it() {
    let ((raw_m, n_raw), (moved_m, n_moved)) = (rough_m(0.0), rough_m(0.0015));
    assert!(raw_m > 0.02 && moved_m < 0.5 * raw_m, "{raw_m} m as read, {moved_m} m when moved");
    assert!(n_moved > 150 && n_moved > n_raw, "{n_raw} of 161 are flat as read, {n_moved} when moved");
}

#[test]
fn readings_that_are_none_make_no_points() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 0.05, 99.0];
    let scan = LaserScan {
        bearing_step_rad: 0.1,
        max_range_m: 50.0,
        ranges_m: odd.to_vec().into(),
        ..LaserScan::default()
    };
    assert!(surface(&scan).is_empty());
    assert!(surface(&LaserScan::default()).is_empty());
    assert!(table(&LaserScan::default()).at([0.0, 0.0]).is_none());
}

#[test]
fn the_nearest_point_is_that_of_brute_force_to_within_a_square() {
    let table = table(&scan(&walls(), &pose2(6.0, 1.5, 2.0), 5));
    let distance = |at: [f32; 2], point: &SurfacePoint| (point.at[0] - at[0]).hypot(point.at[1] - at[1]);
    for k in 0..4000 {
        let at = [18.0 * scattered(k) as f32, 14.0 * scattered(3 * k + 1) as f32];
        let best = table.points().iter().map(|point| distance(at, point)).fold(f32::INFINITY, f32::min);
        match table.at(at) {
            Some(found) => assert!(distance(at, found) <= best + 0.142, "{at:?}"),
            None => assert!(best > 0.42, "{at:?}: {best}"),
        }
    }
}

#[test]
fn a_scan_is_put_back_where_it_was_taken() {
    let walls = walls();
    for k in 0..40 {
        let first = pose2(1.5 + 0.4 * k as f64, 1.5 + 0.5 * scattered(k), scattered(5 * k));
        let moved = pose2(0.3 * scattered(k + 3), 0.3 * scattered(k + 9), 0.3 * scattered(k + 14));
        let (reference, other) = (scan(&walls, &first, k), scan(&walls, &(first * moved), k + 100));
        let found =
            register(&table(&reference), &surface(&other), &expected(Pose2::identity()), &SETTINGS).unwrap();
        let off = moved.inverse() * found.reference_from_scan;
        let (off_m, off_rad) = (off.translation.vector.norm(), off.rotation.angle().abs());
        assert!(off_m < 0.015 && off_rad < 0.005, "{k}: {off_m} m, {off_rad} rad");
        assert!(found.overlap > 0.8 && found.agreement > 0.7, "{k}: {found:?}");
    }
}

#[test]
fn a_corridor_says_nothing_of_the_way_along_it() {
    let corridor = [[-500.0, -1.0, 500.0, -1.0], [-500.0, 1.0, 500.0, 1.0]];
    let reference = scan(&corridor, &pose2(0.0, 0.0, 0.0), 1);
    let other = surface(&scan(&corridor, &pose2(0.3, 0.1, 0.05), 2));
    let known = Matrix3::from_diagonal(&Vector3::new(1e5, 1e-3, 1e-3));
    let guess = Expected { information: known, ..expected(pose2(0.3, 0.0, 0.0)) };
    let found = register(&table(&reference), &other, &guess, &SETTINGS).unwrap();
    let pose = found.reference_from_scan;
    assert!((pose.translation.x - 0.3).abs() < 0.01, "as expected: {}", pose.translation.x);
    assert!((pose.translation.y - 0.1).abs() < 0.01 && (pose.rotation.angle() - 0.05).abs() < 0.01);
    assert!(found.information[(0, 0)] < 0.02 * found.information[(1, 1)], "{}", found.information);
}

/// Something small stands in a corridor, and 0.2 m farther in the other scan, whichever way both look: believed, it pulls.
#[test]
fn few_pairs_do_not_pull_a_scan_along_a_corridor() {
    let corridor = |post_m: f64| {
        [
            [-500.0, -1.0, 500.0, -1.0],
            [-500.0, 1.0, 500.0, 1.0],
            [post_m, -0.2, post_m, 0.2],
            [post_m, 0.2, post_m + 1.0, 0.2],
            [post_m, -0.2, post_m + 1.0, -0.2],
        ]
    };
    for (first_rad, second_rad) in [(0.0, 0.0), (0.4, -0.385), (-0.4, 0.385), (-1.5, -1.0)] {
        let [first, second] = [first_rad, second_rad].map(|yaw_rad| pose2(0.0, 0.1, yaw_rad));
        let reference = table(&scan(&corridor(2.0), &first, 1));
        let other = Surface::of(&scan(&corridor(2.2), &second, 2), &Pose3::identity(), &LIMITS);
        let first_from_second = first.inverse() * second;
        let moved_m = |least_pairs: f64| {
            let guess = Expected { shape: other.shape.as_ref(), least_pairs, ..expected(first_from_second) };
            let found = register(&reference, &other, &guess, &SETTINGS).unwrap();
            (first * found.reference_from_scan * second.inverse()).translation.x
        };
        let (believed_m, held_m) = (moved_m(0.0), moved_m(25.0));
        assert!(believed_m.abs() > 0.1, "{first_rad} {second_rad}: {believed_m}");
        assert!(held_m.abs() < 0.02, "{first_rad} {second_rad}: {held_m}");
    }
}

#[test]
fn nothing_to_register_on_is_no_place() {
    let points = surface(&scan(&walls(), &pose2(1.5, 1.5, 0.0), 1));
    let nowhere = register(&NearestTable::default(), &points, &expected(Pose2::identity()), &SETTINGS);
    assert_eq!(nowhere, None);
    let far_off = register(
        &table(&scan(&walls(), &pose2(1.5, 1.5, 0.0), 2)),
        &points,
        &expected(pose2(500.0, 0.0, 0.0)),
        &SETTINGS,
    );
    assert_eq!(far_off, None);
}

#[test]
fn scans_deny_each_other_where_they_are_said_to_be_from_another_place() {
    let walls = walls();
    for k in 0..12 {
        let (first, moved) = (pose2(3.0 + 0.5 * k as f64, 1.5, 0.2), pose2(0.2, -0.1, 0.15));
        let scans = [scan(&walls, &first, k), scan(&walls, &(first * moved), k + 50)];
        let surfaces = [0, 1].map(|idx: usize| Surface { points: surface(&scans[idx]), shape: None });
        let mount = Pose3::identity();
        let view = |idx: usize| View { scan: &scans[idx], base_from_sensor: &mount, surface: &surfaces[idx] };
        let here = denied_share(&view(0), &view(1), &moved);
        // Along the corridor, whose walls are the same there.
        let along = (first.inverse() * pose2(6.0, 0.0, 0.0) * first).translation.vector;
        let elsewhere = pose2(moved.translation.x + along.x, moved.translation.y + along.y, 0.15);
        let there = denied_share(&view(0), &view(1), &elsewhere);
        assert!(here < 0.03 && there > 0.05, "{k}: {here} at the place, {there} away from it");
        assert_eq!(
            denied_share(&view(0), &view(1), &moved),
            denied_share(&view(1), &view(0), &moved.inverse())
        );
    }
}

/// A key frame of a scan by a sensor at the robot's middle.
fn key_frame(scan: LaserScan) -> KeyFrame {
    KeyFrame {
        surface: Surface { points: surface(&scan), shape: None },
        scan,
        base_from_sensor: Pose3::identity(),
        is_guessed: false,
    }
}

/// Two corridors that are alike, but in one of them a wall leaves no more than a gap.
#[test]
fn a_loop_is_none_where_one_scan_saw_what_the_other_saw_through() {
    let open = [[-20.0, -1.5, 20.0, -1.5], [-20.0, 1.5, 20.0, 1.5], [8.0, -1.5, 8.0, 1.5]];
    let shut = [open[0], open[1], open[2], [0.6, -1.3, 0.6, 1.5]];
    let here = pose2(0.0, 0.0, 0.0);
    for (walls, is_tied) in [(&open[..], true), (&shut[..], false)] {
        let mut atlas = Atlas::new(GraphSlamParams::default().tracker().tie);
        atlas.settings.least_overlap = 0.2;
        atlas.add(key_frame(scan(&open, &here, 1)), &here, None).unwrap();
        atlas.add(key_frame(scan(walls, &here, 2)), &here, Some((0, here))).unwrap();
        assert_eq!(atlas.tie(0, 1, &here, 0.4, true), is_tied, "{walls:?}");
        atlas.tried.clear();
        assert!(atlas.tie(0, 1, &here, 0.4, false), "frames of one visit are tied in any case");
    }
}

#[test]
fn what_the_gyroscope_says_of_a_turn_counts_by_its_error_and_is_no_way() {
    let mut atlas = Atlas::new(GraphSlamParams::default().tracker().tie);
    let by_wheels = pose2(0.3, 0.0, 0.5);
    atlas.add(key_frame(LaserScan::default()), &Pose2::identity(), None).unwrap();
    atlas.add(key_frame(LaserScan::default()), &by_wheels, None).unwrap();
    let off_rad = atlas.settings.off_by_gyroscope_rad(0.4, 0.5);
    assert!(
        (off_rad.to_degrees() - (0.1 + 0.3 * 0.5 + 0.01 * 0.4f64.to_degrees())).abs() < 1e-9,
        "{off_rad}"
    );
    atlas.bind_turn(0, 1, 0.4, off_rad);
    assert!(atlas.ways_from(0, 100.0)[1].is_infinite(), "a turn tells no way");
    let by_scans = Matrix3::from_diagonal(&Vector3::new(1e4, 1e4, (2.0 * off_rad).powi(-2)));
    atlas.bind(0, 1, pose2(0.31, 0.0, 0.41), by_scans, RobustKernel::Cauchy { c: 3.0 });
    assert!((atlas.ways_from(0, 100.0)[1] - (0.31 + 0.5 * 0.41)).abs() < 1e-5);
    atlas.optimize(20);
    let (pose, expected_rad) = (atlas.pose(1), 0.8 * 0.4 + 0.2 * 0.41);
    assert!((pose.translation.x - 0.31).abs() < 1e-3, "{pose}");
    assert!((pose.rotation.angle() - expected_rad).abs() < 1e-3, "{pose}, expected {expected_rad} rad");
}

#[test]
fn strain_is_the_worst_of_the_newest_ties_in_deviations_squared() {
    let mut atlas = Atlas::new(GraphSlamParams::default().tracker().tie);
    for x_m in [0.0, 1.0, 2.0] {
        atlas.add(key_frame(LaserScan::default()), &pose2(x_m, 0.0, 0.0), None).unwrap();
    }
    let information = Matrix3::from_diagonal(&Vector3::new(100.0, 25.0, 400.0));
    // Five deviations off along x; then two across and one in turn.
    atlas.bind(0, 1, pose2(1.5, 0.0, 0.0), information, RobustKernel::Quadratic);
    atlas.bind(1, 2, pose2(1.0, 0.4, 0.05), information, RobustKernel::Cauchy { c: 1.0 });
    atlas.bind(0, 2, pose2(2.0, 0.0, 0.0), information, RobustKernel::Quadratic);
    let turned = atlas.strain_since(1);
    assert!((atlas.strain_since(0) - 25.0).abs() < 1e-9 && (3.0..6.0).contains(&turned), "{turned}");
    assert_eq!([atlas.strain_since(2), atlas.strain_since(3)], [0.0; 2]);
}
