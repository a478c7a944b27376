//! The simulated world: walls and objects with heights, glass, people, slip.

mod cast;
mod lattice;
mod solid;
