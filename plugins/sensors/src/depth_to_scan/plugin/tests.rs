use rumbo_core::messages::{Check, LaserScan};
use rumbo_core::trace::Trace;

use super::*;
use crate::test_world::given;

const CAMERA: Intrinsics = Intrinsics { width: 8, height: 6, focal_px: [6.0; 2], center_px: [3.5, 2.5] };

/// Depths of the specification's small picture, in millimeters, with its heights and ranges.
const PICTURE: [[u16; 8]; 6] = [
    [2000; 8],
    [1800, 1500, 0, 3000, 300, 5000, 1200, 0],
    [1900, 1600, 0, 3000, 300, 4300, 1100, 0],
    [2100, 900, 0, 2500, 400, 5500, 1300, 0],
    [1000, 1000, 0, 1000, 1000, 1000, 1000, 0],
    [500, 500, 0, 500, 500, 500, 500, 0],
];

fn sensor(params: &DepthToScanParams) -> Box<dyn Sensor> {
    params.build(&BuildContext::bare("scan")).unwrap()
}

fn params() -> DepthToScanParams {
    DepthToScanParams { max_height_m: Some(0.6), beams: Some(8), ..DepthToScanParams::default() }
}

fn observation(stamp_s: f64, base_from_sensor: Pose3, data: Data) -> Observation {
    Observation { sensor: SensorId(1), stamp: Time::from_secs(stamp_s), base_from_sensor, valid: true, data }
}

fn picture(stamp_s: f64, depth: &[u16], pitch_rad: f64) -> Observation {
    let turn = UnitQuaternion::from_euler_angles(0.0, pitch_rad, 0.0);
    let mount = Pose3::from_parts(Translation3::new(0.0, 0.0, 0.226), turn);
    let image = DepthImage { intrinsics: CAMERA, unit_m: 0.001, depth: depth.into() };
    observation(stamp_s, mount, Data::DepthImage(image))
}

fn imu(stamp_s: f64, attitude_rad: [f64; 3]) -> Observation {
    let imu = Imu { attitude_rad: Some(attitude_rad), ..Imu::default() };
    observation(stamp_s, Pose3::identity(), Data::Imu(imu))
}

fn derive(sensor: &mut dyn Sensor, seen: &[Observation]) -> Vec<(bool, LaserScan, Pose3)> {
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    sensor.derive(&mut Cx { now: Time::ZERO, trace: &trace }, Seen::sorted(seen), &mut out).unwrap();
    let scan = |observation: Observation| {
        observation.check().unwrap();
        let Data::LaserScan(scan) = observation.data else { panic!("a scan") };
        (observation.valid, scan, observation.base_from_sensor)
    };
    given(&out).into_iter().map(scan).collect()
}

/// Eight even beams have the columns of the specification's picture one by one (they are 0.15 rad apart on the average).
/// Left is column 0 and the last beam.
#[test]
fn the_small_picture_has_its_four_outcomes() {
    let seen = derive(&mut *sensor(&params()), &[picture(1.0, PICTURE.as_flattened(), 0.0)]);
    let (valid, scan, _) = &seen[0];
    assert!(valid);
    let expected = [f32::NAN, 1.191_666_7, f32::INFINITY, 0.0, 3.010_398_6, f32::NAN, 0.975, 2.199_637];
    for (beam, (found, expected)) in scan.ranges_m.iter().zip(expected).enumerate() {
        let same =
            (found.is_nan() && expected.is_nan()) || *found == expected || (found - expected).abs() < 1e-5;
        assert!(same, "beam {beam}: {found}, expected {expected}");
    }
    assert_eq!(scan.hits().count(), 4, "what reads 0 is nearer than the least range, and no reading");
    let extreme_rad = 0.528_074_448_426_4;
    assert!((scan.bearing_rad(7) - extreme_rad).abs() < 0.5 * scan.bearing_step_rad);
}

fn bits(scan: &LaserScan) -> Vec<u32> {
    scan.ranges_m.iter().map(|range_m| range_m.to_bits()).collect()
}

/// A base that leans forward by an angle, and a camera that is mounted up by the same, see as if both were level.
#[test]
fn attitude_and_mount_add_up() {
    for yaw_rad in [0.0, 2.5] {
        let seen = [imu(0.95, [0.0, 0.3, yaw_rad]), picture(1.0, PICTURE.as_flattened(), -0.3)];
        let leaning = derive(&mut *sensor(&params()), &seen);
        let (valid, scan, base_from_scan) = &leaning[0];
        assert!(*valid && (base_from_scan.rotation * nalgebra::Vector3::z()).z > 0.999_999);
        // 0.226 m along the leaning base's own vertical.
        assert!((base_from_scan.translation.z - 0.226 * 0.3f64.cos()).abs() < 1e-9);
        let mut low = picture(1.0, PICTURE.as_flattened(), 0.0);
        low.base_from_sensor.translation.z = 0.226 * 0.3f64.cos();
        let expected = derive(&mut *sensor(&params()), &[low]);
        assert_eq!(bits(scan), bits(&expected[0].1));
    }
    let level = derive(&mut *sensor(&params()), &[picture(1.0, PICTURE.as_flattened(), 0.0)]);
    let turned = [imu(0.95, [0.0, 0.0, 2.5]), picture(1.0, PICTURE.as_flattened(), 0.0)];
    let turned = derive(&mut *sensor(&params()), &turned);
    assert_eq!(bits(&turned[0].1), bits(&level[0].1), "yaw alone tilts nothing");
}

