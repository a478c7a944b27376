//! The rubble loop of the specification, a robot that drives around in it, and what came of localizing it there.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId};
use rumbo_core::registry::Plugin;
use rumbo_core::rng::{self, Rng};
use rumbo_core::stages::{BuildContext, Cx, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::GridSize;
use rumbo_kit::ray::RayGrid;
use rumbo_localizers::particle_filter::ParticleFilterParams;

const HALF_X_M: f64 = 7.0;
const HALF_Y_M: f64 = 4.6;
const RADIUS_M: f64 = 1.5;
const CORNER: [f64; 2] = [-10.5, -7.5];
const EXTENT_M: [f64; 2] = [21.0, 15.0];
const MAP_CELL_M: f64 = 0.05;
/// Finer than the map, so that scans do not simply repeat its cells.
const WORLD_CELL_M: f64 = 0.02;
const N_BEAMS: usize = 60;
const FIELD_OF_VIEW_RAD: f64 = 1.5 * std::f64::consts::PI;
const RANGE_DEVIATION_M: f64 = 0.03;
const STEP_M: f64 = 0.1;

pub struct LoopWorld {
    rays: RayGrid,
    pub map: Map,
}

impl LoopWorld {
    /// From the specification's file.
    pub fn load() -> LoopWorld {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/slam2d_sim_loop_world.json");
        let text = std::fs::read_to_string(path).expect(path);
        let world: serde_json::Value = serde_json::from_str(&text).expect("a JSON file");
        let segments: Vec<[f64; 4]> =
            serde_json::from_value(world["segments_base"].clone()).expect("segments");
        let (size, occupied) = raster(&segments, WORLD_CELL_M);
        LoopWorld { rays: RayGrid::new(size, &occupied), map: map(&segments) }
    }

    /// Exact range along a bearing, meters.
    pub fn range_m(&self, map_from_sensor: &Pose2, bearing_rad: f64) -> f64 {
        let (place, yaw) = (map_from_sensor.translation.vector, map_from_sensor.rotation.angle());
        let [x, y] = [place.x - CORNER[0], place.y - CORNER[1]].map(|v| v / WORLD_CELL_M);
        let ray = rumbo_kit::ray::Ray::at_angle(x, y, yaw + bearing_rad);
        self.rays.cast(&ray, 30.0 / WORLD_CELL_M) * WORLD_CELL_M
    }

    fn scan(&self, map_from_base: &Pose2, rng: &mut Rng) -> LaserScan {
        let step_rad = FIELD_OF_VIEW_RAD / (N_BEAMS - 1) as f64;
        let range = |k: usize| {
            let normal: f64 = StandardNormal.sample(&mut *rng);
            let bearing_rad = k as f64 * step_rad - FIELD_OF_VIEW_RAD / 2.0;
            (self.range_m(map_from_base, bearing_rad) + RANGE_DEVIATION_M * normal) as f32
        };
        let ranges: Vec<f32> = (0..N_BEAMS).map(range).collect();
        LaserScan {
            first_bearing_rad: -FIELD_OF_VIEW_RAD / 2.0,
            bearing_step_rad: step_rad,
            max_range_m: 30.0,
            ranges_m: ranges.into(),
            ..LaserScan::default()
        }
    }
}

fn raster(segments: &[[f64; 4]], cell_m: f64) -> (GridSize, Vec<u8>) {
    let [width, height] = EXTENT_M.map(|m| (m / cell_m).round() as usize);
    let size = GridSize::new(width, height);
    let mut occupied = vec![0; size.n_cells()];
    for [x0, y0, x1, y1] in segments {
        let n = ((x1 - x0).hypot(y1 - y0) / cell_m * 4.0).ceil() as usize;
        for k in 0..=n {
            let part = k as f64 / n as f64;
            let [x, y] = [x0 + part * (x1 - x0) - CORNER[0], y0 + part * (y1 - y0) - CORNER[1]];
            occupied[size.index((x / cell_m) as usize, (y / cell_m) as usize)] = 1;
        }
    }
    (size, occupied)
}

/// Walls occupied, everything else inside the outer box free.
fn map(segments: &[[f64; 4]]) -> Map {
    let (size, occupied) = raster(segments, MAP_CELL_M);
    let unknown = Grid::unknown(size.width as u32, size.height as u32, MAP_CELL_M).expect("a size");
    let header = rumbo_core::map::GridHeader { origin: [CORNER[0], CORNER[1], 0.0], ..*unknown.header() };
    let cells: Vec<f32> = (0..size.n_cells())
        .map(|index| {
            let place: Point2 = Grid::new(header, unknown.cells.clone())
                .map(|grid| grid.center_of(grid.cell_of(index)))
                .unwrap_or_default();
            let is_free = place.x.abs() < 10.0 && place.y.abs() < 7.0;
            let is_block = place.x.abs() < 4.0 && place.y.abs() < 2.2;
            match (occupied[index], is_free && !is_block) {
                (1, _) => Grid::CERTAIN,
                (_, true) => -Grid::CERTAIN,
                _ => 0.0,
            }
        })
        .collect();
    Map { version: 1, grid: Grid::new(header, Buffer::from(cells)).ok(), ..Map::default() }
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

/// A robot on the lane with its odometer and laser.
pub struct Drive<'a> {
    world: &'a LoopWorld,
    pub s_m: f64,
    odom_from_base: Pose2,
    time_s: f64,
    rng: Rng,
}

impl Drive<'_> {
    pub fn new(world: &LoopWorld, seed: u64) -> Drive<'_> {
        let mut rng = rng::stream(seed, "drive");
        let s_m = rng.random::<f64>() * 43.8;
        Drive { world, s_m, odom_from_base: Pose2::identity(), time_s: 0.0, rng }
    }

    /// The true pose.
    pub fn truth(&self) -> Pose2 {
        lane(self.s_m)
    }

    /// A tenth of a meter on: odometry with 5 percent of way and 1 degree of turn as noise, and a scan.
    pub fn step(&mut self) -> [Observation; 2] {
        let before = self.truth();
        self.s_m += STEP_M;
        self.time_s += 0.2;
        let way = before.inverse() * self.truth();
        let mut noise = |deviation: f64| -> f64 {
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            deviation * normal
        };
        let (longer, turn_rad) = (1.0 + noise(0.05), way.rotation.angle() + noise(0.017));
        let noisy = way.translation.vector * longer;
        self.odom_from_base *= pose2(noisy.x, noisy.y, turn_rad);
        let odometry = Odometry { odom_from_base: self.odom_from_base, ..Odometry::default() };
        let scan = self.world.scan(&self.truth(), &mut self.rng);
        [(0, Data::Odometry(odometry)), (1, Data::LaserScan(scan))].map(|(sensor, data)| Observation {
            sensor: SensorId(sensor),
            stamp: Time::from_secs(self.time_s),
            base_from_sensor: Pose3::identity(),
            valid: true,
            data,
        })
    }
}

