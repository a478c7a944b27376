//! `triangulation`: follows a robot by natural landmarks. S. Hernández Alamilla, master's thesis (2005), chapter 5.
//!
//! Landmarks of a scan are related to those that the map lets expect at the pose by odometry; the pose that explains them
//! best, weighed against the odometry, is the estimate. Thesis mode relates each scan to the one before, as the source
//! does, and fuses estimates from pairs of landmarks. Read [`tracker`] first.

mod params;
mod plugin;

pub mod tracker;

pub mod all_pairs;
pub mod between_scans;
pub mod correspondence;
pub mod covariance;
pub mod dead_reckoning;
pub mod expected_scan;
pub mod explained;
pub mod fusion;
pub mod joint;
pub mod landmark_errors;
pub mod mapped_marks;
pub mod on_map;
pub mod pairs;
pub mod quality;
pub mod scan;
pub mod sighting;
pub mod sureness;

#[cfg(test)]
mod tests;

pub use params::{Estimator, LandmarkNoiseParams, TriangulationParams};
