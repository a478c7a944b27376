//! The simulated world: walls and objects with heights, glass, people, slip.

mod base_drive;
mod beams;
mod body;
mod cast;
mod clearance;
mod lattice;
mod person;
mod place;
mod slip;
mod solid;
mod sound;
