//! `gps_imu`: where a robot is by satellite fixes, the yaw of an inertial measurement unit, and wheels.
//!
//! Three ways, of which the second is the default: the mean of the last three fixes, as Valverde Moreno (2015), section
//! 4.2.2, has it ([`mean3`]); dead reckoning that fixes pull back, with one variance ([`pulled`]); and an extended Kalman
//! filter of position, yaw and the error of the measured yaw ([`ekf`]), which the source recommends (chapters 6 and 7.2).

pub mod alignment;
pub mod ekf;
mod heading;
pub mod mean3;
pub mod motion;
mod params;
mod plugin;
pub mod pulled;
pub mod seen_fix;
mod tracker;

#[cfg(test)]
mod tests;

pub use params::{Fusion, GpsImuParams, HeadingSource};
pub use tracker::{Counts, Tracker, TrackerSettings};
