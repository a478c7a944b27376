//! The fast scan against its definition.

use super::*;
use nalgebra::UnitQuaternion;
use rumbo_core::rng::stream;
use std::f64::consts::PI;

/// Both scans of a random picture.
fn compare(rays: &Rays, turn: [f64; 3], limits: &ScanLimits, beams: Beams, rng: &mut Rng) {
    let counts = random_picture(rays.n_pixels(), rng);
    let level_from_camera = UnitQuaternion::from_euler_angles(turn[0], turn[1], turn[2]);
    let face = (&level_from_camera, 0.6);
    let exact = slow::scan_slowly(rays, millimeters(&counts), face, limits, &beams).unwrap();
    let mut scan = VirtualScan::new(rays.clone(), limits.clone(), beams).unwrap();
    scan.face(&level_from_camera, 0.6);
    let mut ranges_m = vec![0.0; exact.len()];
    let scanned = scan.scan(millimeters(&counts), &mut ranges_m).unwrap();
    for (beam, (range_m, (bearing_rad, exact_m))) in ranges_m.iter().zip(&exact).enumerate() {
        assert_eq!(scan.bearings_rad()[beam], *bearing_rad);
        let range_m = f64::from(*range_m);
        let same =
            (range_m.is_nan() && exact_m.is_nan()) || range_m == *exact_m || (range_m - exact_m).abs() < 1e-6;
        assert!(same, "beam {beam} of {beams:?}, turned by {turn:?}: {range_m}, expected {exact_m}");
    }
    let n_columns = rays.n_columns();
    let looked_at = limits.rows.clone().unwrap_or(0..rays.n_rows());
    let inside = &counts[looked_at.start * n_columns..looked_at.end * n_columns];
    assert_eq!(scanned.n_valid, inside.iter().filter(|count| **count > 0).count());
    assert_eq!(scanned.n_seen, exact.iter().filter(|(_, range_m)| range_m.is_finite()).count());
}

#[test]
fn fast_scans_are_those_of_the_definition_however_the_camera_is_held() {
    let mut rng = stream(5, "scans");
    for (columns, rows) in [(1, 1), (9, 5), (70, 20), (64, 48)] {
        let rays = camera(columns, rows);
        let limits = ScanLimits { heights_m: [0.05, 0.9], ranges_m: [1.0, 4.0], rows: None };
        let some_rows = ScanLimits { rows: Some(rows as usize / 3..rows as usize / 2 + 1), ..limits.clone() };
        let around = Beams::Uniform { first_bearing_rad: -PI, bearing_step_rad: PI / 50.0, n_beams: 100 };
        let turns = [
            [0.0, 0.0, 0.0],
            [0.0, 0.3, 0.0],
            [0.4, -0.2, 0.0],
            [0.0, 0.0, 1.2],
            [0.1, 0.2, 3.0],
            [-1.5, 0.9, -2.0],
        ];
        for turn in turns {
            for limits in [&limits, &some_rows] {
                compare(&rays, turn, limits, Beams::PerColumn, &mut rng);
                compare(&rays, turn, limits, Beams::over(&rays), &mut rng);
                compare(&rays, turn, limits, around, &mut rng);
            }
        }
    }
}

/// A wall straight ahead: its range at each bearing is `1.5 / cos`, also for a camera that looks down or is rolled.
#[test]
fn a_wall_has_the_same_ranges_however_the_camera_is_held() {
    let rays = camera(320, 240);
    let limits = ScanLimits { heights_m: [0.2, 1.0], ranges_m: [0.2, 5.0], rows: None };
    let step_rad = 0.01;
    let beams =
        Beams::Uniform { first_bearing_rad: -20.0 * step_rad, bearing_step_rad: step_rad, n_beams: 41 };
    for turn in [[0.0, 0.0], [0.0, 0.25], [0.3, 0.1], [-0.3, -0.15]] {
        let level_from_camera = UnitQuaternion::from_euler_angles(turn[0], turn[1], 0.0);
        let depths_m: Vec<f32> = (0..rays.n_pixels())
            .map(|pixel| {
                let ray = rays.point(pixel % 320, pixel / 320, 1.0).unwrap();
                (1.5 / (level_from_camera * nalgebra::Vector3::from(ray)).x) as f32
            })
            .collect();
        let mut scan = VirtualScan::new(rays.clone(), limits.clone(), beams).unwrap();
        scan.face(&level_from_camera, 0.6);
        let mut ranges_m = [0.0; 41];
        scan.scan(Depths::Meters(&depths_m), &mut ranges_m).unwrap();
        for (range_m, bearing_rad) in ranges_m.iter().zip(scan.bearings_rad()) {
            // A beam is as wide as its step, and the nearest thing in it is told.
            let nearest_m = 1.5 / (bearing_rad.abs() - step_rad / 2.0).max(0.0).cos();
            let at_most_m = 1.5 / bearing_rad.cos() + 1e-4;
            let range_m = f64::from(*range_m);
            assert!(range_m >= nearest_m - 1e-5 && range_m <= at_most_m, "{turn:?} {bearing_rad}: {range_m}");
        }
    }
}

