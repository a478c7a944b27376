//! Drives through the three office maps, with a laser, an odometer that errs, and somebody who walks ahead of the robot.

use super::super::tracker::{Anchor, SeenScan, Tracker, TrackerSettings};
use nalgebra::Matrix3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_core::map::{Grid, GridHeader};
use rumbo_core::rng::{Rng, stream};
use rumbo_core::time::Time;
use rumbo_kit::GridSize;
use rumbo_kit::landmarks::BeamFan;
use rumbo_kit::ray::{Ray, RayGrid};
use std::f64::consts::{FRAC_PI_2, TAU};

const CELL_M: f64 = 0.05;
/// Between scans, and what the robot does meanwhile.
const STEP_S: f64 = 0.5;
const STEP_M: f64 = 0.1;
const STEP_RAD: f64 = 0.074;
const RANGE_DEVIATION_M: f64 = 0.01;

/// A map with what is needed to drive in it.
pub struct Office {
    pub grid: Grid,
    rays: RayGrid,
    /// Grown by the robot.
    room: RayGrid,
    size: GridSize,
}

impl Office {
    pub fn named(name: &str) -> Office {
        let file: toml::Table =
            toml::from_str(include_str!("../../../tests/data/natural_landmark/maps.toml")).unwrap();
        let maps = file["map"].as_array().unwrap();
        let map = maps.iter().find(|map| map["name"].as_str() == Some(name)).unwrap();
        let number = |value: &toml::Value| value.as_integer().unwrap() as usize;
        let size = GridSize::new(number(&map["columns"]), number(&map["lines"]));
        let mut occupied = vec![0_u8; size.n_cells()];
        for rectangle in map["rectangles"].as_array().unwrap() {
            let [line, column, height, width, value] = [0, 1, 2, 3, 4].map(|k| number(&rectangle[k]));
            for line in line..line + height {
                for column in column..column + width {
                    occupied[size.index(column, size.height - 1 - line)] = value as u8;
                }
            }
        }
        let n_occupied = occupied.iter().filter(|cell| **cell == 1).count();
        assert_eq!(n_occupied, number(&map["occupied_cells"]), "{name}");
        let cells: Vec<f32> =
            occupied.iter().map(|cell| if *cell == 1 { Grid::CERTAIN } else { -Grid::CERTAIN }).collect();
        let header = GridHeader {
            width: size.width as u32,
            height: size.height as u32,
            resolution_m: CELL_M,
            origin: [0.0; 3],
            occupied_above: Grid::OCCUPIED_ABOVE,
            free_below: Grid::FREE_BELOW,
        };
        let field = rumbo_kit::distance_field::squared_distance_field(size, &occupied);
        let grown: Vec<u8> = field.iter().map(|squared| u8::from(*squared <= 36)).collect();
        let (rays, room) = (RayGrid::new(size, &occupied), RayGrid::new(size, &grown));
        Office { grid: Grid::new(header, cells.into()).unwrap(), rays, room, size }
    }

    /// Poses half a second apart: turn in place, go straight, again, until the way is long enough.
    fn route(&self, length_m: f64, rng: &mut Rng) -> Vec<Pose2> {
        let (mut x, mut y) = loop {
            let [col, row] = [self.size.width, self.size.height].map(|n| rng.random_range(0..n));
            if !self.room.is_occupied(col as i64, row as i64) {
                break ((col as f64 + 0.5) * CELL_M, (row as f64 + 0.5) * CELL_M);
            }
        };
        let mut yaw = rng.random_range(0.0..TAU);
        let mut poses = vec![pose2(x, y, yaw)];
        let mut driven_m = 0.0;
        while driven_m < length_m {
            let next: f64 = yaw + rng.random_range(-2.0..2.0);
            let ray = Ray::at_angle(x / CELL_M, y / CELL_M, next);
            let free_m = self.room.cast(&ray, 200.0) * CELL_M - 0.05;
            if free_m < 0.3 && rng.random::<f64>() < 0.95 {
                continue;
            }
            while (next - yaw).abs() > 1e-9 {
                yaw += (next - yaw).clamp(-STEP_RAD, STEP_RAD);
                poses.push(pose2(x, y, yaw));
            }
            let mut left_m = free_m.max(0.0).min(3.0).min(length_m - driven_m);
            driven_m += left_m;
            while left_m > 1e-9 {
                let step_m = left_m.min(STEP_M);
                left_m -= step_m;
                x += step_m * yaw.cos();
                y += step_m * yaw.sin();
                poses.push(pose2(x, y, yaw));
            }
        }
        poses
    }

