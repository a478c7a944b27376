//! `nav_filter`: where the base went in space, by an inertial measurement unit that scans hold over the floor.
//!
//! Kohlbrecher et al., *A Flexible and Scalable SLAM System with Full 3D Motion Estimation* (2011); Arroyo Sánchez (2013),
//! section 3.2. The filter is that of the kit; here readings become samples, and scans become steps ([`tracker`]), and
//! what does not move stands ([`standstill`]).

mod params;
mod plugin;
pub mod standstill;
pub mod tracker;
mod unseen;

#[cfg(test)]
mod tests;

pub use params::{Intersection, NavFilterParams};
pub use tracker::{Counts, Tracker, TrackerSettings};
