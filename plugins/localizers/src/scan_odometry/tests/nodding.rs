//! A body that nods while it drives: walls seem to come and go, and the floor comes into sight.

use super::*;
use nalgebra::Vector3;
use rumbo_core::frames::lift;
use rumbo_core::messages::{DepthImage, Intrinsics};

const CAMERA: Intrinsics =
    Intrinsics { width: 5, height: 90, focal_px: [110.0, 110.0], center_px: [2.0, 44.5] };

/// How far a ray goes to the hall's walls, which have no upper edge, or to its floor, in lengths of the ray.
fn far(from: &Vector3<f64>, ray: &Vector3<f64>) -> f64 {
    let level = ray.xy().norm();
    let to_wall = range_m(HALL, &pose2(from.x, from.y, 0.0), ray.y.atan2(ray.x)) / level;
    let to_floor = -from.z / ray.z;
    if to_floor > 0.0 { to_wall.min(to_floor) } else { to_wall }
}

/// Picture and scan of one moment, both from 0.4 m over the base.
fn seen(map_from_base: &Pose3, seconds: f64) -> [Observation; 2] {
    let mount = Pose3::translation(0.0, 0.0, 0.4);
    let at = map_from_base * mount;
    let mut rng = rng::stream((1e3 * seconds) as u64, "nodding");
    let mut noise = |deviation: f64| -> f64 {
        let sample: f64 = StandardNormal.sample(&mut rng);
        deviation * sample
    };
    let mut ranges = Vec::new();
    for k in 0..N_BEAMS {
        let (sine, cosine) = (0.5 * k as f64 - 90.0).to_radians().sin_cos();
        let ray = at.rotation * Vector3::new(cosine, sine, 0.0);
        ranges.push((far(&at.translation.vector, &ray) + noise(0.01)) as f32);
    }
    let mut depth = Vec::new();
    for row in 0..CAMERA.height {
        for column in 0..CAMERA.width {
            let (u, v) = (f64::from(column) - 2.0, f64::from(row) - 44.5);
            let ray = at.rotation * Vector3::new(1.0, -u / 110.0, -v / 110.0);
            let ahead_m = far(&at.translation.vector, &ray);
            let read_m = ahead_m + noise(0.0015 * ahead_m * ahead_m);
            depth.push(if (0.5..8.0).contains(&read_m) { (1000.0 * read_m) as u16 } else { 0 });
        }
    }
    let scan = LaserScan {
        first_bearing_rad: -90f64.to_radians(),
        bearing_step_rad: 0.5f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: ranges.into(),
        ..LaserScan::default()
    };
    let image = DepthImage { intrinsics: CAMERA, unit_m: 0.001, depth: depth.into() };
    [observed(3, seconds, Data::DepthImage(image)), observed(0, seconds, Data::LaserScan(scan))]
        .map(|observation| Observation { base_from_sensor: mount, ..observation })
}

/// Root of the mean square of the error of the place on a drive of 20 s, meters.
fn error_m(vertical_slice: bool, nod_rad: f64) -> f64 {
    // With key scans as often as published: each keeps what the nod made of it.
    let params = ScanOdometryParams {
        vertical_slice,
        key_distance_m: 0.15,
        key_angle_deg: 5.73,
        ..ScanOdometryParams::default()
    };
    let mut localizer = started(&params);
    let (mut at, mut sum) = (Pose2::identity(), 0.0);
    for k in 0..200 {
        let seconds = 0.1 * f64::from(k);
        let pitch_rad = nod_rad * (std::f64::consts::TAU * 0.5 * seconds).sin();
        let body = lift(&at) * Pose3::rotation(Vector3::y() * pitch_rad);
        let estimate = update(&mut *localizer, seconds, &seen(&body, seconds));
        sum += apart(&estimate.pose2(), &at)[0].powi(2);
        at *= Twist::new(0.2, 0.15).integrate(0.1);
    }
    (sum / 200.0).sqrt()
}

#[test]
fn with_a_vertical_slice_a_nodding_body_is_not_taken_for_a_moving_one() {
    let (with_m, without_m) = (error_m(true, 0.14), error_m(false, 0.14));
    assert!(with_m < 0.06, "{with_m} m");
    assert!(without_m > 2.0 * with_m, "{without_m} m without, {with_m} m with: then it shows nothing");
    let level_m = error_m(true, 0.0);
    assert!(level_m < 0.04, "{level_m} m where nothing nods");
}
