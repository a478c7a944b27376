use std::path::Path;

use rumbo_core::frames::{flatten, pose2};
use rumbo_kit::world_file::parse_world;

use super::*;

const G: f64 = 9.81;

fn terrain(text: &str) -> Terrain {
    let scene = parse_world(&format!("bounds = [0, 0, 9, 9]\n{text}"), Path::new("hills.toml")).unwrap();
    Terrain::new(&scene, &Pose2::identity(), 1.0)
}

fn stance(terrain: &Terrain, at: Pose2, sway: Option<Sway>) -> Stance {
    let undercarriage = Undercarriage::of(&Robot::default(), &Wheels::default());
    Stance::new(undercarriage, sway, G, terrain, &at)
}

/// Up along x with a slope of 3 in 4: cosine 0.8, sine 0.6.
fn incline() -> Terrain {
    terrain("[[ramp]]\ncenter = [4, 0]\nsize = [8, 8]\nz_to_m = 6\n")
}

#[test]
fn on_level_floor_the_body_is_level_and_feels_its_weight() {
    let flat = terrain("");
    let stance = stance(&flat, pose2(1.0, 2.0, 0.7), None);
    assert_eq!(stance.map_from_base, lift(&pose2(1.0, 2.0, 0.7)));
    assert!((stance.specific_force_m_s2[2] - G).abs() < 1e-12, "+9.81 upwards at rest");
    let drive = Twist { forward_m_s: 0.3, left_m_s: -0.1, turn_rad_s: 0.4 };
    assert_eq!(stance.seen_from_above(drive), drive);
}

#[test]
fn on_an_incline_the_body_lies_on_it_whatever_its_yaw() {
    let hill = incline();
    for yaw_rad in [0.0, 0.6, 1.5, -2.0, 3.0] {
        let at = pose2(4.0, 0.5, yaw_rad);
        let stance = stance(&hill, at, None);
        let pose = stance.map_from_base;
        assert!((pose.translation.z - 3.0).abs() < 1e-9, "{yaw_rad}: {pose}");
        // Its up axis is the incline's normal.
        let up = pose.rotation * Vector3::z();
        assert!((up - Vector3::new(-0.6, 0.0, 0.8)).norm() < 1e-9, "{yaw_rad}: {up}");
        assert!((flatten(&pose).rotation.angle() - at.rotation.angle()).abs() < 1e-9);
        let felt = pose.rotation * Vector3::from(stance.specific_force_m_s2);
        assert!((felt - Vector3::new(0.0, 0.0, G)).norm() < 1e-9, "{felt}");
    }
    let uphill = stance(&hill, pose2(4.0, 0.5, 0.0), None);
    assert!((uphill.specific_force_m_s2[0] - G * 0.6).abs() < 1e-9, "nose up: pushed forward");
    let (roll, pitch, _) = uphill.map_from_base.rotation.euler_angles();
    assert!(roll.abs() < 1e-9 && (pitch + 0.6f64.asin()).abs() < 1e-9, "looking up is a negative pitch");
    let along = stance(&hill, pose2(4.0, 0.5, std::f64::consts::FRAC_PI_2), None);
    let (roll, ..) = along.map_from_base.rotation.euler_angles();
    assert!((roll + 0.6f64.asin()).abs() < 1e-9, "the left side is lower");
}

/// A turn of the body about its own axis, as a rotation in space, against the yaw that is integrated in the plane.
#[test]
fn motion_over_an_incline_is_that_of_a_rigid_body_on_it() {
    let hill = incline();
    let (seconds, drive) = (1e-5, Twist { forward_m_s: 0.4, left_m_s: 0.2, turn_rad_s: 0.7 });
    for yaw_rad in [0.0, 0.6, -2.0] {
        let mut at = pose2(4.0, 0.5, yaw_rad);
        let mut stance = stance(&hill, at, None);
        let before = stance.map_from_base;
        at *= stance.seen_from_above(drive).integrate(seconds);
        stance.follow(&hill, &at, seconds, seconds);
        let moved = before.inverse() * stance.map_from_base;
        let velocity = moved.translation.vector / seconds;
        assert!((velocity - Vector3::new(0.4, 0.2, 0.0)).norm() < 1e-4, "{yaw_rad}: {velocity}");
        let rates = Vector3::from(stance.rates_rad_s);
        assert!((rates - Vector3::new(0.0, 0.0, 0.7)).norm() < 1e-4, "{yaw_rad}: {rates}");
    }
}

/// Strapdown integration of what the device feels, over a step, a ramp and a sway, ends at the true pose.
#[test]
fn rates_and_forces_integrate_to_the_pose() {
    let hill = terrain(
        "[[ramp]]\ncenter = [2, 0]\nsize = [2, 8]\nyaw_deg = 20\nz_to_m = 0.5\n[[step]]\ncenter = [4.4, 0]\nsize = [2, 8]\nheight_m = 0.1\n",
    );
    let sway = Sway { roll_deg: 10.0, pitch_deg: 5.0, frequency_hz: 0.5, from_s: 0.5, to_s: Some(4.0) };
    let (seconds, n_steps) = (0.01, 500);
    let mut at = pose2(0.0, 0.0, 0.0);
    let mut stance = stance(&hill, at, Some(sway));
    let (mut rotation, mut position) =
        (stance.map_from_base.rotation, stance.map_from_base.translation.vector);
    let mut velocity = Vector3::zeros();
    let mut highest_m: f64 = 0.0;
    for step in 1..=n_steps {
        let speed_m_s = 1.2 * (f64::from(step) / 100.0).min(1.0);
        at *= stance.seen_from_above(Twist::new(speed_m_s, 0.1)).integrate(seconds);
        stance.follow(&hill, &at, f64::from(step) * seconds, seconds);
        rotation *= UnitQuaternion::from_scaled_axis(Vector3::from(stance.rates_rad_s) * seconds);
        let force = rotation * Vector3::from(stance.specific_force_m_s2);
        velocity += (force - Vector3::new(0.0, 0.0, G)) * seconds;
        position += velocity * seconds;
        highest_m = highest_m.max(stance.z_m());
    }
    assert!(highest_m > 0.2, "{highest_m}");
    assert!(stance.map_from_base.rotation.angle_to(&rotation) < 1e-9);
    let off_m = (stance.map_from_base.translation.vector - position).norm();
    assert!(off_m < 1e-9, "{off_m}");
}

#[test]
fn a_step_is_climbed_without_a_jump() {
    let step = terrain("[[step]]\ncenter = [2, 0]\nsize = [2, 8]\nheight_m = 0.15\n");
    let stance = stance(&step, pose2(0.0, 0.0, 0.0), None);
    let heights: Vec<f64> =
        (0..2000).map(|mm| stance.z_over_m(&step, &pose2(f64::from(mm) * 1e-3, 0.0, 0.0))).collect();
    assert!((heights[1999] - 0.15).abs() < 1e-12 && heights[0].abs() < 1e-12);
    let steepest = heights.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(steepest < 0.015, "{steepest} in a millimeter");
}
