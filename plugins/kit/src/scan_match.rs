//! Scan-to-map matching: the pose at which the points of a scan lie best on what a map says is there.
//!
//! Minimizes the sum of `[1 - M(S_i(pose))]²` over the points, where `M` is the map's value between 0 and 1, interpolated
//! between the middles of cells (Kohlbrecher, Meyer, von Stryk, Klingauf, *A Flexible and Scalable SLAM System with Full
//! 3D Motion Estimation*, SSRR 2011, in the corrected form of Arroyo Sánchez 2013, equations 4 to 14), by safeguarded
//! Gauss-Newton steps from the coarsest level of the map to the finest.
//!
//! What is matched against is a [`MatchLevel`]: a level of an occupancy grid is one ([`GridLevel`]), and so is whatever
//! else has numbers at the middles of cells.

mod covariance;
mod gate;
mod known;
mod level;
mod linearized;
mod lines;
mod logistic;
mod matcher;
mod observability;
mod points;
mod polish;
mod preparation;
mod shape;
mod step;
mod surface_fit;
mod surface_map;
mod surface_normals;

pub use covariance::{CovarianceRule, CovarianceSettings};
pub use gate::{MatchGate, MatchStatus};
pub use known::{drawn_along, drawn_near};
pub use level::{GridLevel, MatchLevel, levels_of, levels_within};
pub use linearized::{Linearized, linearize};
pub use logistic::logistic;
pub use matcher::{MatchSettings, ScanMatch, match_scan};
pub use observability::{BlindAxes, Observability, ObservabilitySettings};
pub use points::ScanPoints;
pub use polish::PolishSettings;
pub use preparation::{ScanPreparation, shape_of};
pub use shape::{ScanShape, ShapePoint};
pub use step::{PosePrior, step};
pub use surface_fit::{SurfaceFit, fit_surfaces};
pub use surface_map::SurfaceMap;

#[cfg(test)]
mod tests;
