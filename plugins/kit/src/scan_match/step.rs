//! One Gauss-Newton step, damped, with or without a prior, and never along what the scan does not see.

use super::linearized::Linearized;
use super::observability::Observability;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, wrap_angle};

/// What is known of the pose before the scan is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosePrior {
    /// The most likely pose.
    pub map_from_base: Pose2,
    /// Inverse covariance of x, y, yaw in the map's axes.
    pub information: Matrix3<f64>,
    /// Variance of one point's `1 - M` (sigma_r²): how much all of the points count against the prior.
    pub residual_variance: f64,
}

impl PosePrior {
    /// The way from a pose to this one: x, y, yaw in the map's axes.
    pub fn difference_from(&self, map_from_base: &Pose2) -> Vector3<f64> {
        difference(map_from_base, &self.map_from_base)
    }
}

/// x, y and yaw of `to` less those of `from`, with the shorter turn.
pub(super) fn difference(from: &Pose2, to: &Pose2) -> Vector3<f64> {
    let turn = wrap_angle(to.rotation.angle() - from.rotation.angle());
    Vector3::new(to.translation.x - from.translation.x, to.translation.y - from.translation.y, turn)
}

/// The change of x, y and yaw that lowers the sum of squares (equation 12). `toward_prior` is the way from here to
/// the prior. None where even the damped system cannot be solved.
pub fn step(
    linearized: &Linearized,
    damping: f64,
    blind: Option<&Observability>,
    prior: Option<(&PosePrior, Vector3<f64>)>,
) -> Option<Vector3<f64>> {
    let (hessian, descent) = match (blind, &prior) {
        (Some(blind), None) => {
            let seen =
                |k: usize| if blind.seen[k] { 1.0 / (blind.evidence[k] * (1.0 + damping)) } else { 0.0 };
            return Some(blind.compose(seen) * linearized.descent);
        }
        (Some(blind), Some(_)) => blind.seen_evidence(linearized),
        (None, _) => (linearized.hessian, linearized.descent),
    };
    let damped = hessian + Matrix3::from_diagonal(&hessian.diagonal()) * damping;
    let (system, right) = match prior {
        Some((prior, toward_prior)) => (
            damped / prior.residual_variance + prior.information,
            descent / prior.residual_variance + prior.information * toward_prior,
        ),
        None => (damped, descent),
    };
    system.cholesky().map(|factor| factor.solve(&right))
}
