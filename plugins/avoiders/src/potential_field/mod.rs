//! `potential_field`: the path draws the robot, what is near pushes it off.
//!
//! Valverde Moreno (2015), sections 2.3.2 and 4.2.3 to 4.3. Corrections and what goes beyond the source are marked where they
//! are.

pub mod aim;
pub mod classical;
pub mod descent;
pub mod detour;
pub mod field;
pub mod near_rule;
mod params;
mod plugin;
pub mod push;
pub mod turn;

#[cfg(test)]
mod tests;

pub use params::{FieldForm, PotentialFieldParams};
pub use plugin::PotentialField;
