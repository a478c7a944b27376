//! Watches a drive: how far the estimate is from the truth at each scan, how far the leveled attitude is, and what is on the
//! map.

use nalgebra::Vector3;
use rumbo_core::engine::{EndReason, Engine, Observer, StepView};
use rumbo_core::frames::{Point2, Pose3, flatten};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{Data, Status};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// What a drive came to.
#[derive(Debug)]
pub struct Drive {
    /// Why it ended.
    pub reason: EndReason,
    /// Estimate to truth at the scans, meters.
    pub errors_m: Vec<f64>,
    /// Attitude from the sensors to the truth: seconds, degrees between the two vertical directions.
    pub tilts_deg: Vec<(f64, f64)>,
    /// Scans after which the robot did not say that it is tracking.
    pub n_unsure: usize,
    /// The map at the times that were asked for, and at the end.
    pub maps: Vec<Map>,
}

impl Drive {
    /// The largest error, meters.
    pub fn worst_m(&self) -> f64 {
        self.errors_m.iter().copied().fold(0.0, f64::max)
    }
}

struct Watcher {
    drive: Drive,
    keep_at_s: Vec<f64>,
}

fn up(map_from_base: &Pose3) -> Vector3<f64> {
    map_from_base.rotation.inverse() * Vector3::z()
}

impl Observer for Watcher {
    fn on_step(&mut self, view: &StepView<'_>) {
        let drive = &mut self.drive;
        let truth = &view.truth.unwrap().map_from_base;
        let seconds = view.now.as_secs();
        let attitude = view.observations.iter().rev().find_map(|observation| match &observation.data {
            Data::Imu(imu) if observation.stamp == view.now => imu.attitude_rad,
            _ => None,
        });
        if let Some([roll, pitch, yaw]) = attitude {
            let turn = nalgebra::UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            let seen = up(&Pose3::from_parts(Default::default(), turn));
            drive.tilts_deg.push((seconds, seen.angle(&up(truth)).to_degrees()));
        }
        let is_scan = view.observations.iter().any(|seen| matches!(seen.data, Data::LaserScan(_)));
        if is_scan && view.estimate_is_new && view.estimate.stamp == view.now {
            let error = flatten(truth).inverse() * view.estimate.pose2();
            drive.errors_m.push(error.translation.vector.norm());
            drive.n_unsure += usize::from(view.estimate.status != Status::Tracking);
        }
        if self.keep_at_s.first().is_some_and(|at_s| seconds >= *at_s) {
            self.keep_at_s.remove(0);
            drive.maps.push(view.map.clone());
        }
    }
}

/// Drives a shipped pipeline with these changes; the map is kept at these times.
pub fn drive(pipeline: &str, sets: &[&str], keep_at_s: &[f64]) -> Drive {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines").join(pipeline);
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let ready = rumbo::load::load(&file, &sets, &rumbo::registry().unwrap()).ok().expect("a sound pipeline");
    let (errors_m, tilts_deg, maps) = (Vec::new(), Vec::new(), Vec::new());
    let drive = Drive { reason: EndReason::Ended, errors_m, tilts_deg, n_unsure: 0, maps };
    let mut watcher = Watcher { drive, keep_at_s: keep_at_s.to_vec() };
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    let end = engine.run(&mut [&mut watcher], &AtomicBool::new(false));
    let mut drive = watcher.drive;
    drive.reason = end.reason;
    drive.maps.push(engine.view().map.clone());
    drive
}

/// The walls of the rubble loop, as they were published.
pub struct Walls(Vec<[f64; 4]>);

impl Walls {
    /// Reads them.
    pub fn load() -> Walls {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/plugins/slam/tests/data/slam2d_sim_loop_world.json");
        let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        Walls(serde_json::from_value(file["segments_base"].clone()).unwrap())
    }

    fn distance_m(&self, at: Point2) -> f64 {
        let to_wall = |[x0, y0, x1, y1]: &[f64; 4]| {
            let (from, along) =
                (Vector3::new(at.x - x0, at.y - y0, 0.0), Vector3::new(x1 - x0, y1 - y0, 0.0));
            let share = (from.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (from - along * share).norm()
        };
        self.0.iter().map(to_wall).fold(f64::INFINITY, f64::min)
    }

    /// Distances of the cells that are surely occupied to the nearest true wall, ascending, meters.
    pub fn errors_m(&self, map: &Map) -> Vec<f64> {
        let mut errors: Vec<f64> =
            occupied(map.grid.as_ref().unwrap()).map(|at| self.distance_m(at)).collect();
        errors.sort_by(f64::total_cmp);
        errors
    }
}

fn occupied(grid: &Grid) -> impl Iterator<Item = Point2> + '_ {
    assert!(grid.cells.iter().all(|cell| cell.is_finite()));
    let surely = grid.cells.iter().enumerate().filter(|(_, cell)| **cell > 1.0);
    surely.map(|(idx, _)| grid.center_of(grid.cell_of(idx)))
}

/// The value below which 95 % of ascending ones are.
pub fn at_95(ascending: &[f64]) -> f64 {
    ascending[ascending.len() * 95 / 100]
}
