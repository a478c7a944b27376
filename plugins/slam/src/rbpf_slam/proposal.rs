//! Where a particle's pose is drawn from: what scan and odometer say together.

use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_core::rng::Rng;
use rumbo_kit::turn_way_turn::noisy;

/// A Gaussian of x, y, yaw, and how probable the scan is under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal {
    /// x (m), y (m), yaw (rad).
    pub mean: Vector3<f64>,
    /// Of the same.
    pub covariance: Matrix3<f64>,
    /// Logarithm of what the particle's weight is multiplied by (η).
    pub ln_weight: f64,
}

/// Standard deviations that a Gaussian of tried poses does not go below, meters and radians: they are as coarse as that.
pub const SAMPLED_FLOOR: [f64; 2] = [0.002, 0.001];
/// The same of one that comes from curvatures: only so that it has a square root.
pub const LEAST_FLOOR: [f64; 2] = [1e-4, 1e-5];

/// x, y, yaw of `to` less those of `from`.
pub fn difference(from: &Pose2, to: &Pose2) -> Vector3<f64> {
    let turn = wrap_angle(to.rotation.angle() - from.rotation.angle());
    Vector3::new(to.translation.x - from.translation.x, to.translation.y - from.translation.y, turn)
}

/// x, y, yaw of a pose.
pub fn coordinates(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

impl Proposal {
    /// Fits a Gaussian to poses that were tried around the match (Grisetti et al. 2007, equations 15 to 19): weights are
    /// the products of the scan's likelihood and the odometer's. Yaw is averaged as differences to the match. None where
    /// nothing has any weight.
    pub fn of_samples(
        mode: &Vector3<f64>,
        samples: &[Vector3<f64>],
        ln_likelihood: &[f64],
        ln_motion: &[f64],
    ) -> Option<Proposal> {
        let ln_tau: Vec<f64> = ln_likelihood.iter().zip(ln_motion).map(|(z, u)| z + u).collect();
        let most = ln_tau.iter().copied().filter(|v| !v.is_nan()).fold(f64::NEG_INFINITY, f64::max);
        if !most.is_finite() {
            return None;
        }
        let tau = |ln: &f64| if ln.is_nan() { 0.0 } else { (ln - most).exp() };
        let off = |sample: &Vector3<f64>| {
            let off = sample - mode;
            Vector3::new(off.x, off.y, wrap_angle(off.z))
        };
        let eta: f64 = ln_tau.iter().map(tau).sum();
        let pairs = || samples.iter().map(off).zip(ln_tau.iter().map(tau));
        let mean = pairs().map(|(off, tau)| off * (tau / eta)).sum::<Vector3<f64>>();
        let spread = |(off, tau): (Vector3<f64>, f64)| (off - mean) * (off - mean).transpose() * (tau / eta);
        let covariance = pairs().map(spread).sum::<Matrix3<f64>>();
        Some(Proposal { mean: mode + mean, covariance, ln_weight: most + eta.ln() })
    }

    /// The Gaussian that agrees with the logarithms of both likelihoods at the match to second order (Laplace's
    /// approximation): `evidence` is the second derivative of the scan's, `information` of the odometer's, `away` the way
    /// from the odometer's pose to the match. None where it has no width.
    pub fn of_curvature(
        mode: &Vector3<f64>,
        ln_likelihood: f64,
        evidence: &Matrix3<f64>,
        information: &Matrix3<f64>,
        away: &Vector3<f64>,
    ) -> Option<Proposal> {
        let both = (evidence + information).cholesky()?;
        let prior = information.cholesky()?;
        // Determinants of products of triangles: the narrower the peak, the less of the odometer's guess it holds.
        let ln_det = |factor: &Matrix3<f64>| 2.0 * factor.diagonal().iter().map(|v| v.ln()).sum::<f64>();
        let ln_volume = 0.5 * (ln_det(&prior.l()) - ln_det(&both.l()));
        let ln_weight = ln_likelihood - 0.5 * away.dot(&(information * away)) + ln_volume;
        Some(Proposal { mean: *mode, covariance: both.inverse(), ln_weight })
    }

    /// Draws a pose. The covariance is made symmetric and by this much wider, standard deviations in meters and radians.
    pub fn draw(&self, floor: [f64; 2], rng: &mut Rng) -> Pose2 {
        let [way, turn] = floor.map(|v| v * v);
        let floor = Matrix3::from_diagonal(&Vector3::new(way, way, turn));
        let covariance = (self.covariance + self.covariance.transpose()) * 0.5 + floor;
        let root = covariance.cholesky().map_or(floor.map(f64::sqrt), |factor| factor.l());
        let drawn = self.mean + root * Vector3::from(noisy([0.0; 3], [1.0; 3], rng));
        pose2(drawn.x, drawn.y, drawn.z)
    }
}
