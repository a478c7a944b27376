//! Lines of scans of 361 and 720 beams with their covariances, in the hall of the forklift experiment. Bar: 10 microseconds
//! a scan of 361 beams.
#[path = "../tests/forklift/mod.rs"]
mod forklift;

use forklift::{simulated_scan, truth};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_kit::lines::{BeamFan, LineExtractor, LineSettings};

fn main() {
    divan::main();
}

/// Scans from all over the drive, ahead or all around.
fn scans(n_beams: usize) -> (BeamFan, Vec<Vec<f64>>) {
    let first_bearing_rad = if n_beams == 720 { -std::f64::consts::PI } else { -std::f64::consts::FRAC_PI_2 };
    let bearing_step_rad = 0.5f64.to_radians();
    let fan = BeamFan { first_bearing_rad, bearing_step_rad, min_range_m: 0.0, max_range_m: 40.0 };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let poses = truth(1201).into_iter().step_by(24);
    let scans = poses.map(|[x, y, theta, ..]| simulated_scan([x, y, theta], &fan, n_beams, &mut rng));
    (fan, scans.collect())
}

#[divan::bench(args = [361, 720])]
fn lines_of_scan(bencher: divan::Bencher, n_beams: usize) {
    let (fan, scans) = scans(n_beams);
    let mut extractor = LineExtractor::new(LineSettings::default());
    bencher.counter(divan::counter::ItemsCount::new(scans.len())).bench_local(|| {
        scans.iter().map(|scan| extractor.extract(&fan, scan.iter().copied()).len()).sum::<usize>()
    });
}
