//! `braitenberg`: flees from what is near, without a goal.
//!
//! Valverde Moreno (2015), section 4.1: a Braitenberg vehicle in three intervals of distance. Corrections and what goes
//! beyond the source are marked where they are.

mod params;
mod plugin;
pub mod vehicle;

#[cfg(test)]
mod tests;

pub use params::BraitenbergParams;
pub use plugin::Braitenberg;
