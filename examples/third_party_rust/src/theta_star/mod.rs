//! Any-angle planning on a grid: Nash, Daniel, Koenig and Felner, *Theta\*: Any-Angle Path Planning on Grids* (AAAI 2007).

mod floor;
mod params;
mod plugin;
mod search;

pub use params::ThetaStarParams;
