//! How sure a match is.

use super::level::MatchLevel;
use super::linearized::{Linearized, linearize};
use super::observability::Observability;
use super::points::ScanPoints;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, wrap_angle};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the covariance of a match is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CovarianceRule {
    /// From the curvature at the solution and what is left of the residuals.
    #[default]
    Curvature,
    /// From the likelihood at seven poses around the solution: better at the border of a map.
    Sampled,
}

/// Rules and bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CovarianceSettings {
    /// Where it comes from.
    pub rule: CovarianceRule,
    /// Added in quadrature along x and y, meters.
    pub min_deviation_m: f64,
    /// Added in quadrature to yaw, radians.
    pub min_deviation_rad: f64,
    /// Standard deviation along directions that the scan does not see, meters.
    pub blind_deviation_m: f64,
}

impl Default for CovarianceSettings {
    fn default() -> Self {
        CovarianceSettings {
            rule: CovarianceRule::Curvature,
            min_deviation_m: 0.005,
            min_deviation_rad: 0.002,
            blind_deviation_m: 1.0,
        }
    }
}

/// The turn of two of the seven poses, radians.
const SAMPLED_TURN_RAD: f64 = 0.05;
/// The way of the other four, cells.
const SAMPLED_CELLS: f64 = 1.5;

impl CovarianceSettings {
    /// `σ² H^-1` with `σ² = F / (n - 3)`, by directions, with the floor.
    pub fn from_curvature(&self, linearized: &Linearized, seen: &Observability) -> Matrix3<f64> {
        let residual_variance = linearized.cost / (linearized.n_used as f64 - 3.0).max(1.0);
        let blind = self.blind_deviation_m * self.blind_deviation_m;
        let along = |k: usize| if seen.seen[k] { residual_variance / seen.evidence[k] } else { blind };
        self.with_floor(seen.compose(along))
    }

    /// Mean and covariance weighted by the mean value under the points at the pose and six around it.
    pub fn sampled<L: MatchLevel>(
        &self,
        level: &L,
        points: &ScanPoints,
        map_from_base: &Pose2,
    ) -> (Pose2, Matrix3<f64>) {
        let way_m = SAMPLED_CELLS * level.resolution_m();
        let mut offsets = [Vector3::zeros(); 7];
        for (axis, size) in [way_m, way_m, SAMPLED_TURN_RAD].into_iter().enumerate() {
            offsets[1 + 2 * axis][axis] = size;
            offsets[2 + 2 * axis][axis] = -size;
        }
        let likelihoods =
            offsets.map(|offset| linearize(level, points, &moved(map_from_base, &offset)).mean_value());
        let sum: f64 = likelihoods.iter().sum();
        if sum <= 0.0 {
            return (*map_from_base, self.with_floor(Matrix3::identity() * self.blind_deviation_m.powi(2)));
        }
        let mean =
            offsets.iter().zip(likelihoods).map(|(offset, w)| offset * (w / sum)).sum::<Vector3<f64>>();
        let spread =
            |(offset, w): (&Vector3<f64>, f64)| (offset - mean) * (offset - mean).transpose() * (w / sum);
        let covariance = offsets.iter().zip(likelihoods).map(spread).sum::<Matrix3<f64>>();
        (moved(map_from_base, &mean), self.with_floor(covariance))
    }

    pub(super) fn with_floor(&self, covariance: Matrix3<f64>) -> Matrix3<f64> {
        let (way, turn) = (self.min_deviation_m.powi(2), self.min_deviation_rad.powi(2));
        let symmetric = (covariance + covariance.transpose()) * 0.5;
        symmetric + Matrix3::from_diagonal(&Vector3::new(way, way, turn))
    }
}

/// A pose moved in the map's axes.
pub(super) fn moved(map_from_base: &Pose2, change: &Vector3<f64>) -> Pose2 {
    rumbo_core::frames::pose2(
        map_from_base.translation.x + change.x,
        map_from_base.translation.y + change.y,
        wrap_angle(map_from_base.rotation.angle() + change.z),
    )
}
