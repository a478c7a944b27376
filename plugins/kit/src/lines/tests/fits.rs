//! The fit and its covariance against vectors, the printed expressions, finite differences and chance.

use super::{DATA, close};
use crate::lines::{PointNoise, Points, fit};
use nalgebra::{Matrix2, Matrix2xX, SMatrix, SVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::wrap_angle;
use serde_json::Value;

struct Case {
    value: Value,
    polar: Vec<[f64; 2]>,
    noise: PointNoise,
}

impl Case {
    fn number(&self, key: &str) -> f64 {
        self.value[key].as_f64().unwrap()
    }

    fn pair(&self, key: &str) -> [f64; 2] {
        [0, 1].map(|k| self.value[key][k].as_f64().unwrap())
    }
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(format!("{DATA}ekf_line_fit.json")).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let fits = file["fits"].as_array().unwrap().iter();
    let cases: Vec<Case> = fits
        .map(|value| {
            let (ranges, bearings) = (numbers(&value["range"]), numbers(&value["bearing"]));
            let polar = bearings.into_iter().zip(ranges).map(|(b, r)| [b, r]).collect();
            let noise = |key: &str| value[key].as_f64().unwrap();
            let noise = PointNoise {
                range_m: noise("sigma_r"),
                bearing_rad: noise("sigma_alpha"),
                surface_m: noise("sigma_xy"),
            };
            Case { value: value.clone(), polar, noise }
        })
        .collect();
    assert_eq!(cases.len(), 3);
    cases
}

/// Distance and normal of the line through points.
fn line_of(points: &Points) -> [f64; 2] {
    let line = fit(points, 0..points.len()).unwrap();
    [line.distance_m, line.normal_rad]
}

#[test]
fn fits_are_those_of_the_vectors() {
    for case in cases() {
        let points = Points::of_polar(&case.polar);
        let all = 0..points.len();
        let line = fit(&points, all.clone()).unwrap();
        close(line.distance_m, case.number("rho"), 1e-7, "rho");
        close(line.normal_rad, case.number("phi"), 1e-7, "phi");
        close(line.rms_m, case.number("rms_residual"), 1e-7, "rms");
        let [first, last] = line.extent_m(&points, all.clone());
        close(first, case.number("t_min"), 1e-7, "t_min");
        close(last, case.number("t_max"), 1e-7, "t_max");
        for (along, key) in [(first, "p0"), (last, "p1")] {
            let (found, expected) = (line.at(along), case.pair(key));
            (0..2).for_each(|axis| close(found[axis], expected[axis], 1e-7, key));
        }
        let found = line.covariance(&points, all, &case.noise);
        let expected = [&case.value["cov"][0][0], &case.value["cov"][0][1], &case.value["cov"][1][1]];
        let size = expected.iter().map(|v| v.as_f64().unwrap().abs()).fold(0.0, f64::max);
        for (found, expected) in found.into_iter().zip(expected) {
            // The bearings of the vectors are rounded to a microradian; the printed expressions are kept to 1e-11.
            close(found, expected.as_f64().unwrap(), 1e-7 * size, "covariance");
        }
    }
}

/// The four derivatives of the fit as they are printed.
fn printed_covariance(polar: &[[f64; 2]], noise: &PointNoise) -> Matrix2<f64> {
    let places: Vec<[f64; 2]> = polar.iter().map(|[b, r]| [r * b.cos(), r * b.sin()]).collect();
    let n = places.len() as f64;
    let mean = [0, 1].map(|axis| places.iter().map(|p| p[axis]).sum::<f64>() / n);
    let sum = |i: usize, j: usize| places.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>();
    let (a, b) = (-2.0 * sum(0, 1), sum(1, 1) - sum(0, 0));
    let d = a * a + b * b;
    let [_, phi] = line_of(&Points::of_polar(polar));
    let along_mean = mean[1] * phi.cos() - mean[0] * phi.sin();
    let mut covariance = Matrix2::zeros();
    for ([bearing, range], [x, y]) in polar.iter().zip(&places) {
        let (dx, dy) = (x - mean[0], y - mean[1]);
        let (phi_x, phi_y) = ((dx * a - dy * b) / d, (-dx * b - dy * a) / d);
        let g = Matrix2::new(
            phi.cos() / n + along_mean * phi_x,
            phi.sin() / n + along_mean * phi_y,
            phi_x,
            phi_y,
        );
        let j = Matrix2::new(bearing.cos(), -range * bearing.sin(), bearing.sin(), range * bearing.cos());
        let polar_noise = Matrix2::new(noise.range_m.powi(2), 0.0, 0.0, noise.bearing_rad.powi(2));
        let c = j * polar_noise * j.transpose() + Matrix2::identity() * noise.surface_m.powi(2);
        covariance += g * c * g.transpose();
    }
    covariance
}

#[test]
fn the_covariance_is_that_of_the_printed_expressions() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for _ in 0..200 {
        let polar: Vec<[f64; 2]> =
            (0..12).map(|_| [rng.random_range(-3.1..3.1), rng.random_range(0.5..20.0)]).collect();
        let noise = PointNoise {
            range_m: rng.random_range(0.0..0.1),
            bearing_rad: rng.random_range(0.0..0.02),
            surface_m: rng.random_range(0.0..0.05),
        };
        let points = Points::of_polar(&polar);
        let found = fit(&points, 0..12).unwrap().covariance(&points, 0..12, &noise);
        let expected = printed_covariance(&polar, &noise);
        let size = expected.amax();
        for (found, expected) in found.iter().zip([expected[(0, 0)], expected[(0, 1)], expected[(1, 1)]]) {
            close(*found, expected, 1e-11 * size, "covariance");
        }
    }
}

