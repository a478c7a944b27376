//! `pure_pursuit`: steers along an arc to a point of the path some way ahead (Coulter 1992), slows in curves and near
//! obstacles (Macenski, Singh, Martin and Gines 2023), and keeps the turning radius of a robot that cannot turn in place.

pub mod caution;
pub mod maneuver;
mod params;
mod plugin;
pub mod pursuit;
pub mod route;
pub mod way_ahead;

#[cfg(test)]
mod tests;

pub use params::PurePursuitParams;
pub use plugin::PurePursuit;
