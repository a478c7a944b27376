use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Check, LaserScan, PointCloud};
use rumbo_core::robot::Robot;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::depth::{DepthScale, closest};
use std::sync::Arc;

use super::*;
use crate::kinect::Projection;
use crate::test_world::{TestWorld, given};

fn params() -> KinectParams {
    KinectParams { columns: Some(64), rows: Some(48), exact: true, ..KinectParams::default() }
}

/// At 0.3 m over the floor, looking down by an angle.
fn sensor(params: &KinectParams, down_rad: f64) -> Box<dyn Sensor> {
    let turn = nalgebra::UnitQuaternion::from_euler_angles(0.0, down_rad, 0.0);
    let base_from_sensor = Pose3::from_parts([0.1, 0.0, 0.3].into(), turn);
    let robot = Arc::new(Robot { height_m: 0.5, ..Robot::default() });
    params.build(&BuildContext { base_from_sensor, robot, ..BuildContext::bare("sensor") }).unwrap()
}

fn poll(sensor: &mut dyn Sensor, world: &mut TestWorld, now_s: f64) -> Vec<Observation> {
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    let polled = sensor.poll(&mut Cx { now: Time::from_secs(now_s), trace: &trace }, world, &mut out);
    polled.unwrap();
    let seen = given(&out);
    seen.iter().for_each(|observation| observation.check().unwrap());
    seen
}

fn scan_of(observation: &Observation) -> &LaserScan {
    let Data::LaserScan(scan) = &observation.data else { panic!("{:?}", observation.data.kind()) };
    scan
}

fn points_of(observation: &Observation) -> &PointCloud {
    let Data::PointCloud(cloud) = &observation.data else { panic!("{:?}", observation.data.kind()) };
    cloud
}

#[test]
fn a_wall_is_a_scan_also_of_a_camera_that_looks_down() {
    for down_rad in [0.0, 0.2] {
        let mut camera = sensor(&params(), down_rad);
        let seen = poll(&mut *camera, &mut TestWorld::with_wall(2.0), 0.0);
        assert_eq!(seen.len(), 1, "a scan only, by default");
        assert!(seen[0].valid && seen[0].stamp == Time::ZERO);
        let up = seen[0].base_from_sensor.rotation * nalgebra::Vector3::z();
        assert!((up.z - 1.0).abs() < 1e-12, "scans are level");
        assert_eq!(seen[0].base_from_sensor.translation.vector, nalgebra::Vector3::new(0.1, 0.0, 0.3));
        let scan = scan_of(&seen[0]);
        assert!(scan.ranges_m.len() > 45 && scan.hits().count() > scan.ranges_m.len() - 4);
        for (bearing_rad, range_m) in scan.hits() {
            // In steps of 11 mm at 2 m; a beam has what is nearest within half a step of it.
            let exact_m = 2.0 / bearing_rad.cos();
            let nearest_m = 2.0 / (bearing_rad.abs() - scan.bearing_step_rad / 2.0).max(0.0).cos();
            assert!(range_m > nearest_m - 0.012 && range_m < exact_m + 0.012, "{bearing_rad} {range_m}");
        }
    }
}

#[test]
fn points_lie_between_the_heights_and_pictures_are_the_devices_own() {
    let gives = vec![Given::PointCloud, Given::DepthImage];
    let mut camera = sensor(&KinectParams { gives, ..params() }, 0.0);
    let seen = poll(&mut *camera, &mut TestWorld::with_wall(2.0), 0.0);
    let [picture, cloud] = &seen[..] else { panic!("{} observations", seen.len()) };
    let Data::DepthImage(image) = &picture.data else { panic!("a picture first") };
    assert_eq!((image.depth.len(), image.unit_m), (3072, 0.001));
    // The lowest row meets the floor after 0.3 m / tan(21 degrees).
    let floor_m = f64::from(image.depth[3071]) * 0.001;
    assert!((floor_m - 0.3 / (47.0 - 23.5) * 24.0 / 21.5f64.to_radians().tan()).abs() < 0.005, "{floor_m}");
    let points = points_of(cloud);
    let (mut n_points, mut n_none) = (0, 0);
    for point in points.points_m.iter() {
        if point[0].is_nan() {
            n_none += 1;
            continue;
        }
        n_points += 1;
        assert!((point[0] - 2.0).abs() < 0.006, "the wall only");
        assert!((0.05..=0.6).contains(&(point[2] + 0.3)), "{point:?}");
    }
    assert!(n_points > 900 && n_none > 900, "{n_points} {n_none}");
}

