//! `scan_odometry`: where the base went, from laser scans alone. For the seat `[odometer]`, or as a localizer without a map.
//!
//! The registration is `rumbo_kit::scan_odometry`; here is what it begins from, and what its outcome means for the robot.

mod drift;
mod params;
mod plugin;
mod prediction;
mod tracker;

#[cfg(test)]
mod tests;

pub use drift::{Agility, Correction, Drift};
pub use params::{Prediction, ScanLines, ScanOdometryParams};
pub use prediction::{Guess, Motion};
pub use tracker::{Counts, Tracker, TrackerSettings};
