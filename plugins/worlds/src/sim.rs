//! The simulated world: walls and objects with heights, glass, ramps and steps, people, slip.
//!
//! [`SimParams`] is the world as a pipeline names it; `simulation` carries it through time; `place`, `lattice` and
//! `cast` are the surroundings and the rays in them; `base_drive`, `slip` and `body` are the robot; `terrain` and `stance` are raised floor and how the
//! body stands on it.

mod base_drive;
mod beams;
mod body;
mod cast;
mod clearance;
mod hardships;
mod lattice;
mod params;
mod person;
mod place;
mod plugin;
mod simulation;
mod slip;
mod solid;
mod sound;
mod stance;
mod terrain;
mod walker;

pub use hardships::{Kidnap, Spin, Sway, Wheels};
pub(crate) use params::slip_schema;
pub use params::{SimParams, Start};
pub use plugin::SimWorld;
pub use slip::{GaussianSlip, Slip, SlipDraw};