#[test]
fn thirteen_bits_from_the_near_plane_are_read_as_the_source_does() {
    let scale = DepthScale::UnitRange;
    let gives = vec![Given::PointCloud, Given::DepthImage];
    let source = KinectParams { depth_scale: scale, gives, projection: Projection::LinearAngle, ..params() };
    for (wall_m, expected_m) in [(0.1, 0.2), (0.50941, 0.509413), (3.0, 3.0)] {
        let mut camera = sensor(&source, 0.0);
        let seen = poll(&mut *camera, &mut TestWorld::with_wall(wall_m), 0.0);
        let nearest = closest(&points_of(&seen[1]).points_m, 64, None).point.unwrap();
        assert!((f64::from(nearest.point_m[0]) - expected_m).abs() < 3e-4, "{wall_m}: {nearest:?}");
        // The outermost column of evenly spaced angles.
        let [x, y, _] = points_of(&seen[1]).points_m[24 * 64].map(f64::from);
        assert!((y.atan2(x).to_degrees() - 28.0546875).abs() < 1e-3);
    }
}

/// DC-A10: all zero reports "blind".
#[test]
fn a_camera_that_sees_nothing_is_blind_after_five_pictures_and_never_sees_free_space() {
    let mut camera = sensor(&params(), -0.6);
    let mut nothing = TestWorld::with_wall(50.0);
    let valid: Vec<bool> = (0..7)
        .map(|k| {
            let seen = poll(&mut *camera, &mut nothing, f64::from(k) * 0.1);
            assert!(scan_of(&seen[0]).ranges_m.iter().all(|range_m| range_m.is_nan()), "nothing is known");
            seen[0].valid
        })
        .collect();
    assert_eq!(valid, [true, true, true, true, false, false, false]);
    let seen = poll(&mut *camera, &mut TestWorld::with_wall(1.5), 1.0);
    assert!(seen[0].valid, "it sees again");
    let sunny = KinectParams { exact: false, sunlight: 1000.0, ..params() };
    let mut camera = sensor(&sunny, 0.0);
    let valid: Vec<bool> =
        (0..6).map(|_| poll(&mut *camera, &mut TestWorld::with_wall(2.0), 0.0)[0].valid).collect();
    assert_eq!(valid, [true, true, true, true, false, false], "blinded by the sun");
}

/// DC-A11: of 30 % random zeros something is left in every beam.
#[test]
fn a_third_of_the_pixels_may_be_missing() {
    let noisy = KinectParams { exact: false, dropout: 0.3, ..params() };
    let mut camera = sensor(&noisy, 0.0);
    for k in 0..20 {
        let seen = poll(&mut *camera, &mut TestWorld::with_wall(1.0), f64::from(k) * 0.1);
        assert!(seen[0].valid);
        let scan = scan_of(&seen[0]);
        assert!(scan.hits().count() >= scan.ranges_m.len() - 2);
        assert!(scan.hits().all(|(bearing_rad, range_m)| (range_m * bearing_rad.cos() - 1.0).abs() < 0.05));
    }
}

#[test]
fn what_comes_too_near_to_be_seen_stays_an_obstacle_unless_that_is_switched_off() {
    for (near_is_occupied, near_closing_m_s) in [(true, 1.0), (true, 0.0), (false, 0.0)] {
        let mut camera = sensor(&KinectParams { near_is_occupied, near_closing_m_s, ..params() }, 0.0);
        let approach = [0.8, 0.7, 0.6, 0.52, 0.4, 0.3];
        for (k, wall_m) in approach.into_iter().enumerate() {
            let seen = poll(&mut *camera, &mut TestWorld::with_wall(wall_m), k as f64 * 0.1);
            let nearest_m =
                scan_of(&seen[0]).hits().map(|(_, range_m)| range_m).fold(f64::INFINITY, f64::min);
            if wall_m >= 0.5 {
                assert!((nearest_m - wall_m).abs() < 0.01, "{wall_m}: {nearest_m}");
            } else if !near_is_occupied {
                assert_eq!(nearest_m, f64::INFINITY);
            } else if near_closing_m_s > 0.0 {
                assert!(nearest_m <= wall_m + 0.03 && nearest_m >= 0.2, "{wall_m}: {nearest_m}");
            } else {
                assert!((nearest_m - 0.52).abs() < 0.01, "where it was last: {nearest_m}");
            }
        }
    }
}