    fn scan(&self, pose: &Pose2, time_s: f64, has_walker: bool, rng: &mut Rng) -> Vec<f32> {
        let fan = fan();
        // A disc that goes to and fro 1.5 m ahead at 0.5 m/s.
        let phase = (time_s * 0.5 / 4.0).fract() * 4.0;
        let walker = [1.5, if phase < 2.0 { phase - 1.0 } else { 3.0 - phase }];
        let beam = |k: usize, rng: &mut Rng| {
            let bearing = fan.first_bearing_rad + fan.bearing_step_rad * k as f64;
            let [col, row] = [pose.translation.x / CELL_M, pose.translation.y / CELL_M];
            let ray = Ray::at_angle(col, row, pose.rotation.angle() + bearing);
            let mut range = self.rays.cast(&ray, fan.max_range_m / CELL_M) * CELL_M;
            let (along, across) = (
                walker[0] * bearing.cos() + walker[1] * bearing.sin(),
                walker[1] * bearing.cos() - walker[0] * bearing.sin(),
            );
            if has_walker && along > 0.0 && across.abs() < 0.2 {
                range = range.min(along - (0.04 - across * across).sqrt());
            }
            let noise: f64 = StandardNormal.sample(rng);
            if range >= fan.max_range_m { f32::INFINITY } else { (range + RANGE_DEVIATION_M * noise) as f32 }
        };
        (0..361).map(|k| beam(k, rng)).collect()
    }
}

fn fan() -> BeamFan {
    BeamFan {
        first_bearing_rad: -FRAC_PI_2,
        bearing_step_rad: 0.5_f64.to_radians(),
        min_range_m: 0.05,
        max_range_m: 8.0,
    }
}

/// What came of a drive.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Errors at the end: x, y (meters), heading (degrees).
    pub end: [f64; 3],
    /// The same by odometry alone.
    pub odometry_end: [f64; 3],
    /// Largest distance from the truth on the way, meters.
    pub worst_m: f64,
    /// Squared errors in terms of the claimed covariance, at every tenth scan.
    pub nees: Vec<f64>,
}

/// A drive of this length.
pub fn drive(
    office: &Office,
    settings: &TrackerSettings,
    length_m: f64,
    has_walker: bool,
    seed: u64,
) -> Outcome {
    let mut rng = stream(seed, "drive");
    let route = office.route(length_m, &mut rng);
    // Odometry (b): a wrong scale, a drift of the heading, and noise on turns.
    let scale = 1.0 + rng.random_range(-0.05..0.05);
    let drift = rng.random_range(-3.0..3.0_f64).to_radians();
    let noise = [0.03, 0.03, 0.05];
    let covariance = Matrix3::from_diagonal(&nalgebra::Vector3::new(2.5e-5, 2.5e-5, 4e-6));
    let mut odom_from_base = Pose2::identity();
    let anchor = Anchor { map_from_base: route[0], covariance, odom_from_base };
    let mut tracker = Tracker::new(*settings, anchor);
    let mut outcome = Outcome::default();
    let mut last = route[0];
    for (k, pose) in route.iter().enumerate() {
        let step = last.inverse() * pose;
        let (way, turn) = (step.translation.vector * scale, step.rotation.angle());
        let normal: f64 = StandardNormal.sample(&mut rng);
        let turned = turn * (1.0 + 0.05 * normal) + drift * way.norm();
        odom_from_base *= Pose2::new(way, turned);
        last = *pose;
        let stamp = Time::from_secs(STEP_S * k as f64);
        let ranges = office.scan(pose, stamp.as_secs(), has_walker, &mut rng);
        if tracker.is_due(stamp, &odom_from_base) {
            let seen = SeenScan { stamp, fan: fan(), ranges_m: &ranges, base_from_sensor: Pose2::identity() };
            tracker.look(&seen, &odom_from_base, noise, Some((1, &office.grid)));
        }
        let (found, covariance) = tracker.carried_to(&odom_from_base, noise);
        let off = error(&found, pose);
        outcome.worst_m = outcome.worst_m.max(off[0].hypot(off[1]));
        if k % 10 == 9 {
            let off = nalgebra::Vector3::new(off[0], off[1], off[2].to_radians());
            outcome.nees.push(off.dot(&(covariance.try_inverse().unwrap() * off)));
        }
        outcome.end = off;
        outcome.odometry_end = error(&(route[0] * odom_from_base), pose);
    }
    outcome
}

fn error(found: &Pose2, truth: &Pose2) -> [f64; 3] {
    let way = found.translation.vector - truth.translation.vector;
    [way.x, way.y, wrap_angle(found.rotation.angle() - truth.rotation.angle()).to_degrees()]
}
