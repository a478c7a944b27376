//! `occupancy_grid`: what the laser sees, from where the robot is, becomes a grid of log-odds.

mod params;
mod plugin;

pub use params::{FreeSpaceRule, OccupancyGridParams};
pub use plugin::OccupancyGrid;
