//! One scan of 20 lines against maps of up to 500 walls. Bar: 0.25 ms with 95 walls.
use nalgebra::{Matrix5, Vector5};
use rumbo_core::map::Line;
use rumbo_kit::line_filter::{FilterSettings, LineFilter, MapUse, Mount, WallMap};
use rumbo_kit::lines::SensedLine;

fn main() {
    divan::main();
}

/// Spokes around the robot, one wall each, all facing it; they are nearer to each other than the gates only by the hundred.
fn wall(k: usize, n_walls: usize) -> ([f64; 2], [f64; 2]) {
    let normal_rad = std::f64::consts::TAU * k as f64 / n_walls as f64;
    ([5.0 + (k % 7) as f64, normal_rad], [-1.5, 1.5])
}

fn seen(k: usize, n_walls: usize) -> SensedLine {
    let ([distance_m, normal_rad], [from, to]) = wall(k, n_walls);
    let (sin, cos) = normal_rad.sin_cos();
    let end = |t: f64| [distance_m * cos - t * sin, distance_m * sin + t * cos];
    SensedLine {
        distance_m,
        normal_rad,
        covariance: [1e-4, 1e-6, 1e-5],
        ends_m: [end(from), end(to)],
        n_points: 40,
        rms_m: 0.03,
    }
}

fn filter(n_walls: usize, map_use: MapUse) -> LineFilter {
    let covariance = Matrix5::from_diagonal(&Vector5::new(1e-4, 1e-4, 1e-5, 1e-3, 1e-3));
    let settings = FilterSettings::default();
    if map_use == MapUse::Known {
        let line = |k| {
            let [right, left] = seen(k, n_walls).ends_m;
            Line { from: left, to: right, covariance: [1e-4, 0.0, 1e-6] }
        };
        let map = WallMap::new(&(0..n_walls).map(line).collect::<Vec<_>>());
        return LineFilter::on_map(settings, Vector5::zeros(), &covariance, &map);
    }
    let mut filter = LineFilter::building(settings, Vector5::zeros(), &covariance);
    let all: Vec<SensedLine> = (0..n_walls).map(|k| seen(k, n_walls)).collect();
    filter.read_lines(&all, &Mount::default());
    assert_eq!(filter.walls().len(), n_walls);
    filter
}

/// A prediction, the wheels, and a scan of 20 lines.
fn step(filter: &mut LineFilter, scan: &[SensedLine]) -> usize {
    filter.predict(0.05);
    filter.read_wheels([0.0, 0.0]);
    filter.read_lines(scan, &Mount::default()).matches.len()
}

fn bench(bencher: divan::Bencher, n_walls: usize, map_use: MapUse) {
    let mut filter = filter(n_walls, map_use);
    let scan: Vec<SensedLine> = (0..20).map(|k| seen(k * (n_walls / 20), n_walls)).collect();
    assert_eq!(step(&mut filter, &scan), 20);
    bencher.bench_local(|| step(&mut filter, &scan));
}

#[divan::bench(args = [20, 50, 95, 200, 500])]
fn mapping_20_lines_of(bencher: divan::Bencher, n_walls: usize) {
    bench(bencher, n_walls, MapUse::Build);
}

#[divan::bench(args = [20, 50, 95, 200, 500, 1000])]
fn known_map_20_lines_of(bencher: divan::Bencher, n_walls: usize) {
    bench(bencher, n_walls, MapUse::Known);
}

#[divan::bench(args = [95, 500])]
fn prediction_and_wheels_with(bencher: divan::Bencher, n_walls: usize) {
    let mut filter = filter(n_walls, MapUse::Build);
    bencher.bench_local(|| {
        filter.predict(0.05);
        filter.read_wheels([0.0, 0.0])
    });
}
