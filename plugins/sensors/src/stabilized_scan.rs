//! `stabilized_scan`: a virtual sensor that levels the scans of a laser on a robot that tilts.

mod attitude_track;
mod beams;
mod params;
mod plugin;
mod thinning;

pub use params::StabilizedScanParams;
pub use plugin::StabilizedScan;
