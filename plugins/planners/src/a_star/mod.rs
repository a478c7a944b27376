//! `a_star`: the shortest path over eight neighbors that keeps a clearance and cuts no corners.

mod params;
pub mod plugin;

pub mod grid_a_star;

pub use params::AStarParams;

#[cfg(test)]
mod tests;
