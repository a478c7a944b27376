//! `dp`: keeps away from obstacles, then goes to the goal, then turns little. Hernández Alamilla (2005), chapter 3.
//!
//! An obstacle-proximity map gives every cell a cost, a cost-to-goal field the cheapest path, and straight segments
//! replace what they can of it.

mod params;
mod plan_figures;
pub mod plugin;

pub mod grid_dp;

pub mod cost_map;
pub mod descent;

pub mod checkpoints;

mod explanation;
pub mod found;
pub mod obstruction;

pub use params::DpParams;

#[cfg(test)]
mod tests;
