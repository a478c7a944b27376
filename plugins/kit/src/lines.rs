//! Straight pieces of a planar scan with their covariance: adaptive breaks, recursive iterative end-point fit, merging,
//! orthogonal least squares.
//!
//! Mora, Armesto, Tornero, *Sistema de navegación de robots móviles en entornos industriales*, section 2.3; the adaptive
//! break is that of Borges and Aldon (2004). The source names polar and Cartesian noise after Deriche, Vaillant and
//! Faugeras; [`fit`] has their complete first-order result.

mod breaks;
mod extractor;
mod fit;
mod points;
mod split;

#[cfg(test)]
mod tests;

pub use crate::landmarks::BeamFan;
pub use extractor::LineExtractor;
pub use fit::{LineFit, fit, fit_weighted};
pub use points::Points;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A line piece in the frame of the sensor that saw it: `{p : p . n = rho}` with `n = (cos phi, sin phi)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedLine {
    /// Distance of the line, meters, at least zero (rho).
    pub distance_m: f64,
    /// Direction of the normal, away from the sensor, radians (phi).
    pub normal_rad: f64,
    /// Covariance of distance and normal (rho², rho phi, phi²), the floor included.
    pub covariance: [f64; 3],
    /// Both ends, meters: seen from the sensor the first is to the right.
    pub ends_m: [[f64; 2]; 2],
    /// Readings that it was fitted to.
    pub n_points: usize,
    /// Root of the mean square of their distances from it, meters.
    pub rms_m: f64,
}

/// How unsure a reading is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointNoise {
    /// Standard deviation of a range, meters (sigma_r).
    pub range_m: f64,
    /// Standard deviation of a bearing, radians (sigma_alpha).
    pub bearing_rad: f64,
    /// Standard deviation along both axes, meters: rough walls (sigma_xy).
    pub surface_m: f64,
}

/// How much each reading counts in the fit of a line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FitWeights {
    /// All alike, as published.
    #[default]
    Equal,
    /// By the inverse of its variance across the line: what is near and met head on counts more.
    Noise,
}

/// When readings are a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSettings {
    /// Steepest incidence at which a wall is still one piece, radians (lambda).
    pub grazing_rad: f64,
    /// A reading farther than this from the chord splits a piece, meters; about 3.3 deviations of a range.
    pub split_m: f64,
    /// Pieces with fewer readings are dropped.
    pub min_points: usize,
    /// Shorter lines are dropped, meters.
    pub min_length_m: f64,
    /// Lines whose readings scatter more than this are dropped, meters.
    pub max_rms_m: f64,
    /// Neighbors become one line when all their readings scatter less than this about it, meters.
    pub merge_rms_m: f64,
    /// How much each reading counts.
    pub weights: FitWeights,
    /// How unsure a reading is.
    pub noise: PointNoise,
    /// Least standard deviation of a line's distance, meters: readings at corners are not modeled.
    pub floor_distance_m: f64,
    /// Least standard deviation of a line's normal, radians.
    pub floor_normal_rad: f64,
}

impl Default for LineSettings {
    /// For deviations of a range of 3 cm and beams half a degree apart.
    fn default() -> Self {
        LineSettings {
            grazing_rad: 10f64.to_radians(),
            split_m: 0.10,
            min_points: 10,
            min_length_m: 0.40,
            max_rms_m: 0.045,
            merge_rms_m: 0.027,
            weights: FitWeights::Equal,
            noise: PointNoise { range_m: 0.03, bearing_rad: 0.1f64.to_radians(), surface_m: 0.005 },
            floor_distance_m: 0.005,
            floor_normal_rad: 0.1f64.to_radians(),
        }
    }
}
