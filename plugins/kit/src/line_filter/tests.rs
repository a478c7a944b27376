mod clocks;
mod gates;
mod joint;
mod map;
mod odometer;
mod one_step;
mod saving;
mod tracking;
mod twin;

use crate::lines::SensedLine;
use nalgebra::{DMatrix, Matrix5, Vector5};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/line_slam/");

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} for {expected}");
}

/// Two matrices agree in every number.
fn alike(found: &DMatrix<f64>, expected: &DMatrix<f64>, tolerance: f64, what: &str) {
    assert_eq!(found.shape(), expected.shape(), "{what}");
    let off = (found - expected).amax();
    assert!(off <= tolerance, "{what}: off by {off:e}\n{found}{expected}");
}

/// A line of the sensor's frame, seen about as well as a laser does.
fn seen(distance_m: f64, normal_rad: f64, along_m: [f64; 2]) -> SensedLine {
    let (sin, cos) = normal_rad.sin_cos();
    SensedLine {
        distance_m,
        normal_rad,
        covariance: [1e-4, 0.0, 1e-5],
        ends_m: along_m.map(|t| [distance_m * cos - t * sin, distance_m * sin + t * cos]),
        n_points: 50,
        rms_m: 0.03,
    }
}

/// A robot that surely stands at the origin.
fn sure() -> (Vector5<f64>, Matrix5<f64>) {
    (Vector5::zeros(), Matrix5::from_diagonal(&Vector5::new(1e-6, 1e-6, 1e-6, 1e-4, 1e-4)))
}
