//! One scan of 361 beams looked at by the localizer `triangulation` on the generated 1000 x 1000 map: landmarks of it and
//! of what the map lets expect, their relations, and the pose. Bar: 10 ms.
#![allow(clippy::expect_used)]

use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::{Grid, GridHeader};
use rumbo_core::rng::stream;
use rumbo_core::time::Time;
use rumbo_kit::generated_world::GeneratedWorld;
use rumbo_kit::landmarks::BeamFan;
use rumbo_kit::ray::{Ray, RayGrid};
use rumbo_localizers::triangulation::scan::SeenScan;
use rumbo_localizers::triangulation::tracker::{Anchor, Tracker};
use rumbo_localizers::triangulation::{Estimator, TriangulationParams};

fn main() {
    divan::main();
}

const CELL_M: f64 = 0.05;
const N_BEAMS: usize = 361;
/// Places on a way of two meters, there and back.
const N_PLACES: usize = 20;
const NOISE: [f64; 3] = [0.03, 0.03, 0.05];

fn fan() -> BeamFan {
    BeamFan {
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: 0.5_f64.to_radians(),
        min_range_m: 0.05,
        max_range_m: 8.0,
    }
}

/// A way in free space with its scans, which have a ripple in place of noise.
struct Work {
    grid: Grid,
    poses: Vec<Pose2>,
    scans: Vec<Vec<f32>>,
}

impl Work {
    fn new() -> Work {
        let world = GeneratedWorld::indoor(1000, 4242);
        let rays = RayGrid::new(world.size, &world.occupied);
        let places = (0..world.size.n_cells()).step_by(4_973).filter(|&i| world.occupied[i] == 0);
        let start = |i: usize| {
            let (col, row) = world.size.col_row(i);
            pose2((col as f64 + 0.37) * CELL_M, (row as f64 + 0.61) * CELL_M, 0.2)
        };
        let range = |pose: &Pose2, bearing_rad: f64, reach_m: f64| {
            let [x, y] = [pose.translation.x / CELL_M, pose.translation.y / CELL_M];
            let ray = Ray::at_angle(x, y, pose.rotation.angle() + bearing_rad);
            rays.cast(&ray, reach_m / CELL_M) * CELL_M
        };
        let start = places.map(start).find(|pose| range(pose, 0.0, 8.0) > 3.0).expect("free space");
        let pose = |k: usize| start * pose2(0.1 * k.min(N_PLACES - k) as f64, 0.0, 0.0);
        let poses: Vec<Pose2> = (0..N_PLACES).map(pose).collect();
        let beam = |pose: &Pose2, k: usize| {
            let bearing = fan().first_bearing_rad + fan().bearing_step_rad * k as f64;
            (range(pose, bearing, 8.0) + 0.01 * (k as f64 * 12.9898).sin()) as f32
        };
        let scans = poses.iter().map(|pose| (0..N_BEAMS).map(|k| beam(pose, k)).collect()).collect();
        let cells: Vec<f32> =
            world.occupied.iter().map(|cell| Grid::CERTAIN * (2.0 * f32::from(*cell) - 1.0)).collect();
        let header = GridHeader {
            width: world.size.width as u32,
            height: world.size.height as u32,
            resolution_m: CELL_M,
            origin: [0.0; 3],
            occupied_above: Grid::OCCUPIED_ABOVE,
            free_below: Grid::FREE_BELOW,
        };
        Work { grid: Grid::new(header, cells.into()).expect("a grid"), poses, scans }
    }
}

#[divan::bench(args = ["least_squares", "pairs", "thesis"])]
fn one_scan(bencher: divan::Bencher, how: &str) {
    let work = Work::new();
    let params = TriangulationParams {
        estimator: if how == "pairs" { Estimator::Pairs } else { Estimator::LeastSquares },
        thesis_mode: how == "thesis",
        ..TriangulationParams::default()
    };
    let anchor = Anchor {
        map_from_base: work.poses[0],
        covariance: Matrix3::identity() * 1e-4,
        odom_from_base: work.poses[0],
    };
    let mut tracker = Tracker::new(params.settings(), anchor, stream(1, "landmarks"));
    let (mut k, mut time_s) = (0, 0.0);
    bencher.bench_local(|| {
        k = (k + 1) % N_PLACES;
        time_s += 0.5;
        let stamp = Time::from_secs(time_s);
        let seen =
            SeenScan { stamp, fan: fan(), ranges_m: &work.scans[k], base_from_sensor: Pose2::identity() };
        tracker.look(&seen, &work.poses[k], NOISE, Some((1, &work.grid)));
        tracker.report().n_related
    });
    assert!(tracker.report().n_related >= 2, "{:?}", tracker.report());
}