/// A localizer with default parameters that follows a drive.
pub struct Follower {
    localizer: Box<dyn Localizer>,
}

impl Follower {
    pub fn start(params: &ParticleFilterParams, seed: u64, prior: &Prior, world: &LoopWorld) -> Follower {
        let context = BuildContext { seed, ..BuildContext::bare("localizer") };
        let mut localizer = params.build(&context).expect("the parameters are fine");
        localizer.start(prior, &world.map).expect("the map is fine");
        Follower { localizer }
    }

    /// One update of the filter: 0.2 m. The estimate, how far off it is, and how many particles there are.
    pub fn update(&mut self, drive: &mut Drive<'_>) -> (Estimate, f64, usize) {
        let (first, second) = (drive.step(), drive.step());
        let seen: Vec<Observation> = first.into_iter().chain(second).collect();
        let trace = Trace::watched();
        let mut cx = Cx { now: seen[3].stamp, trace: &trace };
        let estimate =
            self.localizer.update(&mut cx, Seen::sorted(&seen), &drive.world.map).expect("an estimate");
        let error_m = (estimate.pose2().translation.vector - drive.truth().translation.vector).norm();
        let counters = trace.take().1;
        let n = counters.iter().find(|(name, _)| *name == "particles").map_or(0.0, |(_, n)| *n);
        (estimate, error_m, n as usize)
    }
}

/// What a run from an unknown place, with a kidnapping, came to.
#[derive(Debug)]
pub struct GlobalRun {
    /// Error after ten updates and the largest from there on, meters.
    pub worst_after_ten_m: f64,
    /// Root mean square of the error after ten updates, meters.
    pub rms_m: f64,
    /// Median number of particles in the last half before the kidnapping.
    pub usual_particles: usize,
    /// Updates after the kidnapping until the error is below 0.3 m for three updates in a row.
    pub recovered_after: Option<usize>,
}

pub fn global_run(world: &LoopWorld, params: &ParticleFilterParams, seed: u64) -> GlobalRun {
    let mut drive = Drive::new(world, seed);
    let mut follower = Follower::start(params, seed, &Prior::Unknown, world);
    let errors: Vec<(f64, usize)> = (0..60)
        .map(|_| {
            let (_, error_m, n) = follower.update(&mut drive);
            (error_m, n)
        })
        .collect();
    let rest: Vec<f64> = errors[10..].iter().map(|(error_m, _)| *error_m).collect();
    let mut numbers: Vec<usize> = errors[30..].iter().map(|(_, n)| *n).collect();
    numbers.sort_unstable();
    drive.s_m += 17.0;
    let after: Vec<bool> = (0..40).map(|_| follower.update(&mut drive).1 < 0.3).collect();
    let recovered = after.windows(3).position(|three| three.iter().all(|near| *near));
    GlobalRun {
        worst_after_ten_m: rest.iter().copied().fold(0.0, f64::max),
        rms_m: rms(&rest),
        usual_particles: numbers[numbers.len() / 2],
        recovered_after: recovered.map(|idx| idx + 1),
    }
}

/// Root mean square of the error over a loop from a known pose, meters.
pub fn tracking_rms_m(world: &LoopWorld, params: &ParticleFilterParams, seed: u64) -> f64 {
    let mut drive = Drive::new(world, seed);
    let prior = Prior::Pose {
        map_from_base: drive.truth(),
        odom_from_base: Pose2::identity(),
        covariance: nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(0.01, 0.01, 0.003)),
    };
    let mut follower = Follower::start(params, seed, &prior, world);
    let errors: Vec<f64> = (0..200).map(|_| follower.update(&mut drive).1).collect();
    rms(&errors)
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}
