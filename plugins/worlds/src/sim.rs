//! The simulated world: walls and objects with heights, glass, people, slip.

mod beams;
mod cast;
mod clearance;
mod lattice;
mod person;
mod place;
mod solid;
mod sound;