#[test]
fn derivatives_are_finite_differences() {
    for case in cases() {
        let line = line_of(&Points::of_polar(&case.polar));
        let step = 1e-6;
        // One column a reading: how (rho, phi) answers to its range and to its bearing.
        let answer = |which: usize, k: usize| {
            let at = |sign: f64| {
                let mut polar = case.polar.clone();
                polar[k][which] += sign * step;
                line_of(&Points::of_polar(&polar))
            };
            let (up, down) = (at(1.0), at(-1.0));
            [(up[0] - down[0]) / (2.0 * step), wrap_angle(up[1] - down[1]) / (2.0 * step)]
        };
        let n = case.polar.len();
        let mut expected = Matrix2::zeros();
        for (which, sigma) in [(1, case.noise.range_m), (0, case.noise.bearing_rad)] {
            let g = Matrix2xX::from_fn(n, |row, k| answer(which, k)[row]);
            expected += &g * g.transpose() * sigma * sigma;
        }
        let no_surface = PointNoise { surface_m: 0.0, ..case.noise };
        let points = Points::of_polar(&case.polar);
        let found = fit(&points, 0..n).unwrap().covariance(&points, 0..n, &no_surface);
        let size = expected.amax();
        for (found, expected) in found.iter().zip([expected[(0, 0)], expected[(0, 1)], expected[(1, 1)]]) {
            close(*found, expected, 1e-6 * size, &format!("{line:?}"));
        }
    }
}

/// A normal number (Box and Muller 1958).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

#[test]
fn drawn_lines_scatter_as_the_covariance_says() {
    const DRAWS: usize = 20_000;
    // Normal, distance, from and to along the line, number of beams; noise.
    let walls = [
        (0.4, 4.0, -3.0, 2.5, 25, [0.03, 0.0, 0.0]),
        (-2.0, 8.0, -4.0, 2.0, 40, [0.02, 0.005, 0.01]),
        (2.9, 2.5, 1.0, 4.0, 20, [0.01, 0.002, 0.005]),
        (1.2, 12.0, 3.0, 9.0, 30, [0.0, 0.0, 0.03]),
    ];
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    for (phi, rho, from, to, n, [range_m, bearing_rad, surface_m]) in walls {
        let noise = PointNoise { range_m, bearing_rad, surface_m };
        let exact: Vec<[f64; 2]> = (0..n)
            .map(|k| {
                let t = from + (to - from) * f64::from(k) / f64::from(n - 1);
                [phi + f64::atan2(t, rho), f64::hypot(t, rho)]
            })
            .collect();
        let (mut sum, mut squares) = (SVector::<f64, 2>::zeros(), SMatrix::<f64, 2, 2>::zeros());
        for _ in 0..DRAWS {
            let drawn: Vec<[f64; 2]> = exact
                .iter()
                .map(|[bearing, range]| {
                    let (b, r) =
                        (bearing + bearing_rad * normal(&mut rng), range + range_m * normal(&mut rng));
                    let (x, y) = (
                        r * b.cos() + surface_m * normal(&mut rng),
                        r * b.sin() + surface_m * normal(&mut rng),
                    );
                    [y.atan2(x), x.hypot(y)]
                })
                .collect();
            let [distance, direction] = line_of(&Points::of_polar(&drawn));
            let off = SVector::from([distance - rho, wrap_angle(direction - phi)]);
            sum += off;
            squares += off * off.transpose();
        }
        let mean = sum / DRAWS as f64;
        let drawn = squares / DRAWS as f64 - mean * mean.transpose();
        let points = Points::of_polar(&exact);
        let [rho2, both, phi2] =
            fit(&points, 0..points.len()).unwrap().covariance(&points, 0..points.len(), &noise);
        close(rho2.sqrt() / drawn[(0, 0)].sqrt(), 1.0, 0.05, "deviation of rho");
        close(phi2.sqrt() / drawn[(1, 1)].sqrt(), 1.0, 0.05, "deviation of phi");
        let correlations =
            [both / (rho2 * phi2).sqrt(), drawn[(0, 1)] / (drawn[(0, 0)] * drawn[(1, 1)]).sqrt()];
        close(correlations[0], correlations[1], 0.05, "correlation");
    }
}

#[test]
fn points_without_a_direction_have_no_line() {
    assert!(fit(&Points::of_polar(&[[0.3, 2.0]; 5]), 0..5).is_none(), "all at one place");
    assert!(fit(&Points::of_polar(&[]), 0..0).is_none());
    let square = Points::of_polar(&[[0.0, 1.0], [1.5, f64::NAN], [3.0, 1.0]]);
    assert!(fit(&square, 0..3).is_none(), "not a number");
    assert!(fit(&square, 0..9).is_none(), "more than there are");
}
