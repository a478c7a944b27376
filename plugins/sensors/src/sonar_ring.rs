//! `sonar_ring`: ultrasonic transducers around the hull.

mod crosstalk;
mod params;
mod plugin;

pub use params::SonarRingParams;
pub use plugin::SonarRing;
