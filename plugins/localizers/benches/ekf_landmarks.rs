//! What one reading of the odometer and one mark cost.

use divan::{Bencher, black_box};
use nalgebra::{Matrix2, Matrix3, Point2, Vector2};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_localizers::ekf_landmarks::KnownMark;
use rumbo_localizers::ekf_landmarks::belief::Belief;
use rumbo_localizers::ekf_landmarks::fix::locate;
use rumbo_localizers::ekf_landmarks::sighting::Sighting;

fn main() {
    divan::main();
}

fn belief() -> Belief {
    Belief::at(&pose2(1.0, 2.0, 0.3), &(Matrix3::identity() * 0.01), [0.1; 2])
}

fn sighting(range_m: f64, bearing_rad: f64) -> Sighting {
    let noise = Matrix2::from_diagonal(&Vector2::new(0.01, 0.0001));
    Sighting { measured: Vector2::new(range_m, bearing_rad), noise, base_from_sensor: Pose2::identity() }
}

fn mark(x: f64, y: f64) -> KnownMark {
    KnownMark { at: Point2::new(x, y), covariance: Matrix2::zeros() }
}

#[divan::bench]
fn advance(bencher: Bencher<'_, '_>) {
    let (belief, step) = (belief(), pose2(0.01, 0.0, 0.002));
    bencher.with_inputs(|| belief.clone()).bench_values(|mut belief| {
        belief.advance(black_box(&step), [0.05, 0.05, 0.1]);
        belief
    });
}

#[divan::bench]
fn gate_and_correct(bencher: Bencher<'_, '_>) {
    let (belief, mark, sighting) = (belief(), mark(4.0, 3.0), sighting(3.15, 0.03));
    bencher.with_inputs(|| belief.clone()).bench_values(|mut belief| {
        black_box(belief.distance(black_box(&sighting), &mark));
        belief.correct(black_box(&sighting), &mark);
        belief
    });
}

#[divan::bench]
fn fix_from_four_marks(bencher: Bencher<'_, '_>) {
    let seen = [(3.0, 0.2), (4.2, -0.4), (2.0, 0.9), (5.0, 0.0)].map(|(range_m, bearing_rad)| {
        let (sin, cos) = f64::sin_cos(bearing_rad);
        (sighting(range_m, bearing_rad), mark(range_m * cos, range_m * sin))
    });
    bencher.bench(|| locate(black_box(&seen)));
}
