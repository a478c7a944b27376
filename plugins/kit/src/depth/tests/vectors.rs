//! Known answers of the sources.

use super::*;
use nalgebra::{UnitQuaternion, Vector3};
use rumbo_core::messages::Intrinsics;

const NEAR_M: f64 = 0.2;
const AMPLITUDE_M: f64 = 3.3;

#[test]
fn counts_of_two_channels_are_the_meters_of_the_table() {
    let mut n = 0;
    for line in data!("dc_depth_decode.csv").lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|field| field.trim().parse().unwrap()).collect();
        let [red, green, raw, unit_range_m, millimeter_m] = fields[..] else { panic!("{line}") };
        let decoded = channels_to_raw(red as u8, green as u8);
        assert_eq!(f64::from(decoded), raw, "{line}");
        for (scale, expected_m) in
            [(DepthScale::UnitRange, unit_range_m), (DepthScale::Millimeter, millimeter_m)]
        {
            match scale.raw_to_m(decoded, NEAR_M, AMPLITUDE_M) {
                Some(depth_m) => assert!((depth_m - expected_m).abs() < 1e-6, "{line}: {depth_m}"),
                None => assert!(expected_m.is_nan(), "{line}"),
            }
        }
        n += 1;
    }
    assert_eq!(n, 8);
    assert_eq!(channels_to_raw(32, 0), 0, "more than 13 bits is no reading");
    assert_eq!(DepthScale::Millimeter.raw_to_m(RAW_MAX + 1, NEAR_M, AMPLITUDE_M), None);
}

