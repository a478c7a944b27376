//! Scan odometry against published numbers, brute force, finite differences and rooms whose walls are known.

mod corridors;
mod directions;
mod nearest;
mod rooms;
mod slices;
mod vectors;

use super::*;
use nalgebra::Matrix3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;

/// A wall from one end to the other, meters.
pub(crate) type Wall = [[f64; 2]; 2];

/// Walls around a closed way through these corners.
fn around(corners: &[[f64; 2]]) -> Vec<Wall> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(from, to)| [*from, *to]).collect()
}

/// A room of 9 m by 6 m with a bay, a pillar and a slanted cupboard.
fn room() -> Vec<Wall> {
    let outline =
        [[-4.0, -3.0], [5.0, -3.0], [5.0, 1.0], [6.5, 1.0], [6.5, 2.2], [5.0, 2.2], [5.0, 3.0], [-4.0, 3.0]];
    let mut walls = around(&outline);
    walls.extend(around(&[[2.0, -1.6], [2.5, -1.6], [2.5, -1.1], [2.0, -1.1]]));
    walls.extend(around(&[[-2.5, 1.0], [-1.2, 1.9], [-1.5, 2.4], [-2.8, 1.5]]));
    walls
}

/// Two parallel walls, 2.4 m apart, without ends that can be seen.
pub(crate) fn corridor() -> Vec<Wall> {
    vec![[[-200.0, -1.2], [200.0, -1.2]], [[-200.0, 1.2], [200.0, 1.2]]]
}

/// How far a ray goes to a wall, meters.
fn range_to(wall: &Wall, [x, y]: [f64; 2], bearing_rad: f64) -> Option<f64> {
    let [[ax, ay], [bx, by]] = *wall;
    let (sine, cosine) = bearing_rad.sin_cos();
    let (wx, wy) = (bx - ax, by - ay);
    let across = cosine * wy - sine * wx;
    let range = ((ax - x) * wy - (ay - y) * wx) / across;
    let share = ((ax - x) * sine - (ay - y) * cosine) / across;
    (range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
}

/// What a scanner in the middle of the base sees from a pose, with noise of this deviation, meters.
pub(crate) fn seen(
    walls: &[Wall],
    at: &Pose2,
    n_beams: usize,
    noise_m: f64,
    rng: &mut Xoshiro256PlusPlus,
) -> LaserScan {
    let opening_rad = if n_beams > 600 { 270f64 } else { 180.0 }.to_radians();
    let (first_rad, step_rad) = (-opening_rad / 2.0, opening_rad / (n_beams - 1) as f64);
    let noise = Normal::new(0.0, noise_m).unwrap();
    let place = [at.translation.x, at.translation.y];
    let ranges = (0..n_beams).map(|k| {
        let bearing_rad = at.rotation.angle() + first_rad + step_rad * k as f64;
        let hits = walls.iter().filter_map(|wall| range_to(wall, place, bearing_rad));
        (hits.fold(f64::INFINITY, f64::min) + noise.sample(rng)) as f32
    });
    LaserScan {
        first_bearing_rad: first_rad,
        bearing_step_rad: step_rad,
        max_range_m: 30.0,
        ranges_m: ranges.collect::<Vec<_>>().into(),
        ..LaserScan::default()
    }
}

fn placed(scan: &LaserScan) -> ScanPoints {
    let mut points = ScanPoints::default();
    points.place(scan, &Pose3::identity());
    points
}

fn key_of(scan: &LaserScan, settings: &ScanOdometrySettings) -> KeyScan {
    let mut key = KeyScan::default();
    key.take(&placed(scan), settings);
    key
}

fn prior(key_from_base: Pose2) -> PosePrior {
    PosePrior { key_from_base, covariance: Matrix3::identity() * 0.01 }
}

fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// How far apart two poses are, meters and radians.
fn apart(one: &Pose2, other: &Pose2) -> [f64; 2] {
    let step = one.inverse() * other;
    [step.translation.vector.norm(), step.rotation.angle().abs()]
}
