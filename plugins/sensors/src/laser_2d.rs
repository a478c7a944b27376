//! `laser_2d`: a planar range finder of any field of view, step, range and noise.

mod noise;
mod params;
mod plugin;
mod scan_faults;
pub(crate) mod scanner;

pub use noise::{GaussianNoise, ScanNoise};
pub use params::Laser2dParams;
pub use plugin::Laser2d;
pub use scan_faults::ScanFaultParams;
