//! Covariance intersection of a planar pose whose errors may have to do with those of the state (section 10.4).

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use rumbo_core::frames::Pose2;

use super::settings::Omega;
use super::update::{Updated, joseph};

/// A planar pose with the covariance of x, y and yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarPose {
    /// The pose.
    pub pose: Pose2,
    /// Its covariance, m² and rad².
    pub covariance: Matrix3<f64>,
}

/// Weights that are tried for the best one: at 1 nothing would be left of the state.
const OMEGAS: [f64; 2] = [0.001, 0.999];

/// The published form: `P⁺ = ((1 - ω) P⁻¹ + ω Cᵀ R⁻¹ C)⁻¹`. That is a Kalman update of `P / (1 - ω)` with `R / ω`. None
/// where a covariance is not positive definite or `omega` is not in [0, 1).
pub fn intersect<const N: usize>(
    covariance: &SMatrix<f64, N, N>,
    c: &SMatrix<f64, 3, N>,
    r: &Matrix3<f64>,
    innovation: &Vector3<f64>,
    omega: f64,
) -> Option<Updated<N>> {
    if !(0.0..1.0).contains(&omega) {
        return None;
    }
    if omega == 0.0 {
        return Some(Updated { change: SVector::zeros(), covariance: *covariance, mahalanobis2: 0.0 });
    }
    joseph(&(covariance / (1.0 - omega)), c, &(r / omega), innovation)
}

/// The same for the pose alone: other states keep what they are beside the pose, and follow it by what they have in common
/// with it.
pub fn intersect_pose<const N: usize>(
    covariance: &SMatrix<f64, N, N>,
    c: &SMatrix<f64, 3, N>,
    r: &Matrix3<f64>,
    innovation: &Vector3<f64>,
    omega: f64,
) -> Option<Updated<N>> {
    let by_state = covariance * c.transpose();
    let before = c * by_state;
    let pose = intersect(&before, &Matrix3::identity(), r, innovation, omega)?;
    let cholesky = ((before + before.transpose()) * 0.5).cholesky()?;
    let gain = cholesky.solve(&by_state.transpose()).transpose();
    let updated = covariance + gain * (pose.covariance - before) * gain.transpose();
    let change = gain * pose.change;
    let is_finite = change.iter().chain(updated.iter()).all(|v| v.is_finite());
    let covariance = (updated + updated.transpose()) * 0.5;
    is_finite.then_some(Updated { change, covariance, mahalanobis2: pose.mahalanobis2 })
}

/// The weight that makes the trace of the pose's covariance afterwards least; `before` and `r` are the covariances of the
/// pose by the state and by the measurement. None where one of them is not positive definite.
pub fn best_omega(before: &Matrix3<f64>, r: &Matrix3<f64>) -> Option<f64> {
    let information = |m: &Matrix3<f64>| ((m + m.transpose()) * 0.5).cholesky().map(|c| c.inverse());
    let (by_state, by_measurement) = (information(before)?, information(r)?);
    let trace = |omega: f64| {
        let both = by_state * (1.0 - omega) + by_measurement * omega;
        both.cholesky().map_or(f64::INFINITY, |cholesky| cholesky.inverse().trace())
    };
    // The trace is convex in the weight: golden sections find its least.
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let [mut low, mut high] = OMEGAS;
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (trace(a), trace(b));
    while high - low > 1e-7 {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - golden * (high - low);
            at_a = trace(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + golden * (high - low);
            at_b = trace(b);
        }
    }
    Some((low + high) / 2.0)
}

impl Omega {
    /// The weight for these covariances of the pose.
    pub fn weight(self, before: &Matrix3<f64>, r: &Matrix3<f64>) -> Option<f64> {
        match self {
            Omega::Fixed(omega) => Some(omega),
            Omega::Best => best_omega(before, r),
        }
    }
}
