//! The published hall of rubble, a laser in it, and a robot that drives around.

use crate::rbpf_slam::RbpfSlamParams;
use crate::rbpf_slam::tracker::Tracker;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::{Data, LaserScan, Observation, Odometry, Seen, SensorId};
use rumbo_core::rng::{Rng, stream};
use rumbo_core::time::Time;
use rumbo_kit::streams::Streams;
use rumbo_kit::turn_way_turn::noisy;

pub const BEAMS: usize = 271;
const REACH_M: f64 = 30.0;

/// Opaque segments.
pub struct Hall(Vec<[f64; 4]>);

impl Hall {
    pub fn published() -> Hall {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/slam2d_sim_loop_world.json");
        let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let segment = |s: &serde_json::Value| [0, 1, 2, 3].map(|k| s[k].as_f64().unwrap());
        Hall(file["segments_base"].as_array().unwrap().iter().map(segment).collect())
    }

    /// Way along a ray to the first segment, by solving for both parameters.
    pub fn range_m(&self, x: f64, y: f64, bearing: f64) -> f64 {
        let (sin, cos) = bearing.sin_cos();
        let hit = |[x0, y0, x1, y1]: &[f64; 4]| {
            let (dx, dy) = (x1 - x0, y1 - y0);
            let across = cos * dy - sin * dx;
            let along = ((x0 - x) * dy - (y0 - y) * dx) / across;
            let share = ((x0 - x) * sin - (y0 - y) * cos) / across;
            (across.abs() > 1e-12 && along > 0.0 && (0.0..=1.0).contains(&share)).then_some(along)
        };
        self.0.iter().filter_map(hit).fold(f64::INFINITY, f64::min)
    }

    /// A scan over 270 degrees with noise of 0.03 m.
    pub fn scan(&self, pose: &Pose2, rng: &mut Rng) -> LaserScan {
        let (first, step) = (-135f64.to_radians(), 1f64.to_radians());
        let at = pose.translation;
        let reading = |k: usize| {
            let bearing = pose.rotation.angle() + first + step * k as f64;
            let range = self.range_m(at.x, at.y, bearing) + noisy([0.0; 3], [0.03, 0.0, 0.0], rng)[0];
            if range < REACH_M { range as f32 } else { f32::INFINITY }
        };
        LaserScan {
            first_bearing_rad: first,
            bearing_step_rad: step,
            max_range_m: REACH_M as f32,
            ranges_m: (0..BEAMS).map(reading).collect::<Vec<f32>>().into(),
            ..LaserScan::default()
        }
    }
}

/// The lane: a rounded rectangle, counter-clockwise, from the lower left.
pub fn lane(way_m: f64) -> Pose2 {
    let (half_x, half_y, radius) = (7.0, 4.6, 1.5);
    let arc_m = radius * std::f64::consts::FRAC_PI_2;
    let mut pose = pose2(-(half_x - radius), -half_y, 0.0);
    let mut left_m = way_m;
    for side in (0..).map(|k| if k % 2 == 0 { 2.0 * (half_x - radius) } else { 2.0 * (half_y - radius) }) {
        let straight_m = left_m.min(side);
        pose *= pose2(straight_m, 0.0, 0.0);
        left_m -= straight_m;
        let turn = left_m.min(arc_m) / radius;
        pose *= pose2(radius * turn.sin(), radius * (1.0 - turn.cos()), turn);
        left_m -= left_m.min(arc_m);
        if left_m <= 0.0 {
            break;
        }
    }
    pose
}

/// A drive that is seen step by step.
pub struct Drive {
    pub hall: Hall,
    pub rng: Rng,
    pub odom_from_base: Pose2,
    pub last: Pose2,
}

impl Drive {
    pub fn new(seed: u64) -> Drive {
        let odom_from_base = pose2(4.0, -1.0, 0.7);
        Drive { hall: Hall::published(), rng: stream(seed, "drive"), odom_from_base, last: lane(0.0) }
    }

    /// How far a pose is turned from the one before, radians.
    pub fn turn_since(&self, pose: &Pose2) -> f64 {
        (self.last.inverse() * pose).rotation.angle()
    }

    /// Odometry that errs by 3 % and more in curves, and a scan, from this pose.
    pub fn seen(&mut self, seconds: f64, pose: &Pose2) -> Vec<Observation> {
        let step = self.last.inverse() * pose;
        let (way, turn) = (step.translation.vector.norm(), step.rotation.angle());
        let [along, turned, _] =
            noisy([1.0, 0.0, 0.0], [0.05, 0.002 + 0.02 * way + 0.05 * turn.abs(), 0.0], &mut self.rng);
        let factor = 0.97 * along;
        self.odom_from_base *= pose2(step.translation.x * factor, step.translation.y * factor, turn + turned);
        self.last = *pose;
        let odometry = Odometry { odom_from_base: self.odom_from_base, ..Odometry::default() };
        let scan = self.hall.scan(pose, &mut self.rng);
        vec![observation(seconds, Data::Odometry(odometry)), observation(seconds, Data::LaserScan(scan))]
    }
}

pub fn observation(seconds: f64, data: Data) -> Observation {
    Observation {
        sensor: SensorId(0),
        stamp: Time::from_secs(seconds),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data,
    }
}

/// A tracker that was started at the beginning of the lane.
pub fn tracker(params: &RbpfSlamParams, seed: u64) -> Tracker {
    let mut tracker = Tracker::new(params.settings().unwrap(), Streams::new(stream(seed, "slam")));
    tracker.start(&lane(0.0), &(Matrix3::identity() * 1e-6));
    tracker
}

pub fn update(tracker: &mut Tracker, seconds: f64, seen: &[Observation]) -> bool {
    tracker.update(Time::from_secs(seconds), Seen::sorted(seen))
}

/// Way and turn between two poses, meters and degrees.
pub fn apart(a: &Pose2, b: &Pose2) -> [f64; 2] {
    let off = a.inverse() * b;
    [off.translation.vector.norm(), off.rotation.angle().abs().to_degrees()]
}
