//! The rubble loop of the specification, and a robot with a laser that drives around in it.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2};
use rumbo_core::messages::{Data, Imu, LaserScan, Observation, SensorId};
use rumbo_core::rng::{self, Rng};
use rumbo_core::time::Time;

const HALF_X_M: f64 = 7.0;
const HALF_Y_M: f64 = 4.6;
const RADIUS_M: f64 = 1.5;
pub const LOOP_M: f64 = 43.82477796077;
pub const N_BEAMS: usize = 541;

pub struct LoopWorld {
    segments: Vec<[f64; 4]>,
}

fn file() -> serde_json::Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/slam2d_sim_loop_world.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

impl LoopWorld {
    pub fn load() -> LoopWorld {
        LoopWorld { segments: serde_json::from_value(file()["segments_base"].clone()).unwrap() }
    }

    /// With the rubble near the lane that a depth camera needs.
    pub fn dense() -> LoopWorld {
        let segments = |key: &str| -> Vec<[f64; 4]> { serde_json::from_value(file()[key].clone()).unwrap() };
        LoopWorld { segments: [segments("segments_base"), segments("segments_dense_extra")].concat() }
    }

    /// A world of these walls.
    pub fn of(segments: Vec<[f64; 4]>) -> LoopWorld {
        LoopWorld { segments }
    }

    /// Exact range along a bearing, meters; infinity where nothing is within 30 m.
    pub fn range_m(&self, map_from_sensor: &Pose2, bearing_rad: f64) -> f64 {
        let from = map_from_sensor.translation.vector;
        let (sin, cos) = (map_from_sensor.rotation.angle() + bearing_rad).sin_cos();
        let mut nearest = f64::INFINITY;
        for [x0, y0, x1, y1] in &self.segments {
            let (wx, wy) = (x1 - x0, y1 - y0);
            let determinant = cos * wy - sin * wx;
            let range = ((x0 - from.x) * wy - (y0 - from.y) * wx) / determinant;
            let part = ((x0 - from.x) * sin - (y0 - from.y) * cos) / determinant;
            if range > 0.0 && (0.0..=1.0).contains(&part) && range < nearest {
                nearest = range;
            }
        }
        if nearest <= 30.0 { nearest } else { f64::INFINITY }
    }

    /// 541 beams over 270 degrees, 30 m, 3 cm noise.
    pub fn scan(&self, map_from_base: &Pose2, rng: &mut Rng) -> LaserScan {
        self.scan_of(map_from_base, N_BEAMS, rng)
    }

    /// The same with so many beams.
    pub fn scan_of(&self, map_from_base: &Pose2, n_beams: usize, rng: &mut Rng) -> LaserScan {
        let view_rad = 1.5 * std::f64::consts::PI;
        let step_rad = view_rad / (n_beams - 1) as f64;
        let range = |k: usize| {
            let normal: f64 = StandardNormal.sample(&mut *rng);
            (self.range_m(map_from_base, k as f64 * step_rad - 0.5 * view_rad) + 0.03 * normal) as f32
        };
        LaserScan {
            first_bearing_rad: -0.5 * view_rad,
            bearing_step_rad: step_rad,
            max_range_m: 30.0,
            ranges_m: (0..n_beams).map(range).collect::<Vec<f32>>().into(),
            ..LaserScan::default()
        }
    }

    /// The virtual scan of a depth camera: 160 columns over 57 degrees, 0.5 m to 8 m, noise of 1.5 mm/m² r².
    pub fn depth_scan(&self, map_from_base: &Pose2, rng: &mut Rng) -> LaserScan {
        let view_rad = 57f64.to_radians();
        let step_rad = view_rad / 159.0;
        let range = |k: usize| {
            let normal: f64 = StandardNormal.sample(&mut *rng);
            let exact = self.range_m(map_from_base, k as f64 * step_rad - 0.5 * view_rad);
            (exact + 0.0015 * exact * exact * normal) as f32
        };
        LaserScan {
            first_bearing_rad: -0.5 * view_rad,
            bearing_step_rad: step_rad,
            min_range_m: 0.5,
            max_range_m: 8.0,
            ranges_m: (0..160)
                .map(range)
                .map(|r| if r < 8.0 { r } else { f32::INFINITY })
                .collect::<Vec<_>>()
                .into(),
            ..LaserScan::default()
        }
    }

    /// How far a point is from the nearest wall, meters.
    pub fn distance_m(&self, x: f64, y: f64) -> f64 {
        let to_segment = |[x0, y0, x1, y1]: &[f64; 4]| {
            let (wx, wy) = (x1 - x0, y1 - y0);
            let part = (((x - x0) * wx + (y - y0) * wy) / (wx * wx + wy * wy)).clamp(0.0, 1.0);
            (x - x0 - part * wx).hypot(y - y0 - part * wy)
        };
        self.segments.iter().map(to_segment).fold(f64::INFINITY, f64::min)
    }
}

#[test]
fn rays_are_those_of_the_specification() {
    let world = LoopWorld::load();
    for check in file()["raycast_checks"].as_array().unwrap() {
        let pose = lane(check["s"].as_f64().unwrap());
        let bearings = check["bearings_deg"].as_array().unwrap().iter();
        for (bearing, range) in bearings.zip(check["ranges_base"].as_array().unwrap()) {
            let found = world.range_m(&pose, bearing.as_f64().unwrap().to_radians());
            assert!((found - range.as_f64().unwrap()).abs() < 0.005, "{check}: {found}");
        }
    }
}

/// Where the lane is after so many meters, driven counter-clockwise.
pub fn lane(s_m: f64) -> Pose2 {
    let (straight_x, straight_y) = (2.0 * (HALF_X_M - RADIUS_M), 2.0 * (HALF_Y_M - RADIUS_M));
    let arc_m = RADIUS_M * std::f64::consts::FRAC_PI_2;
    let mut pose = pose2(-(HALF_X_M - RADIUS_M), -HALF_Y_M, 0.0);
    let mut left_m = s_m.rem_euclid(2.0 * (straight_x + straight_y) + 4.0 * arc_m);
    for side in 0..4 {
        let straight_m = if side % 2 == 0 { straight_x } else { straight_y };
        let way_m = left_m.min(straight_m);
        pose *= Twist::new(1.0, 0.0).integrate(way_m);
        left_m -= way_m;
        let way_m = left_m.min(arc_m);
        pose *= Twist::new(1.0, 1.0 / RADIUS_M).integrate(way_m);
        left_m -= way_m;
    }
    pose
}

/// Readings that have nothing to do with the world.
pub fn rubbish(rng: &mut Rng) -> Vec<f32> {
    (0..N_BEAMS).map(|_| rng.random::<f32>() * 30.0).collect()
}

pub fn laser(time_s: f64, scan: LaserScan) -> Observation {
    observation(1, time_s, Data::LaserScan(scan))
}

/// A gyroscope's reading.
pub fn gyro(time_s: f64, rate_rad_s: f64) -> Observation {
    observation(2, time_s, Data::Imu(Imu { rates_rad_s: [0.0, 0.0, rate_rad_s], ..Imu::default() }))
}

pub fn observation(sensor: u16, time_s: f64, data: Data) -> Observation {
    Observation {
        sensor: SensorId(sensor),
        stamp: Time::from_secs(time_s),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data,
    }
}

pub fn stream(seed: u64) -> Rng {
    rng::stream(seed, "scan match loop")
}
