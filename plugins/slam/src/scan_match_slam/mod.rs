//! `scan_match_slam`: each scan is matched against the map of those before it, and then becomes part of it.
//!
//! The order within a scan is fixed: predict, match against the map of earlier scans, judge, insert. Matching is
//! `rumbo_kit::scan_match`, the map `rumbo_kit::occupancy`; a robot that is lost is found again by
//! `rumbo_kit::correlative`.

mod insertion;
mod locating;
mod motion;
mod params;
mod place_search;
mod plugin;
mod reckoning;
mod saved;
mod settings;
mod tracker;

pub use params::{Prediction, ScanMatchSlamParams};
pub use plugin::ScanMatchSlam;
