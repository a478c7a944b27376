//! Points, nearest points and medians against their definitions.

use super::*;
use rumbo_core::frames::Pose3;
use rumbo_core::messages::Intrinsics;
use rumbo_core::rng::stream;

#[test]
fn points_are_those_of_the_formulas_whatever_the_size() {
    let mut rng = stream(1, "points");
    for (columns, rows) in [(1, 1), (7, 3), (16, 2), (33, 5), (64, 48), (101, 4)] {
        let rays = camera(columns, rows);
        let counts = random_picture(rays.n_pixels(), &mut rng);
        let meters: Vec<f32> = counts.iter().map(|count| f32::from(*count) * 0.001).collect();
        let mount = Pose3::new(nalgebra::Vector3::new(0.1, 0.0, 0.6), nalgebra::Vector3::new(0.03, 0.2, 0.5));
        let band = HeightBand::of_mount(&mount, [0.05, 0.9]);
        for depths in [millimeters(&counts), Depths::Meters(&meters)] {
            for band in [None, Some(&band)] {
                let mut found = vec![[9.0; 3]; rays.n_pixels()];
                let counted = points(&rays, depths, 4.0, band, &mut found).unwrap();
                let (mut n_valid, mut n_kept) = (0, 0);
                for (pixel, point) in found.iter().enumerate() {
                    n_valid += usize::from(depths.get(pixel, 4.0).is_some());
                    let exact = slow::point_slowly(&rays, depths, 4.0, band, pixel);
                    if let (Some(band), Some(depth_m)) = (band, depths.get(pixel, 4.0)) {
                        let any =
                            rays.point(pixel % columns as usize, pixel / columns as usize, depth_m.into());
                        let height_m = band.height_m(any.unwrap());
                        if band.heights_m.iter().any(|limit_m| (height_m - limit_m).abs() < 1e-6) {
                            n_kept += usize::from(!point[0].is_nan());
                            continue;
                        }
                    }
                    match exact {
                        Some(exact) => {
                            n_kept += 1;
                            let off = (0..3).map(|k| (f64::from(point[k]) - exact[k]).abs());
                            assert!(off.fold(0.0, f64::max) < 1e-6, "{point:?} {exact:?}");
                        }
                        None => assert!(point.iter().all(|v| v.is_nan()), "{point:?}"),
                    }
                }
                assert_eq!(counted, Counted { n_valid, n_kept });
            }
        }
    }
}

/// `h + Y cos p + Z sin p`, and a floor that a level camera sees from 0.76 m on (specification, section 4.4).
#[test]
fn the_floor_does_not_count() {
    let half = [28.5_f64.to_radians(), 21.5_f64.to_radians()];
    let rays = Rays::pinhole(&pinhole_of_view(640, 480, half)).unwrap();
    let floor_m = 0.30 / -rays.up()[479];
    assert!((floor_m - 0.76).abs() < 0.005, "{floor_m}");
    for up_rad in [0.0, 0.1, -0.2] {
        let band = HeightBand::of_pitch(0.30, up_rad, [0.05, 0.40]);
        // A mount that looks up turns about its y axis the negative way.
        let turn = nalgebra::Vector3::new(0.0, -up_rad, 0.0);
        let mount = Pose3::new(nalgebra::Vector3::new(0.0, 0.0, 0.30), turn);
        let same = HeightBand::of_mount(&mount, [0.05, 0.40]);
        let floor: Vec<f32> = rays
            .up()
            .iter()
            .flat_map(|up| {
                let rise = up * up_rad.cos() + up_rad.sin();
                let depth_m = if rise < 0.0 { (-0.30 / rise) as f32 } else { f32::NAN };
                vec![depth_m; 640]
            })
            .collect();
        let mut points_m = vec![[0.0; 3]; rays.n_pixels()];
        let counted = points(&rays, Depths::Meters(&floor), 30.0, Some(&band), &mut points_m).unwrap();
        assert!(counted.n_valid > 60_000 && counted.n_kept == 0, "{counted:?}");
        let point_m = [0.3, -0.4, 0.5];
        let expected_m = 0.30 + 0.5 * up_rad.cos() + 0.3 * up_rad.sin();
        assert!((band.height_m(point_m) - expected_m).abs() < 1e-12);
        assert!((same.height_m(point_m) - expected_m).abs() < 1e-12);
    }
}

