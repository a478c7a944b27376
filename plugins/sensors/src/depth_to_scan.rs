//! `depth_to_scan`: a virtual sensor that turns depth pictures into planar scans.

mod params;
mod plugin;

pub use params::DepthToScanParams;
pub use plugin::DepthToScan;