/// The buffer of the simulated v1, which the printed cases of the source come from as well.
#[test]
fn what_is_nearer_than_the_near_plane_stays_there_and_what_is_too_far_is_no_reading() {
    let mut depths_m = Vec::new();
    let odd = [0.0, 0.5, 1.0, -0.01, -7.0, 1.01, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    DepthScale::unit_to_meters(&odd, NEAR_M, AMPLITUDE_M, 3.3, &mut depths_m);
    assert_eq!(depths_m[..2], [0.2, 1.85]);
    assert!(depths_m[2].is_nan(), "3.5 m is beyond 3.3 m");
    assert_eq!(depths_m[3..5], [0.2, 0.2]);
    assert!(depths_m[5..].iter().all(|depth_m| depth_m.is_nan()), "{depths_m:?}");
    DepthScale::Millimeter.raw_to_meters(
        &[0, 1, 199, 200, 4500, 4501, 9000],
        NEAR_M,
        0.0,
        4.5,
        &mut depths_m,
    );
    assert_eq!(depths_m[1..5], [0.2, 0.2, 0.2, 4.5]);
    assert!(depths_m[0].is_nan() && depths_m[5].is_nan() && depths_m[6].is_nan(), "{depths_m:?}");
}

#[derive(serde::Deserialize)]
struct MedianCase {
    input: Vec<Vec<u16>>,
    decoded_then_filtered: Vec<Vec<u16>>,
    per_channel_wrong: Vec<Vec<u16>>,
}

#[test]
fn the_median_is_that_of_decoded_depths_and_not_of_channels() {
    let case: MedianCase = toml::from_str(data!("dc_median_filter.toml")).unwrap();
    let counts = case.input.concat();
    let mut filtered = vec![7; counts.len()];
    MedianFilter::default().filter(case.input[0].len(), &counts, &mut filtered).unwrap();
    assert_eq!(filtered, case.decoded_then_filtered.concat());
    assert_ne!(filtered, case.per_channel_wrong.concat());
}

/// The three situations with a real sensor, Valverde Moreno (2015), section 5.3, with the source's own counting.
#[test]
fn the_nearest_points_are_those_of_the_printed_cases() {
    let file: toml::Table = toml::from_str(data!("dc_sensor_cases.toml")).unwrap();
    let rays =
        Rays::linear_angle(64, 48, [28.5_f64.to_radians(), 21.5_f64.to_radians()], Counting::OneOff).unwrap();
    let cases = file["case"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let number = |part: &str, key: &str| {
            let value = &case[part][key];
            value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap()
        };
        let (column, row) = (number("input", "column") as usize - 1, 48 - number("input", "row") as usize);
        let mut raw = vec![RAW_MAX; 64 * 48];
        raw[row * 64 + column] =
            channels_to_raw(number("input", "red") as u8, number("input", "green") as u8);
        assert_eq!(f64::from(raw[row * 64 + column]), number("input", "raw_depth"));
        let (mut depths_m, mut points_m) = (Vec::new(), vec![[0.0; 3]; 64 * 48]);
        DepthScale::UnitRange.raw_to_meters(&raw, NEAR_M, AMPLITUDE_M, 4.5, &mut depths_m);
        points(&rays, Depths::Meters(&depths_m), 4.5, None, &mut points_m).unwrap();
        let nearest = closest(&points_m, 64, None).point.unwrap();
        assert_eq!((nearest.column, nearest.row), (column, row));
        let near = |found: f64, key: &str| {
            let expected = number("point", key);
            assert!((found - expected).abs() < 1e-6, "{key}: {found}, expected {expected}");
        };
        let [z, x, y] = nearest.point_m.map(f64::from);
        near(x, "X");
        near(y, "Y");
        near(z, "Z");
        near(nearest.planar_m, "planar_distance");
        near(nearest.bearing_rad, "bearing");
        near(rays.up()[row].atan(), "row_angle");
        near(rays.bearing_rad(column).unwrap(), "column_angle");
    }
}

/// The errors of evenly spaced angles that section 4.4 of the specification names, and the shift of its counting.
#[test]
fn evenly_spaced_angles_are_wrong_by_what_is_known() {
    let worst_deg = |columns: u32, half_x_deg: f64, half_y_deg: f64| {
        let half = [half_x_deg.to_radians(), half_y_deg.to_radians()];
        let right = Rays::pinhole(&pinhole_of_view(columns, 10, half)).unwrap();
        let source = Rays::linear_angle(columns as usize, 10, half, Counting::FromZero).unwrap();
        let off = (0..columns as usize)
            .map(|column| right.bearing_rad(column).unwrap() - source.bearing_rad(column).unwrap());
        off.map(f64::abs).fold(0.0, f64::max).to_degrees()
    };
    assert!((worst_deg(640, 28.5, 21.5) - 0.95).abs() < 0.01, "{}", worst_deg(640, 28.5, 21.5));
    assert!((worst_deg(512, 35.0, 30.0) - 1.8).abs() < 0.05, "{}", worst_deg(512, 35.0, 30.0));
    let half = [28.5_f64.to_radians(), 21.5_f64.to_radians()];
    let last_deg = |counting| {
        let rays = Rays::linear_angle(64, 48, half, counting).unwrap();
        rays.bearing_rad(63).unwrap().to_degrees()
    };
    assert!((last_deg(Counting::FromZero) + 28.05).abs() < 0.005);
    assert!((last_deg(Counting::OneOff) + 28.95).abs() < 0.005);
}

/// NaN and infinities are texts in the file.
fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| match value.as_str().unwrap() {
        "NaN" => f64::NAN,
        "+inf" => f64::INFINITY,
        "-inf" => f64::NEG_INFINITY,
        other => panic!("{other}"),
    })
}

fn same(found: f64, expected: f64, tolerance: f64) -> bool {
    (found.is_nan() && expected.is_nan()) || found == expected || (found - expected).abs() < tolerance
}