/// A robot that stands right before a wall has a camera without readings that is not blind: it knows why.
#[test]
fn a_camera_right_before_a_wall_is_not_blind() {
    for near_is_occupied in [true, false] {
        let mut camera = sensor(&KinectParams { near_is_occupied, ..params() }, 0.0);
        poll(&mut *camera, &mut TestWorld::with_wall(0.55), 0.0);
        for k in 1..10 {
            let seen = poll(&mut *camera, &mut TestWorld::with_wall(0.3), f64::from(k) * 0.1);
            assert_eq!(seen[0].valid, near_is_occupied || k < 5, "picture {k}");
        }
    }
}

#[test]
fn recorded_pictures_become_scans_and_recorded_scans_are_passed_on() {
    let gives = vec![Given::LaserScan, Given::PointCloud, Given::DepthImage];
    let all = KinectParams { gives, ..params() };
    let mut made = poll(&mut *sensor(&all, 0.2), &mut TestWorld::with_wall(2.0), 3.0);
    made.iter_mut().for_each(|observation| observation.base_from_sensor = Pose3::identity());
    let kinds = |seen: &[Observation]| seen.iter().map(|o| o.data.kind().name()).collect::<Vec<_>>();
    assert_eq!(kinds(&made), ["depth_image", "point_cloud", "laser_scan"]);
    // Everything was recorded: it is passed on as it is, from where this sensor sits.
    let played = poll(&mut *sensor(&all, 0.2), &mut TestWorld::recorded(made.clone()), 9.0);
    assert_eq!(kinds(&played), kinds(&made));
    assert!(played.iter().all(|observation| observation.stamp == Time::from_secs(3.0)));
    assert_ne!(played[0].base_from_sensor, played[2].base_from_sensor, "scans lie level");
    assert_eq!(scan_of(&played[2]), scan_of(&made[2]));
    // Only the picture was: the rest is made of it, to the bit as before.
    let again = poll(&mut *sensor(&all, 0.2), &mut TestWorld::recorded(made[..1].to_vec()), 9.0);
    assert_eq!(kinds(&again), kinds(&made));
    assert_eq!(scan_of(&again[2]), scan_of(&made[2]));
    let bits =
        |o: &Observation| points_of(o).points_m.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&again[1]), bits(&made[1]));
    // A picture of another size and unit.
    let mut other = made[0].clone();
    let intrinsics = Intrinsics { width: 2, height: 1, focal_px: [2.0; 2], center_px: [0.5, 0.0] };
    let depth = [5000_u16, 10_000].as_slice().into();
    other.data = Data::DepthImage(DepthImage { intrinsics, unit_m: 0.0002, depth });
    let single = KinectParams { median: false, ..params() };
    let seen = poll(&mut *sensor(&single, 0.0), &mut TestWorld::recorded(vec![other]), 9.0);
    let ranges_m: Vec<f64> = scan_of(&seen[0]).hits().map(|(_, range_m)| range_m).collect();
    assert_eq!(ranges_m.len(), 2);
    assert!(
        (ranges_m[1] - 1.0 * 0.25f64.hypot(1.0)).abs() < 1e-4
            && (ranges_m[0] / ranges_m[1] - 2.0).abs() < 1e-4
    );
}