#[test]
fn the_nearest_point_is_that_of_a_search_through_all_of_them() {
    let mut rng = stream(2, "closest");
    for n_columns in [1, 5, 31, 32, 33, 64] {
        for n_rows in [1, 3, 11] {
            let points_m: Vec<[f32; 3]> = (0..n_columns * n_rows)
                .map(|_| {
                    // Few values, so that there are ties.
                    let mut draw = || f32::from(rng.random_range(1..4_u8));
                    let point = [draw(), draw(), draw()];
                    if rng.random::<f64>() < 0.3 { [f32::NAN; 3] } else { point }
                })
                .collect();
            for single_row in (0..n_rows).map(Some).chain([None]) {
                let found = closest(&points_m, n_columns, single_row);
                let mut best: Option<(f64, usize)> = None;
                let mut n_valid = 0;
                for (pixel, [x, y, _]) in points_m.iter().enumerate() {
                    if single_row.is_some_and(|row| row != pixel / n_columns) || x.is_nan() {
                        continue;
                    }
                    n_valid += 1;
                    let planar_m = f64::from(*x).hypot(f64::from(*y));
                    if best.is_none_or(|(least_m, _)| planar_m < least_m) {
                        best = Some((planar_m, pixel));
                    }
                }
                assert_eq!(found.n_valid, n_valid);
                let told = found.point.map(|point| (point.planar_m, point.row * n_columns + point.column));
                assert_eq!(told, best);
            }
        }
    }
}