#[test]
fn the_scan_of_a_small_picture_has_all_four_outcomes_of_the_table() {
    let file: serde_json::Value = serde_json::from_str(data!("slam2d_depth_to_scan.json")).unwrap();
    let get = |group: &str, key: &str| number(&file[group][key]);
    let rows = file["image"]["depth_m_rows"].as_array().unwrap();
    let depths_m: Vec<f32> =
        rows.iter().flat_map(|row| row.as_array().unwrap()).map(|depth| number(depth) as f32).collect();
    let camera = Intrinsics {
        width: 8,
        height: 6,
        focal_px: [get("intrinsics", "fx"), get("intrinsics", "fy")],
        center_px: [get("intrinsics", "cx"), get("intrinsics", "cy")],
    };
    let rays = Rays::pinhole(&camera).unwrap();
    let limits = ScanLimits {
        heights_m: [number(&file["min_height_m"]), number(&file["max_height_m"])],
        ranges_m: [number(&file["range_min_m"]), number(&file["range_max_m"])],
        rows: None,
    };
    let camera_m = number(&file["camera_height_m"]);
    let level = UnitQuaternion::identity();
    let depths = Depths::Meters(&depths_m);
    let exact = slow::scan_slowly(&rays, depths, (&level, camera_m), &limits, &Beams::PerColumn).unwrap();
    let mut scan = VirtualScan::new(rays, limits, Beams::PerColumn).unwrap();
    scan.face(&level, camera_m);
    let mut ranges_m = [0.0; 8];
    let scanned = scan.scan(depths, &mut ranges_m).unwrap();
    for expected in file["columns"].as_array().unwrap() {
        let column = expected["column"].as_u64().unwrap() as usize;
        let (bearing_rad, range_m) = (number(&expected["bearing_rad"]), number(&expected["range"]));
        assert!((scan.bearings_rad()[column] - bearing_rad).abs() < 1e-10);
        // The picture's depths are in single precision: 1.9 and 2.2 m have no better ones.
        assert!(same(exact[column].1, range_m, 2e-7), "column {column}: {:?}", exact[column]);
        assert!(same(ranges_m[column].into(), range_m, 5e-7), "column {column}: {}", ranges_m[column]);
    }
    assert_eq!(scanned.n_seen as f64 / 8.0, number(&file["valid_fraction"]));
}

#[test]
fn a_pixel_of_a_camera_that_looks_down_lies_where_the_table_has_it() {
    let file: serde_json::Value = serde_json::from_str(data!("slam2d_depth_to_scan.json")).unwrap();
    let example = &file["tilted_pixel_example"];
    let camera = Intrinsics { width: 8, height: 6, focal_px: [6.0; 2], center_px: [3.5, 2.5] };
    let rays = Rays::pinhole(&camera).unwrap();
    let down_rad = number(&example["camera_pitch_down_rad"]);
    let level_from_camera = UnitQuaternion::from_euler_angles(0.0, down_rad, 0.0);
    let camera_m = number(&file["camera_height_m"]);
    let in_camera = rays.point(5, 4, number(&example["Z"])).unwrap();
    let point = level_from_camera * Vector3::from(in_camera) + Vector3::z() * camera_m;
    for axis in 0..3 {
        assert!((point[axis] - number(&example["point_in_base_footprint"][axis])).abs() < 1e-10);
    }
    let mut counts = [0; 48];
    counts[4 * 8 + 5] = 1400;
    // Wide enough for its height below the floor.
    let limits = ScanLimits { heights_m: [-1.0, 1.0], ranges_m: [0.1, 4.0], rows: None };
    let (range_m, bearing_rad) = (number(&example["range"]), number(&example["bearing"]));
    let beams = Beams::Uniform { first_bearing_rad: bearing_rad, bearing_step_rad: 1e-8, n_beams: 1 };
    let exact =
        slow::scan_slowly(&rays, millimeters(&counts), (&level_from_camera, camera_m), &limits, &beams);
    assert!((exact.unwrap()[0].1 - range_m).abs() < 1e-7);
    let mut scan = VirtualScan::new(rays, limits, beams).unwrap();
    scan.face(&level_from_camera, camera_m);
    let mut ranges_m = [0.0];
    scan.scan(millimeters(&counts), &mut ranges_m).unwrap();
    assert!((f64::from(ranges_m[0]) - range_m).abs() < 1e-6, "{ranges_m:?}: its bearing is that to 1e-8 rad");
}
