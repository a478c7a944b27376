//! `triangulation`: follows a robot by natural landmarks. S. Hernández Alamilla, master's thesis (2005), chapter 5.
//!
//! Landmarks of a scan are related to those that the map lets expect at the pose by odometry; the pose that explains them
//! best, weighed against the odometry, is the estimate. It is found together with what the odometer and the map are off by.
//! Thesis mode relates each scan to the one before, as the source does, and fuses estimates from pairs of landmarks. Read
//! [`tracker`] first, then [`on_map`].
//!
//! Where fewer than two landmarks are related it keeps to the odometry, whose errors it has learned, and counts a starved
//! scan; it never falls back to another way of tracking.

mod params;
mod plugin;

pub mod tracker;

pub mod scan;
pub mod sureness;

pub mod expected_scan;
pub mod explained;
pub mod on_map;

pub mod correspondence;
pub mod landmark_errors;
pub mod mapped_marks;
mod misfit;

pub mod dead_reckoning;
pub mod joint;
pub mod linearized;
pub mod sighting;

pub mod all_pairs;
pub mod between_scans;
pub mod covariance;
pub mod fusion;
pub mod pairs;
pub mod quality;

#[cfg(test)]
mod tests;

pub use params::{Estimator, TriangulationParams};
