//! Weighted fits against repeated points, finite differences, chance, and the plain fit of the same points.

use super::{circle, close};
use crate::lines::{FitWeights, LineExtractor, LineSettings, PointNoise, Points, fit, fit_weighted};
use nalgebra::{Matrix2, Matrix2xX, Vector2};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::wrap_angle;

const NOISE: PointNoise = PointNoise { range_m: 0.03, bearing_rad: 0.02, surface_m: 0.002 };

/// A wall along which readings run far away: beams 1 degree apart, distance 1 m.
fn long_wall() -> Vec<[f64; 2]> {
    (-80..=60).map(|deg| f64::from(deg).to_radians()).map(|off| [0.7 + off, 1.0 / off.cos()]).collect()
}

fn drawn(rng: &mut Xoshiro256PlusPlus, exact: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut normal = |sigma: f64| -> f64 {
        let unit: f64 = StandardNormal.sample(rng);
        sigma * unit
    };
    exact
        .iter()
        .map(|[bearing, range]| {
            let (b, r) = (bearing + normal(NOISE.bearing_rad), range + normal(NOISE.range_m));
            let (x, y) = (r * b.cos() + normal(NOISE.surface_m), r * b.sin() + normal(NOISE.surface_m));
            [y.atan2(x), x.hypot(y)]
        })
        .collect()
}

#[test]
fn a_point_that_counts_three_times_is_three_points() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for _ in 0..100 {
        let polar: Vec<[f64; 2]> =
            (0..9).map(|_| [rng.random_range(-1.0..1.0), rng.random_range(1.0..9.0)]).collect();
        let times: Vec<usize> = (0..9).map(|_| rng.random_range(0..4)).collect();
        let repeated: Vec<[f64; 2]> =
            polar.iter().zip(&times).flat_map(|(p, n)| std::iter::repeat_n(*p, *n)).collect();
        let weights: Vec<f64> = times.iter().map(|n| *n as f64).collect();
        let expected = fit(&Points::of_polar(&repeated), 0..repeated.len()).unwrap();
        let found = fit_weighted(&Points::of_polar(&polar), 0..9, &weights).unwrap();
        close(found.distance_m, expected.distance_m, 1e-10, "distance");
        close(wrap_angle(found.normal_rad - expected.normal_rad), 0.0, 1e-10, "normal");
        close(found.rms_m, expected.rms_m, 1e-10, "rms");
    }
}

#[test]
fn weights_of_one_are_none() {
    let points = Points::of_polar(&long_wall());
    let (all, ones) = (0..points.len(), vec![1.0; points.len()]);
    let (plain, weighted) =
        (fit(&points, all.clone()).unwrap(), fit_weighted(&points, all.clone(), &ones).unwrap());
    assert_eq!(plain, weighted);
    assert_eq!(
        plain.covariance(&points, all.clone(), &NOISE),
        weighted.weighted_covariance(&points, all, &ones, &NOISE)
    );
}

#[test]
fn the_covariance_of_a_weighted_fit_is_that_of_finite_differences() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
    let noise = PointNoise { surface_m: 0.0, ..NOISE };
    for _ in 0..20 {
        let polar = drawn(&mut rng, &long_wall()[..40]);
        let weights: Vec<f64> = polar.iter().map(|_| rng.random_range(0.0..5.0)).collect();
        let line = |polar: &[[f64; 2]]| fit_weighted(&Points::of_polar(polar), 0..40, &weights).unwrap();
        let step = 1e-6;
        let answer = |which: usize, k: usize| {
            let at = |sign: f64| {
                let mut moved = polar.clone();
                moved[k][which] += sign * step;
                line(&moved)
            };
            let (up, down) = (at(1.0), at(-1.0));
            let turn = wrap_angle(up.normal_rad - down.normal_rad);
            [(up.distance_m - down.distance_m) / (2.0 * step), turn / (2.0 * step)]
        };
        let mut expected = Matrix2::zeros();
        for (which, sigma) in [(1, noise.range_m), (0, noise.bearing_rad)] {
            let g = Matrix2xX::from_fn(40, |row, k| answer(which, k)[row]);
            expected += &g * g.transpose() * sigma * sigma;
        }
        let found = line(&polar).weighted_covariance(&Points::of_polar(&polar), 0..40, &weights, &noise);
        for (found, expected) in found.iter().zip([expected[(0, 0)], expected[(0, 1)], expected[(1, 1)]]) {
            close(*found, expected, 1e-6 * found.abs().max(1e-9), "covariance");
        }
    }
}

