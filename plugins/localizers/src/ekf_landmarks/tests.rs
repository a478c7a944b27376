//! The filter against finite differences, a grid, samples, and everything that cameras and odometers may say.

mod as_a_localizer;
mod consistency;
mod derivatives;
mod grid;
mod three_marks;

use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};
use rand::RngExt as _;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_core::rng::{self, Rng};

use super::belief::{Belief, GATE};
use super::known_marks::KnownMark;
use super::motion::{self, State};
use super::sighting::{Sighting, expect};

/// A mark whose place is known exactly.
fn mark(x: f64, y: f64) -> KnownMark {
    KnownMark { at: Point2::new(x, y), covariance: Matrix2::zeros() }
}

/// A number of the normal distribution.
fn normal(rng: &mut Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// What a camera with these deviations says of a mark from a pose.
fn seen(from: &Pose2, camera: &Pose2, mark: &KnownMark, deviations: [f64; 2], rng: &mut Rng) -> Sighting {
    let sigma = Vector2::from(deviations);
    let exact = expect(from, camera, &mark.at).unwrap().expected;
    let error = sigma.component_mul(&Vector2::from_fn(|_, _| normal(rng)));
    let measured = Vector2::new(exact.x + error.x, wrap_angle(exact.y + error.y));
    let noise = Matrix2::from_diagonal(&sigma.component_mul(&sigma));
    Sighting { measured, noise, base_from_sensor: *camera }
}