#[test]
fn an_old_attitude_is_used_and_the_scan_is_not_valid() {
    let seen = [imu(0.5, [0.0, 0.0, 0.0]), picture(1.0, PICTURE.as_flattened(), 0.0)];
    let mut scanner = sensor(&params());
    assert!(!derive(&mut *scanner, &seen)[0].0);
    assert!(derive(&mut *scanner, &[imu(1.05, [0.0; 3]), picture(1.1, PICTURE.as_flattened(), 0.0)])[0].0);
}

#[test]
fn five_pictures_of_nothing_are_a_blind_camera() {
    let mut scanner = sensor(&params());
    let dark: Vec<Observation> = (0..6).map(|k| picture(f64::from(k) * 0.1, &[0; 48], 0.0)).collect();
    let valid: Vec<bool> = derive(&mut *scanner, &dark)
        .into_iter()
        .map(|(valid, scan, _)| {
            assert!(scan.ranges_m.iter().all(|range_m| range_m.is_nan()));
            valid
        })
        .collect();
    assert_eq!(valid, [true, true, true, true, false, false]);
    assert!(derive(&mut *scanner, &[picture(1.0, PICTURE.as_flattened(), 0.0)])[0].0);
}

#[test]
fn a_picture_that_is_not_newer_is_dropped_and_counted() {
    let mut scanner = sensor(&params());
    let (trace, mut out) = (Trace::counting(), Observations::default());
    let at = |stamp_s: f64| picture(stamp_s, PICTURE.as_flattened(), 0.0);
    // Another camera has a clock of its own.
    let other = Observation { sensor: SensorId(2), ..at(0.7) };
    for seen in [at(1.0), at(1.0), at(0.5), other, at(1.1)] {
        scanner.derive(&mut Cx { now: Time::ZERO, trace: &trace }, Seen::sorted(&[seen]), &mut out).unwrap();
    }
    let stamps: Vec<Time> = given(&out).iter().map(|scan| scan.stamp).collect();
    assert_eq!(stamps, [1.0, 0.7, 1.1].map(Time::from_secs));
    assert_eq!(trace.take().1.last(), Some(&("depth pictures dropped: not newer than the last", 2.0)));
}

#[test]
fn a_picture_that_does_not_fit_its_camera_is_dropped_and_the_next_is_read() {
    let mut scanner = sensor(&params());
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    let seen = [picture(1.0, &[1000; 47], 0.0), picture(1.1, PICTURE.as_flattened(), 0.0)];
    let told = scanner.derive(&mut Cx { now: Time::ZERO, trace: &trace }, Seen::sorted(&seen), &mut out);
    let told = told.unwrap_err().to_string();
    assert!(told.contains("47 elements where the camera has 48"), "{told}");
    assert_eq!(given(&out).len(), 1);
}

#[test]
fn rows_are_a_slice_around_their_middle() {
    assert_eq!(slice(2, None, 6), 2..4);
    assert_eq!(slice(3, Some(2), 6), 1..4);
    assert_eq!(slice(100, None, 6), 0..6);
    assert_eq!(slice(1, Some(99), 6), 5..6);
    assert_eq!(slice(1, Some(0), 1), 0..1);
    let one_row = DepthToScanParams { rows: Some(1), row_center: Some(3), ..params() };
    let seen = derive(&mut *sensor(&one_row), &[picture(1.0, PICTURE.as_flattened(), 0.0)]);
    assert!((seen[0].1.ranges_m[6] - 0.975).abs() < 1e-5);
    assert!((seen[0].1.ranges_m[7] - 2.1 * (3.5f32 / 6.0).hypot(1.0)).abs() < 1e-5, "row 3 of column 0");
}

#[test]
fn impossible_limits_are_told() {
    assert!(DepthToScanParams::default().check().is_empty());
    let bad = DepthToScanParams {
        max_height_m: Some(0.0),
        range_min_m: 5.0,
        min_valid_fraction: 2.0,
        beams: Some(0),
        rows: Some(0),
        blind_frames: 0,
        max_attitude_age_s: f64::NAN,
        ..DepthToScanParams::default()
    };
    assert_eq!(bad.check().len(), 7, "{:?}", bad.check());
}
