//! The work that the particle filter is timed on: a scan of 181 beams in a generated office, particles around the truth.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::LaserScan;
use rumbo_core::rng;
use rumbo_kit::generated_world::GeneratedWorld;
use rumbo_kit::grid_poses::GridPoses;
use rumbo_kit::ray::{Ray, RayGrid};
use rumbo_localizers::particle_filter::beams::ScanBeams;
use rumbo_localizers::particle_filter::filter::{FilterSettings, ParticleFilter};
use rumbo_localizers::particle_filter::kld::KldBound;
use rumbo_localizers::particle_filter::measurement::{
    FieldModel, MeasurementModel, Obstacles, ScanLikelihood,
};
use rumbo_localizers::particle_filter::motion::OdometryMotion;
use rumbo_localizers::particle_filter::recovery::Recovery;
use rumbo_localizers::particle_filter::streams::Streams;
use rumbo_localizers::particle_filter::terrain::{Penalties, Terrain};
use std::hint::black_box;

/// Beams of the scan.
pub const N_BEAMS: usize = 181;
const CELL_M: f64 = 0.05;

/// World, scan and filter.
pub struct Work {
    world: GeneratedWorld,
    map: Map,
    truth: Pose2,
    scan: LaserScan,
    filter: ParticleFilter,
    terrain: Terrain,
}

/// Weights of many particles by one model.
pub struct Weights {
    likelihood: Box<dyn ScanLikelihood>,
    beams: ScanBeams,
    poses: GridPoses,
    ln_p: Vec<f64>,
}

impl Weights {
    /// Weighs all particles.
    pub fn run(&mut self) {
        self.ln_p.fill(0.0);
        self.likelihood.add_ln(&self.beams, &self.poses, &mut self.ln_p);
        black_box(&self.ln_p);
    }
}

impl Work {
    /// The office of 50 m by 50 m.
    pub fn office() -> Work {
        let world = GeneratedWorld::indoor(1000, 4242);
        let log_odds = |cell: &u8| if *cell == 1 { Grid::CERTAIN } else { -Grid::CERTAIN };
        let cells: Vec<f32> = world.occupied.iter().map(log_odds).collect();
        let unknown = Grid::unknown(1000, 1000, CELL_M).expect("a size");
        let grid = Grid::new(*unknown.header(), Buffer::from(cells)).expect("as many cells");
        let rays = RayGrid::new(world.size, &world.occupied);
        let first_free = (300 * 1000 + 300..).find(|i| rays.cast(&ray(*i, 0.0), 30.0) > 20.0).unwrap_or(0);
        let (col, row) = world.size.col_row(first_free);
        let truth = pose2((col as f64 + 0.5) * CELL_M, (row as f64 + 0.5) * CELL_M, 0.0);
        let range = |k: usize| rays.cast(&ray(first_free, (k as f64 - 90.0).to_radians()), 400.0) * CELL_M;
        let ranges: Vec<f32> = (0..N_BEAMS).map(|k| range(k) as f32).collect();
        let scan = LaserScan {
            first_bearing_rad: -90f64.to_radians(),
            bearing_step_rad: 1f64.to_radians(),
            max_range_m: 20.0,
            ranges_m: ranges.into(),
            ..LaserScan::default()
        };
        let penalties = Penalties { occupied: 50.0, unknown: 5.0 };
        let terrain = Terrain::new(1, &grid, &FieldModel::default(), 0.2, 0.2, penalties);
        let map = Map { version: 1, grid: Some(grid), ..Map::default() };
        Work { world, map, truth, scan, filter: filter(), terrain }
    }

    fn beams(&self, n: usize) -> ScanBeams {
        ScanBeams::of(&self.scan, &Pose3::identity(), n)
    }

    /// `n` particles within decimeters of the truth.
    pub fn weights(&self, model: &dyn MeasurementModel, n: usize) -> Weights {
        let obstacles =
            Obstacles { size: self.world.size, resolution_m: CELL_M, occupied: &self.world.occupied };
        let mut poses = GridPoses::default();
        let place = self.truth.translation.vector / CELL_M;
        for k in 0..n {
            let off = |by: f64| ((k as f64 * by).fract() - 0.5) * 2.0;
            poses.push(place.x + 3.0 * off(0.618), place.y + 3.0 * off(0.7549), 0.1 * off(0.5698));
        }
        Weights {
            likelihood: model.on_map(&obstacles),
            beams: self.beams(N_BEAMS),
            ln_p: vec![0.0; n],
            poses,
        }
    }

    /// Move, weigh, cluster and draw 10,000 particles anew.
    pub fn step(&mut self, n_beams: usize) {
        let Some(grid) = &self.map.grid else { return };
        if self.filter.particles().is_empty() {
            let covariance = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(0.01, 0.01, 0.0025));
            self.filter.start_around(&self.truth, &covariance);
        }
        // There and back, so that the particles stay where the scan was taken.
        let scans = [self.beams(n_beams)];
        self.filter.advance(&pose2(0.0, 0.0, 0.0), &pose2(0.0001, 0.0, 0.02));
        self.filter.weigh(&scans, &mut self.terrain);
        black_box(self.filter.clusters());
        self.filter.resample(&self.terrain, grid);
    }

    /// Everything that is computed once for a map.
    pub fn new_map(&mut self) {
        if let Some(grid) = &self.map.grid {
            let penalties = Penalties { occupied: 50.0, unknown: 5.0 };
            self.terrain = Terrain::new(1, grid, &FieldModel::default(), 0.2, 0.2, penalties);
        }
    }
}

fn ray(cell: usize, angle_rad: f64) -> Ray {
    Ray::at_angle((cell % 1000) as f64 + 0.5, (cell / 1000) as f64 + 0.5, angle_rad)
}

/// Always 10,000 particles.
fn filter() -> ParticleFilter {
    let settings = FilterSettings {
        bound: KldBound { epsilon: 0.02, z: 2.3263, min_particles: 10_000, max_particles: 10_000 },
        is_adaptive: true,
        likelihood_exponent: 0.3,
        least_effective_share: 0.01,
        slip_share: 0.0,
        resample_threshold: 0.5,
        resample_interval: 1,
    };
    let streams = Streams::new(rng::stream(1, "work"));
    ParticleFilter::new(settings, Box::new(OdometryMotion::default()), Recovery::new(0.05, 0.5), streams)
}
