//! `bumper_ring`: touch sensors around the hull.

mod params;
mod plugin;

pub use params::BumperRingParams;
pub use plugin::BumperRing;
