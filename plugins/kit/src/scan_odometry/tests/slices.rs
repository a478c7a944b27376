//! The pitch by upright slices, against a body whose pitch is known.

use super::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rumbo_core::messages::{DepthImage, Intrinsics};
use rumbo_core::time::Time;

const CAMERA: Intrinsics =
    Intrinsics { width: 9, height: 96, focal_px: [120.0, 120.0], center_px: [4.0, 47.5] };

fn pitched(pitch_rad: f64) -> Pose3 {
    Pose3::rotation(Vector3::y() * pitch_rad)
}

/// What the camera sees of a floor, a wall ahead and a low box before it, in millimeters with noise.
fn picture(map_from_camera: &Pose3, wall_m: f64, rng: &mut Xoshiro256PlusPlus) -> DepthImage {
    let from = map_from_camera.translation.vector;
    let normal = Normal::new(0.0, 1.0).unwrap();
    let mut depth = Vec::new();
    for row in 0..CAMERA.height {
        for column in 0..CAMERA.width {
            let [u, v] = [f64::from(column), f64::from(row)];
            let ray = map_from_camera.rotation * Vector3::new(1.0, -(u - 4.0) / 120.0, -(v - 47.5) / 120.0);
            let at = |far: f64| from + ray * far;
            let floor = -from.z / ray.z;
            let hits = [
                floor,
                (wall_m - from.x) / ray.x,
                Some((wall_m - 1.0 - from.x) / ray.x)
                    .filter(|far| at(*far).z < 0.25)
                    .unwrap_or(f64::INFINITY),
            ];
            let nearest = hits.into_iter().filter(|far| *far > 0.0).fold(f64::INFINITY, f64::min);
            let noisy = nearest + 0.0015 * nearest * nearest * normal.sample(rng);
            depth.push(if (0.4..6.0).contains(&noisy) { (1000.0 * noisy) as u16 } else { 0 });
        }
    }
    DepthImage { intrinsics: CAMERA, unit_m: 0.001, depth: depth.into() }
}

fn mount(pitch_rad: f64, yaw_rad: f64) -> Pose3 {
    let turn = UnitQuaternion::from_euler_angles(0.0, pitch_rad, yaw_rad);
    Pose3::from_parts(Translation3::new(0.1, 0.0, 0.35), turn)
}

/// Largest error of the pitch, radians, of a body that sways by this and drives ahead.
fn largest_error(sway_rad: f64, speed_m_s: f64, camera_pitch_rad: f64, seed: u64) -> f64 {
    let (mut slices, mut rng, mut largest_rad) = (SlicePitch::default(), rng(seed), 0f64);
    let base_from_camera = mount(camera_pitch_rad, 0.0);
    for k in 0..300 {
        let seconds = f64::from(k) / 15.0;
        let pitch_rad = sway_rad * (std::f64::consts::TAU * 0.5 * seconds).sin();
        let map_from_base = Pose3::translation(speed_m_s * seconds, 0.0, 0.0) * pitched(pitch_rad);
        let seen = picture(&(map_from_base * base_from_camera), 5.0, &mut rng);
        let stamp = Time::from_secs(seconds);
        assert_eq!(slices.take(stamp, &seen, &base_from_camera), k > 0, "{seconds} s");
        largest_rad = largest_rad.max((slices.pitch_rad(stamp) - pitch_rad).abs());
        let up = slices.level_from_base(stamp) * Vector3::x();
        assert!((up.z + slices.pitch_rad(stamp).sin()).abs() < 1e-9, "positive looks down");
    }
    largest_rad
}

#[test]
fn the_pitch_of_a_swaying_body_is_followed() {
    for (sway_rad, speed_m_s, camera_pitch_rad) in
        [(0.17, 0.0, 0.0), (0.17, 0.12, 0.0), (0.1, 0.12, 0.2), (0.0, 0.12, 0.0)]
    {
        for seed in 1..=2 {
            let error_rad = largest_error(sway_rad, speed_m_s, camera_pitch_rad, seed);
            assert!(
                error_rad < 0.02,
                "sway {sway_rad}, {speed_m_s} m/s, {camera_pitch_rad}: {error_rad} rad"
            );
        }
    }
}

#[test]
fn pictures_without_readings_and_late_ones_say_nothing() {
    let mut slices = SlicePitch::default();
    let blind = DepthImage { depth: vec![0u16; 9 * 96].into(), intrinsics: CAMERA, unit_m: 0.001 };
    assert_eq!(slices.pitch_rad(Time::from_secs(1.0)), 0.0);
    assert!(!slices.take(Time::from_secs(1.0), &blind, &mount(0.0, 0.0)));
    let empty = DepthImage { unit_m: 0.001, ..DepthImage::default() };
    assert!(!slices.take(Time::from_secs(1.1), &empty, &mount(0.0, 0.0)));
    let mut rng = rng(3);
    let seen = picture(&mount(0.0, 0.0), 4.0, &mut rng);
    slices.take(Time::from_secs(1.2), &seen, &mount(0.0, 0.0));
    let down = picture(&(pitched(0.05) * mount(0.0, 0.0)), 4.0, &mut rng);
    assert!(slices.take(Time::from_secs(1.3), &down, &mount(0.0, 0.0)));
    let pitch_rad = slices.pitch_rad(Time::from_secs(1.3));
    assert!((pitch_rad - 0.05).abs() < 0.01, "{pitch_rad}");
    assert!(!slices.take(Time::from_secs(1.3), &seen, &mount(0.0, 0.0)), "not newer");
    assert_eq!(slices.pitch_rad(Time::from_secs(1.3)), pitch_rad);
}

#[test]
fn what_a_camera_to_the_left_sees_as_pitch_is_the_bodys_roll() {
    let (mut slices, mut rng) = (SlicePitch::default(), rng(4));
    let to_left = mount(0.0, std::f64::consts::FRAC_PI_2);
    let roll = Pose3::rotation(Vector3::x() * 0.04);
    let turned = Pose3::rotation(Vector3::z() * -std::f64::consts::FRAC_PI_2);
    for (k, body) in [Pose3::identity(), roll].into_iter().enumerate() {
        let seen = picture(&(turned * body * to_left), 4.0, &mut rng);
        slices.take(Time::from_secs(0.1 * k as f64), &seen, &to_left);
    }
    let level = slices.level_from_base(Time::from_secs(0.1));
    assert!(level.rotation.angle_to(&roll.rotation) < 0.01, "{level}");
}
