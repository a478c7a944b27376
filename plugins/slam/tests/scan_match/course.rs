//! A drive of `scan_match_slam` around the loop, and what came of it.

use super::world::{LOOP_M, LoopWorld, gyro, lane, laser, stream};
use nalgebra::Matrix3;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::map::Map;
use rumbo_core::messages::{Estimate, Observation, Prior, Seen, Status};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{BuildContext, Cx, Slam};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_slam::scan_match_slam::ScanMatchSlamParams;

pub struct Mapper {
    pub slam: Box<dyn Slam>,
    pub map: Map,
    trace: Trace,
}

impl Mapper {
    pub fn new(params: &impl Plugin<dyn Slam>) -> Mapper {
        let slam = params.build(&BuildContext::bare("slam")).unwrap();
        Mapper { slam, map: Map::default(), trace: Trace::counting() }
    }

    pub fn start_at(params: &impl Plugin<dyn Slam>, map_from_base: Pose2) -> Mapper {
        let mut mapper = Mapper::new(params);
        let prior = Prior::Pose {
            map_from_base,
            odom_from_base: Pose2::identity(),
            covariance: Matrix3::identity() * 1e-6,
        };
        mapper.slam.start(&prior, &mut mapper.map).unwrap();
        mapper
    }

    pub fn see(&mut self, observations: &[Observation]) -> Estimate {
        let now = observations.iter().map(|observation| observation.stamp).max().unwrap_or(Time::ZERO);
        self.see_at(now, observations)
    }

    pub fn see_at(&mut self, now: Time, observations: &[Observation]) -> Estimate {
        let mut cx = Cx { now, trace: &self.trace };
        self.slam.update(&mut cx, Seen::sorted(observations), &mut self.map).unwrap()
    }

    pub fn count(&self, name: &str) -> f64 {
        let counters = self.trace.take().1;
        counters.iter().rev().find(|(found, _)| *found == name).map_or(f64::NAN, |(_, value)| *value)
    }
}

/// Between two places, meters.
pub fn off_m(estimate: &Pose2, truth: &Pose2) -> f64 {
    (truth.inverse() * estimate).translation.vector.norm()
}

#[derive(Clone, Copy)]
pub struct Course {
    pub speed_m_s: f64,
    pub rate_hz: f64,
    pub has_gyro: bool,
    /// Noise of each of its ten readings a scan.
    pub gyro_noise_rad_s: f64,
    /// What the robot sees with.
    pub camera: Camera,
    pub seed: u64,
}

/// What a scan is made with.
#[derive(Clone, Copy, PartialEq)]
pub enum Camera {
    Laser,
    Depth,
}

#[derive(Debug)]
pub struct Outcome {
    pub worst_m: f64,
    pub worst_rad: f64,
    /// Scans after which the robot did not say that it is tracking.
    pub n_unsure: usize,
    /// Scans after which it said that it is lost.
    pub n_lost: usize,
    /// Where it thought that it was.
    pub way: Vec<Pose2>,
    pub map: Map,
}

/// One loop from the place and heading where the lane begins.
pub fn drive(world: &LoopWorld, params: &ScanMatchSlamParams, course: &Course) -> Outcome {
    drive_with(world, params, course, |_| Vec::new())
}

/// The same with what else is seen at each time, and where the robot thought it was.
pub fn drive_with(
    world: &LoopWorld,
    params: &ScanMatchSlamParams,
    course: &Course,
    extra: impl Fn(f64) -> Vec<Observation>,
) -> Outcome {
    let mut rng = stream(course.seed);
    let mut mapper = Mapper::start_at(params, lane(0.0));
    let (mut worst_m, mut worst_rad, mut n_unsure, mut n_lost) = (0.0f64, 0.0f64, 0, 0);
    let mut way = Vec::new();
    let n_scans = (LOOP_M / course.speed_m_s * course.rate_hz) as usize;
    let mut before = lane(0.0);
    for k in 0..n_scans {
        let time_s = k as f64 / course.rate_hz;
        let truth = lane(time_s * course.speed_m_s);
        let mut seen = extra(time_s);
        if course.has_gyro {
            // Ten readings a scan.
            for part in 1..=10 {
                let s = time_s - (10 - part) as f64 / 10.0 / course.rate_hz;
                let normal: f64 = StandardNormal.sample(&mut rng);
                let at = lane(s.max(0.0) * course.speed_m_s);
                let turn = wrap_angle(at.rotation.angle() - before.rotation.angle());
                let step_s = 0.1 / course.rate_hz;
                // The mean rate of the step belongs to its middle.
                seen.push(gyro(s - 0.5 * step_s + 1.0, turn / step_s + course.gyro_noise_rad_s * normal));
                before = at;
            }
        }
        let scan = match course.camera {
            Camera::Laser => world.scan(&truth, &mut rng),
            Camera::Depth => world.depth_scan(&truth, &mut rng),
        };
        seen.push(laser(time_s + 1.0, scan));
        let estimate = mapper.see(&seen);
        let error = truth.inverse() * estimate.pose2();
        worst_m = worst_m.max(error.translation.vector.norm());
        worst_rad = worst_rad.max(error.rotation.angle().abs());
        n_unsure += usize::from(estimate.status != Status::Tracking);
        n_lost += usize::from(estimate.status == Status::Lost);
        way.push(estimate.pose2());
    }
    Outcome { worst_m, worst_rad, n_unsure, n_lost, way, map: mapper.map }
}

/// Distances of the cells that are surely occupied to the nearest true wall, ascending, meters.
pub fn wall_errors_m(world: &LoopWorld, map: &Map) -> Vec<f64> {
    let grid = map.grid.as_ref().unwrap();
    let occupied = grid.cells.iter().enumerate().filter(|(_, cell)| **cell > 1.0);
    let mut errors: Vec<f64> = occupied
        .map(|(idx, _)| {
            let center = grid.center_of(grid.cell_of(idx));
            world.distance_m(center.x, center.y)
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors
}