#[test]
fn a_turn_that_comes_again_gives_the_same_scan() {
    let (rays, mut rng) = (camera(64, 48), stream(6, "turns"));
    let counts = random_picture(rays.n_pixels(), &mut rng);
    let limits = ScanLimits { heights_m: [0.05, 0.9], ranges_m: [1.0, 4.0], rows: None };
    let mut scan = VirtualScan::new(rays.clone(), limits, Beams::over(&rays)).unwrap();
    let mut at = |pitch_rad: f64| {
        scan.face(&UnitQuaternion::from_euler_angles(0.0, pitch_rad, 0.0), 0.5);
        let mut ranges_m = vec![0.0_f32; scan.bearings_rad().len()];
        scan.scan(millimeters(&counts), &mut ranges_m).unwrap();
        ranges_m.iter().map(|range_m| range_m.to_bits()).collect::<Vec<u32>>()
    };
    let (level, down) = (at(0.0), at(0.2));
    assert_ne!(level, down);
    assert_eq!((at(0.0), at(0.2), at(0.2)), (level, down.clone(), down));
}

#[test]
fn even_beams_over_the_columns_leave_none_empty_and_are_symmetric() {
    let linear = Rays::linear_angle(64, 48, [0.5, 0.4], Counting::FromZero).unwrap();
    for rays in [camera(1, 1), camera(2, 2), camera(64, 48), camera(640, 2), camera(513, 2), linear] {
        let beams = Beams::over(&rays);
        let counts = vec![1000; rays.n_pixels()];
        let limits = ScanLimits { heights_m: [-9.0, 9.0], ranges_m: [0.2, 5.0], rows: None };
        let mut scan = VirtualScan::new(rays.clone(), limits, beams).unwrap();
        let mut ranges_m = vec![0.0; scan.bearings_rad().len()];
        let scanned = scan.scan(millimeters(&counts), &mut ranges_m).unwrap();
        assert_eq!(scanned.n_seen, ranges_m.len(), "{} columns", rays.n_columns());
        assert!(ranges_m.len() >= (rays.n_columns() * 3).div_ceil(5), "{} beams", ranges_m.len());
        let bearings_rad = scan.bearings_rad();
        for (one, other) in bearings_rad.iter().zip(bearings_rad.iter().rev()) {
            assert!((one + other).abs() < 1e-9);
        }
    }
}

#[test]
fn impossible_scans_are_refused() {
    let rays = camera(4, 3);
    let good = ScanLimits { heights_m: [0.0, 1.0], ranges_m: [0.1, 4.0], rows: None };
    let new = |limits: &ScanLimits, beams| VirtualScan::new(rays.clone(), limits.clone(), beams);
    for bad in [
        ScanLimits { heights_m: [1.0, 1.0], ..good.clone() },
        ScanLimits { heights_m: [f64::NAN, 1.0], ..good.clone() },
        ScanLimits { ranges_m: [-0.1, 1.0], ..good.clone() },
        ScanLimits { ranges_m: [0.1, f64::INFINITY], ..good.clone() },
        ScanLimits { rows: Some(2..2), ..good.clone() },
        ScanLimits { rows: Some(0..4), ..good.clone() },
    ] {
        assert!(matches!(new(&bad, Beams::PerColumn), Err(ScanError::Limits { .. })), "{bad:?}");
    }
    for (first_bearing_rad, bearing_step_rad, n_beams) in [
        (0.0, 0.1, 0),
        (0.0, 0.1, 64),
        (0.0, -0.1, 3),
        (9.0, 0.1, 3),
        (0.0, f64::NAN, 3),
        (0.0, 1e-5, 40_000),
    ] {
        let beams = Beams::Uniform { first_bearing_rad, bearing_step_rad, n_beams };
        assert!(matches!(new(&good, beams), Err(ScanError::Beams { .. })), "{beams:?}");
    }
    let mut scan = new(&good, Beams::PerColumn).unwrap();
    assert!(scan.scan(millimeters(&[1; 11]), &mut [0.0; 4]).is_err());
    assert!(scan.scan(millimeters(&[1; 12]), &mut [0.0; 5]).is_err());
}
