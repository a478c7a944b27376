//! Artificial potentials: a goal attracts, obstacles repel, and charges that stand for nothing push out of local minima.
//!
//! Attraction and repulsion: Khatib, "Real-time obstacle avoidance for manipulators and mobile robots" (1986), in the
//! forms of Mora, Armesto and Tornero, "Sistema de navegación de robots móviles en entornos industriales", section 3,
//! equations (4) to (10), which is "the source" here. The force is always minus the gradient of the potential, but for
//! [`ChargeForce::Printed`].

mod attraction;
mod repulsion;

mod obstacles;
mod segment_index;

mod charge;
mod field;
mod keep_clear;

mod grid_outline;
mod line_outline;
mod outline;

pub mod charge_map;

pub use attraction::{Attraction, Form};
pub use charge::{ChargeForce, ChargeLaw, NEAREST_CHARGE_M};
pub use field::{Field, Sample};
pub use grid_outline::outlines_of_grid;
pub use keep_clear::without_approach;
pub use line_outline::{each_line, outlines_of_lines};
pub use obstacles::{Group, Nearest, NotFinite, Obstacles, Piece};
pub use repulsion::{ON_A_LINE_M, Repulsion};

#[cfg(test)]
mod tests;
