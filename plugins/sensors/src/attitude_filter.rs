//! `attitude_filter`: a virtual sensor that finds roll and pitch for a device that measures rates and accelerations only.

mod params;
mod plugin;

pub use params::AttitudeFilterParams;
pub use plugin::AttitudeFilter;
