//! `odometry`: dead reckoning. The robot is where the odometer says, seen from where it started.
//!
//! The mean needs no algorithm: the odometer's frame stays where the prior put it. What this localizer adds is how
//! unsure the pose becomes on the way.

mod params;
mod plugin;
pub mod propagation;

#[cfg(test)]
mod tests;

pub use params::OdometryParams;
pub use plugin::DeadReckoning;