/// What 4,000 drawn walls say: the weighted fit is the surer one, by as much as both covariances say.
#[test]
fn weights_by_noise_make_lines_surer_and_their_covariance_says_so() {
    const DRAWS: usize = 4_000;
    let exact = long_wall();
    let n = exact.len();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut squares = [Matrix2::<f64>::zeros(); 2];
    let mut weights = Vec::new();
    for _ in 0..DRAWS {
        let points = Points::of_polar(&drawn(&mut rng, &exact));
        let plain = fit(&points, 0..n).unwrap();
        assert!(plain.weights(&points, 0..n, &NOISE, &mut weights));
        let weighted = fit_weighted(&points, 0..n, &weights).unwrap();
        for (sum, line) in squares.iter_mut().zip([plain, weighted]) {
            let off = Vector2::new(line.distance_m - 1.0, wrap_angle(line.normal_rad - 0.7));
            *sum += off * off.transpose() / DRAWS as f64;
        }
    }
    let points = Points::of_polar(&exact);
    let plain = fit(&points, 0..n).unwrap();
    assert!(plain.weights(&points, 0..n, &NOISE, &mut weights));
    let weighted = fit_weighted(&points, 0..n, &weights).unwrap();
    let said = [
        plain.covariance(&points, 0..n, &NOISE),
        weighted.weighted_covariance(&points, 0..n, &weights, &NOISE),
    ];
    for (squares, [rho2, _, phi2]) in squares.iter().zip(said) {
        close(rho2.sqrt() / squares[(0, 0)].sqrt(), 1.0, 0.1, "deviation of rho");
        close(phi2.sqrt() / squares[(1, 1)].sqrt(), 1.0, 0.1, "deviation of phi");
    }
    let [plain, weighted] = squares;
    // The distance is that of the near points in any case; the far ones spoil the direction.
    assert!(weighted[(0, 0)] < plain[(0, 0)], "{weighted} for {plain}");
    assert!(weighted[(1, 1)] < 0.6 * plain[(1, 1)], "{weighted} for {plain}");
}

#[test]
fn an_extractor_weighs_by_noise_when_it_is_told_to() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    // A wall ahead, 2 m away, seen up to 70 degrees to each side by beams half a degree apart.
    let bearings = (0..720).map(|k| (f64::from(k) * 0.5 - 180.0).to_radians());
    let ranges: Vec<f64> = bearings
        .map(|b| if b.abs() < 1.22 { 2.0 / b.cos() + 0.01 * normal() } else { f64::INFINITY })
        .collect();
    let lines = [FitWeights::Equal, FitWeights::Noise].map(|weights| {
        let mut extractor = LineExtractor::new(LineSettings { weights, ..LineSettings::default() });
        let lines = extractor.extract(&circle(), ranges.iter().copied());
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines[0]
    });
    assert_ne!(lines[0].distance_m, lines[1].distance_m);
    assert!(lines[1].covariance[0] < lines[0].covariance[0], "{lines:?}");
    assert!(lines[1].covariance[2] < lines[0].covariance[2], "{lines:?}");
}

#[test]
fn points_without_noise_have_no_weights_and_missing_weights_no_line() {
    let points = Points::of_polar(&long_wall());
    let n = points.len();
    let silent = PointNoise { range_m: 0.0, bearing_rad: 0.0, surface_m: 0.0 };
    let mut weights = vec![3.0];
    assert!(!fit(&points, 0..n).unwrap().weights(&points, 0..n, &silent, &mut weights));
    assert!(weights.is_empty());
    assert!(fit_weighted(&points, 0..n, &vec![1.0; n - 1]).is_none());
    assert!(fit_weighted(&points, 0..n, &vec![0.0; n]).is_none(), "nothing counts");
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        let mut weights = vec![1.0; n];
        weights[3] = wrong;
        assert!(fit_weighted(&points, 0..n, &weights).is_none(), "{wrong}");
    }
}
