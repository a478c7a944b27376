//! Landmarks of scans of 361 beams on the generated 1000 x 1000 map. Bar: 20 microseconds a scan with least squares.
use rumbo_kit::generated_world::GeneratedWorld;
use rumbo_kit::landmarks::{BeamFan, Extractor, LandmarkSettings, WallFit};
use rumbo_kit::ray::{Ray, RayGrid};

fn main() {
    divan::main();
}

const CELL_M: f64 = 0.05;
const N_BEAMS: usize = 361;

fn fan() -> BeamFan {
    BeamFan {
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: 0.5_f64.to_radians(),
        min_range_m: 0.05,
        max_range_m: 8.0,
    }
}

/// Scans from places in free space, spread over the map by a fixed stride, with a ripple in place of noise.
fn scans() -> Vec<Vec<f64>> {
    let world = GeneratedWorld::indoor(1000, 4242);
    let grid = RayGrid::new(world.size, &world.occupied);
    let free = (0..world.size.n_cells()).step_by(49_973).filter(|&i| world.occupied[i] == 0);
    let scan = |(col, row): (usize, usize)| {
        let range = |k: usize| {
            let bearing = fan().first_bearing_rad + fan().bearing_step_rad * k as f64;
            let ray = Ray::at_angle(col as f64 + 0.37, row as f64 + 0.61, bearing + 0.2);
            grid.cast(&ray, 8.0 / CELL_M) * CELL_M + 0.01 * (k as f64 * 12.9898).sin()
        };
        (0..N_BEAMS).map(range).collect()
    };
    free.map(|i| world.size.col_row(i)).map(scan).collect()
}

#[divan::bench(args = ["tls", "hough"])]
fn scan_of_361(bencher: divan::Bencher, fit: &str) {
    let wall_fit = if fit == "tls" { WallFit::Tls } else { WallFit::Hough };
    let mut extractor = Extractor::new(LandmarkSettings { wall_fit, ..LandmarkSettings::default() });
    let scans = scans();
    bencher.counter(divan::counter::ItemsCount::new(scans.len())).bench_local(|| {
        scans.iter().map(|scan| extractor.extract(&fan(), scan.iter().copied()).len()).sum::<usize>()
    });
}
