//! `potential_field`: down the artificial potential to the goal, or to the local minimum where it ends.

mod params;
pub mod plugin;

pub use params::PotentialFieldParams;
