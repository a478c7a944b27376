//! Which directions of a pose a set of measurements observes.
//!
//! The information matrix is scaled, so that a turn counts as what it moves a typical point; its eigenvectors are the
//! directions, and those with too small an eigenvalue are not observed. Along them the pose is the prior's.

use super::equations::Equations;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// What counts as unobserved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DegeneracyRule {
    /// An eigenvalue below this share of the largest.
    pub ratio: f64,
    /// An eigenvalue below this for each point.
    pub floor: f64,
    /// More than this share of the eigenvalue is pretended by wrong directions of lines; one or more looks at nothing of
    /// the kind, as published.
    pub pretended_share: f64,
    /// Standard deviation along an unobserved direction where no prior is surer, meters.
    pub std_m: f64,
}

impl Default for DegeneracyRule {
    fn default() -> Self {
        DegeneracyRule { ratio: 1e-3, floor: 1e-6, pretended_share: 0.5, std_m: 1.0 }
    }
}

/// So many neighbors share about the same line, and its error.
const SHARED_BY: f64 = 10.0;

/// The directions of a pose, and which of them are observed.
#[derive(Debug, Clone, Copy)]
pub struct Split {
    scale: Matrix3<f64>,
    directions: Matrix3<f64>,
    values: Vector3<f64>,
    observed: [bool; 3],
    /// The part of each eigenvalue that wrong directions of lines pretend.
    pretended: [f64; 3],
    n: f64,
}

impl Split {
    /// Splits by a rule; none where the numbers are not finite.
    pub fn new(equations: &Equations, rule: &DegeneracyRule) -> Option<Split> {
        let n = equations.n.max(1) as f64;
        let reach_m = (equations.spread_m2 / n).sqrt();
        let per_m = if reach_m > 0.0 { 1.0 / reach_m } else { 1.0 };
        let scale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, per_m));
        let scaled = scale * equations.information * scale;
        if !scaled.iter().chain(equations.gradient.iter()).all(|v| v.is_finite()) {
            return None;
        }
        let SymmetricEigen { eigenvectors: directions, eigenvalues: values } = SymmetricEigen::new(scaled);
        let pretended = scale * equations.pretended * scale;
        let largest = values.max();
        let (mut observed, mut noises) = ([false; 3], [0.0; 3]);
        for (k, (is_observed, told)) in observed.iter_mut().zip(&mut noises).enumerate() {
            let (value, direction) = (values[k], directions.column(k));
            let noise = direction.dot(&(pretended * direction));
            *is_observed = value > 0.0
                && value >= rule.ratio * largest
                && value >= rule.floor * n
                && (rule.pretended_share >= 1.0 || noise <= rule.pretended_share * value);
            *told = if rule.pretended_share >= 1.0 { 0.0 } else { noise };
        }
        Some(Split { scale, directions, values, observed, pretended: noises, n })
    }

    /// Directions (x, y, yaw) with their scaled eigenvalues, and whether they are observed.
    fn parts(&self) -> impl Iterator<Item = (Vector3<f64>, f64, bool)> + '_ {
        let columns = self.directions.column_iter().map(|column| column.into_owned());
        columns.zip(self.values.iter().copied()).zip(self.observed).map(|((v, value), kept)| (v, value, kept))
    }

    /// Something is observed.
    pub fn observes_any(&self) -> bool {
        self.observed.contains(&true)
    }

    /// Everything is.
    pub fn observes_all(&self) -> bool {
        !self.observed.contains(&false)
    }

    /// Which of x, y, yaw the unobserved directions mostly are.
    pub fn unobserved_axes(&self) -> [bool; 3] {
        let mut axes = [false; 3];
        for (direction, _, _) in self.parts().filter(|(_, _, is_observed)| !is_observed) {
            if let Some(axis) = axes.get_mut((self.scale * direction).iamax()) {
                *axis = true;
            }
        }
        axes
    }

    /// The step against this gradient, along observed directions only.
    pub fn step(&self, gradient: &Vector3<f64>) -> Vector3<f64> {
        let scaled = self.scale * gradient;
        let observed = self.parts().filter(|(_, _, is_observed)| *is_observed);
        self.scale * observed.fold(Vector3::zeros(), |sum, (v, value, _)| sum - v * (v.dot(&scaled) / value))
    }

    /// The pose with the prior's numbers along unobserved directions.
    pub fn held(&self, pose: &Vector3<f64>, prior: &Vector3<f64>) -> Vector3<f64> {
        let away = self.unscale() * (pose - prior);
        let unobserved = self.parts().filter(|(_, _, is_observed)| !is_observed);
        pose - self.scale * unobserved.fold(Vector3::zeros(), |sum, (v, ..)| sum + v * v.dot(&away))
    }

    /// What residuals with this variance tell of x, y, yaw: nothing along unobserved directions, and without what noise
    /// pretends along the others. Where the unobserved direction lies is known by the noisy lines only: by what it may be
    /// tilted, the others are as unsure as the prior is along it.
    pub fn information(&self, variance_m2: f64, prior: &Matrix3<f64>) -> Matrix3<f64> {
        let scaled_prior = self.unscale() * prior * self.unscale();
        let along = |(v, pretended): (Vector3<f64>, f64)| pretended * v.dot(&(scaled_prior * v)).max(0.0);
        let unobserved = self.parts().zip(self.pretended).filter(|((_, _, is_observed), _)| !is_observed);
        let tilts = SHARED_BY * unobserved.map(|((v, ..), noise)| along((v, noise))).sum::<f64>() / self.n;
        let mut sum = Matrix3::zeros();
        for ((v, value, _), pretended) in
            self.parts().zip(self.pretended).filter(|((_, _, is_observed), _)| *is_observed)
        {
            let honest = value - pretended;
            sum += v * v.transpose() / (variance_m2 / honest + tilts / value);
        }
        let information = self.unscale() * sum * self.unscale();
        (information + information.transpose()) * 0.5
    }

    fn unscale(&self) -> Matrix3<f64> {
        self.scale.map(|v| if v == 0.0 { 0.0 } else { 1.0 / v })
    }

    /// Covariance of x, y, yaw for residuals with this variance: along unobserved directions the prior's, but at most that
    /// of the rule.
    pub fn covariance(&self, variance_m2: f64, prior: &Matrix3<f64>, rule: &DegeneracyRule) -> Matrix3<f64> {
        let scaled_prior = self.unscale() * prior * self.unscale();
        let most = rule.std_m * rule.std_m;
        let mut sum = Matrix3::zeros();
        for (v, value, is_observed) in self.parts() {
            let variance =
                if is_observed { variance_m2 / value } else { v.dot(&(scaled_prior * v)).clamp(0.0, most) };
            sum += v * variance * v.transpose();
        }
        let covariance = self.scale * sum * self.scale;
        (covariance + covariance.transpose()) * 0.5
    }
}
