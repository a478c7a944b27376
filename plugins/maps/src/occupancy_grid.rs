//! `occupancy_grid`: what the laser sees, from where the robot is, becomes a grid of log-odds.

mod gate;
mod params;
mod plugin;
mod pyramid;

pub use gate::UpdateGate;
pub use params::{FreeSpaceRule, OccupancyGridParams};
pub use plugin::OccupancyGrid;
pub use pyramid::{Grown, Pyramid};
