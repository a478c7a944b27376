//! `static_map`: a map from a file, which nothing the robot sees ever changes.

mod load;
mod params;
mod plugin;
mod wall_lines;

pub use load::{grid_of, load_static};
pub use params::StaticMapParams;
pub use plugin::StaticMap;
pub use wall_lines::wall_lines;