#[test]
fn a_blind_camera_has_no_nearest_point_and_says_how_little_it_saw() {
    assert_eq!(closest(&[[f32::NAN; 3]; 100], 10, None), Closest { point: None, n_valid: 0 });
    assert_eq!(closest(&[], 0, None), Closest { point: None, n_valid: 0 });
    assert_eq!(closest(&[[1.0; 3]; 4], 2, Some(7)).n_valid, 0, "no such row");
    let left = closest(&[[1.0, 1.0, 0.2]], 1, None).point.unwrap();
    assert!((left.bearing_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-7, "left is positive");
}

/// Sorts each window.
fn median_slowly(n_columns: usize, counts: &[u16]) -> Vec<u16> {
    let n_rows = counts.len() / n_columns;
    let median = |pixel: usize| {
        let (column, row) = (pixel % n_columns, pixel / n_columns);
        let mut window: Vec<u16> = (row.saturating_sub(1)..(row + 2).min(n_rows))
            .flat_map(|row| (column.saturating_sub(1)..(column + 2).min(n_columns)).map(move |c| (row, c)))
            .map(|(row, column)| counts[row * n_columns + column])
            .filter(|count| *count > 0)
            .collect();
        window.sort_unstable();
        if counts[pixel] == 0 { 0 } else { window[(window.len() - 1) / 2] }
    };
    (0..counts.len()).map(median).collect()
}

#[test]
fn medians_are_those_of_sorted_windows() {
    let mut rng = stream(3, "median");
    let mut filter = MedianFilter::default();
    for n_columns in [1, 2, 3, 31, 32, 33, 63, 64, 65, 100] {
        for n_rows in [1, 2, 7] {
            let counts: Vec<u16> = (0..n_columns * n_rows).map(|_| rng.random_range(0..9) * 7281).collect();
            let mut filtered = vec![1; counts.len()];
            filter.filter(n_columns, &counts, &mut filtered).unwrap();
            assert_eq!(filtered, median_slowly(n_columns, &counts), "{n_columns} x {n_rows}");
        }
    }
    assert!(filter.filter(3, &[0; 7], &mut [0; 7]).is_err());
    assert!(filter.filter(0, &[0; 7], &mut [0; 7]).is_err());
    assert!(filter.filter(7, &[0; 7], &mut [0; 6]).is_err());
}

/// Holes, nothing at all, not-a-number, one pixel: no panic, and nothing that is not there.
#[test]
fn odd_pictures_are_survived() {
    let odd = [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-30, f32::MAX, 1.0];
    let mut rng = stream(4, "odd");
    for (columns, rows) in [(1, 1), (1, 9), (13, 1), (40, 30)] {
        let rays = camera(columns, rows);
        for fill in 0..=odd.len() {
            let mut draw = || *odd.get(fill).unwrap_or(&odd[rng.random_range(0..odd.len())]);
            let depths_m: Vec<f32> = (0..rays.n_pixels()).map(|_| draw()).collect();
            let depths = Depths::Meters(&depths_m);
            let mut points_m = vec![[0.0; 3]; rays.n_pixels()];
            let band = HeightBand::of_pitch(0.3, 0.0, [-1e9, 1e9]);
            let counted = points(&rays, depths, f32::INFINITY, Some(&band), &mut points_m).unwrap();
            let n_readings = depths_m.iter().filter(|m| **m > 0.0 && **m < 1e9).count();
            assert_eq!(counted.n_valid, n_readings);
            assert!(points_m.iter().flatten().all(|v| !v.is_infinite()));
            assert_eq!(closest(&points_m, columns as usize, None).point.is_some(), counted.n_kept > 0);
            for beams in [Beams::PerColumn, Beams::over(&rays)] {
                let limits = ScanLimits { heights_m: [0.05, 0.5], ranges_m: [0.1, 4.0], rows: None };
                let mut scan = VirtualScan::new(rays.clone(), limits, beams).unwrap();
                for tilt_rad in [0.0, 0.3, 1.5] {
                    let turn = nalgebra::UnitQuaternion::from_euler_angles(tilt_rad, tilt_rad, 0.0);
                    scan.face(&turn, 0.3);
                    let mut ranges_m = vec![0.0; scan.bearings_rad().len()];
                    let scanned = scan.scan(depths, &mut ranges_m).unwrap();
                    assert_eq!(scanned.n_valid, n_readings);
                    let is_sound = |m: &f32| !m.is_finite() || (0.1..=4.0).contains(m);
                    assert!(ranges_m.iter().all(is_sound), "{ranges_m:?}");
                }
            }
        }
    }
}

#[test]
fn wrong_sizes_and_cameras_are_said() {
    let rays = camera(4, 3);
    let short = points(&rays, millimeters(&[1; 11]), 4.0, None, &mut [[0.0; 3]; 12]);
    assert_eq!(short.unwrap_err().to_string(), "a depth picture of 11 elements where the camera has 12");
    assert!(points(&rays, millimeters(&[1; 12]), 4.0, None, &mut [[0.0; 3]; 13]).is_err());
    let good = Intrinsics { width: 4, height: 3, focal_px: [5.0; 2], center_px: [1.0; 2] };
    assert!(Rays::pinhole(&good).is_ok());
    for bad in [
        Intrinsics { width: 0, ..good },
        Intrinsics { height: 20_000, ..good },
        Intrinsics { focal_px: [0.0, 5.0], ..good },
        Intrinsics { focal_px: [5.0, -5.0], ..good },
        Intrinsics { focal_px: [f64::NAN, 5.0], ..good },
        Intrinsics { center_px: [f64::INFINITY, 5.0], ..good },
    ] {
        assert!(Rays::pinhole(&bad).is_err(), "{bad:?}");
    }
    for half_angles_rad in [[0.0, 0.3], [0.3, 1.6], [f64::NAN, 0.3]] {
        let told = Rays::linear_angle(4, 3, half_angles_rad, Counting::FromZero);
        assert!(matches!(told, Err(RaysError::View { .. })));
    }
}
