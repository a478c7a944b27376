//! What its sensors say, drawn from a seed.

use super::{N_STEPS, SCAN_EVERY, Step, hall, truth};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_kit::lines::{BeamFan, LineExtractor, LineSettings};
use std::f64::consts::{PI, TAU};

const WHEEL_M_S: f64 = 0.02;
const RANGE_M: f64 = 0.03;
const HALF_TRACK_M: f64 = 0.45;
const BEHIND_M: f64 = 1.30;
const REACH_M: f64 = 40.0;

/// A normal number (Box and Muller 1958).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// Ranges of beams from a place, each cast a little beside where it says that it looks.
pub fn simulated_scan(
    pose: [f64; 3],
    fan: &BeamFan,
    n_beams: usize,
    rng: &mut Xoshiro256PlusPlus,
) -> Vec<f64> {
    let hall = hall();
    let [x, y, theta] = pose;
    let beam = |k: usize| {
        let bearing = fan.first_bearing_rad + fan.bearing_step_rad * k as f64;
        let heading = theta + bearing + 0.1f64.to_radians() * normal(rng);
        let range = hall.range_m([x, y], heading) + RANGE_M * normal(rng);
        if range <= REACH_M { range } else { f64::INFINITY }
    };
    (0..n_beams).map(beam).collect()
}

/// 60 s of the experiment.
pub fn simulated(seed: u64) -> Vec<Step> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let fan = BeamFan {
        first_bearing_rad: -PI,
        bearing_step_rad: 0.5f64.to_radians(),
        min_range_m: 0.0,
        max_range_m: REACH_M,
    };
    let mut extractor = LineExtractor::new(LineSettings::default());
    let step = |(k, [x, y, theta, v, omega]): (usize, [f64; 5])| {
        let wheels = [-1.0, 1.0].map(|side| v + side * HALF_TRACK_M * omega + WHEEL_M_S * normal(&mut rng));
        // Curvature, also where the forklift stands: the experiment's wheel is steered before it moves.
        let t = 0.05 * k as f64;
        let curvature = 0.22 + 0.03 * (TAU * t / 17.0).sin();
        let steering = (-BEHIND_M * curvature).atan() + 0.5f64.to_radians() * normal(&mut rng);
        let lines = k.is_multiple_of(SCAN_EVERY).then(|| {
            let ranges = simulated_scan([x, y, theta], &fan, 720, &mut rng);
            extractor.extract(&fan, ranges.into_iter()).to_vec()
        });
        Step { wheels: Some(wheels), steering: Some(steering), lines, truth: Some([x, y, theta]) }
    };
    truth(N_STEPS).into_iter().enumerate().map(step).collect()
}