#[test]
fn broken_recorded_pictures_are_errors_and_no_panics() {
    let gives = vec![Given::LaserScan, Given::PointCloud];
    let mut camera = sensor(&KinectParams { gives, ..params() }, 0.0);
    let good = Intrinsics { width: 2, height: 2, focal_px: [2.0; 2], center_px: [0.5; 2] };
    for (intrinsics, unit_m, n_pixels) in [
        (good, 0.001, 3),
        (good, 0.001, 0),
        (Intrinsics { width: 0, ..good }, 0.001, 0),
        (Intrinsics { width: 60_000, height: 60_000, ..good }, 0.001, 4),
        (Intrinsics { focal_px: [0.0; 2], ..good }, 0.001, 4),
        (Intrinsics { focal_px: [f64::NAN; 2], ..good }, 0.001, 4),
    ] {
        let depth = vec![1000_u16; n_pixels].as_slice().into();
        let data = Data::DepthImage(DepthImage { intrinsics, unit_m, depth });
        let recorded = Observation {
            sensor: rumbo_core::messages::SensorId(0),
            stamp: Time::ZERO,
            base_from_sensor: Pose3::identity(),
            valid: true,
            data,
        };
        let (trace, mut out) = (Trace::unwatched(), Observations::default());
        let mut cx = Cx { now: Time::ZERO, trace: &trace };
        let told = camera.poll(&mut cx, &mut TestWorld::recorded(vec![recorded]), &mut out);
        assert!(matches!(told, Err(SensorError::Other(_))), "{told:?}");
        assert_eq!(given(&out).len(), 0);
    }
}

#[test]
fn a_world_that_is_real_is_told_where_drivers_are() {
    let mut world = TestWorld::with_wall(1.0);
    world.is_live = true;
    let (trace, mut out) = (Trace::unwatched(), Observations::default());
    let told = sensor(&params(), 0.0).poll(&mut Cx { now: Time::ZERO, trace: &trace }, &mut world, &mut out);
    assert!(matches!(told, Err(SensorError::Device { .. })), "{told:?}");
}

#[test]
fn parameters_that_no_camera_has_are_all_told() {
    assert!(KinectParams::default().check().is_empty());
    let bad = KinectParams {
        columns: Some(0),
        gives: Vec::new(),
        near_plane_m: -1.0,
        max_range_m: Some(f64::NAN),
        min_height_m: 2.0,
        max_height_m: Some(1.0),
        dropout: 1.5,
        sunlight: -1.0,
        beams: Some(0),
        blind_frames: 0,
        slice_rows: Some(500),
        ..KinectParams::default()
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    for key in [
        "columns",
        "gives",
        "near_plane_m",
        "max_range_m",
        "max_height_m",
        "dropout",
        "sunlight",
        "beams",
        "blind_frames",
        "slice_rows",
    ] {
        assert!(keys.iter().any(|known| known == key), "{key} is missing in {keys:?}");
    }
    let text = "model = \"v2\"\ndepth_scale = \"millimeter\"\nintrinsics = { focal_px = [0, 1], center_px = [1, 1] }\n";
    let parsed: KinectParams = toml::from_str(text).unwrap_or_default();
    assert_eq!(parsed.check()[0].path, "intrinsics");
}

/// Mean of what the ranges of 50 scans of a wall at 3 m are too long, meters.
fn bias_m(median: bool) -> f64 {
    let noisy = KinectParams { exact: false, median, ..KinectParams::default() };
    let mut camera = sensor(&noisy, 0.0);
    let mut off_m = Vec::new();
    for k in 0..50 {
        let seen = poll(&mut *camera, &mut TestWorld::with_wall(3.0), f64::from(k) * 0.1);
        let hits = scan_of(&seen[0]).hits();
        off_m.extend(hits.map(|(bearing_rad, range_m)| range_m * bearing_rad.cos() - 3.0));
    }
    assert!(off_m.len() > 5000);
    off_m.iter().sum::<f64>() / off_m.len() as f64
}

/// A depth of 3 m has a deviation of 14.5 mm, and the least of 25 rows is about two of them nearer.
#[test]
fn scans_are_a_little_short_and_the_median_halves_that() {
    let (with, without) = (bias_m(true), bias_m(false));
    assert!((-0.040..-0.022).contains(&without), "{without}");
    assert!(with < 0.0 && with > 0.6 * without, "{with} with a median, {without} without");
}
