//! `landmark_relaxation`: finds a robot that may be anywhere, by natural landmarks. S. Hernández Alamilla, master's thesis
//! (2005), chapter 7.
//!
//! A model says what every cell of the map sees. The robot looks all around; a filter leaves the cells that see the like,
//! discrete relaxation those where the landmarks also lie to each other as they were observed, and least squares the best.
//! Beyond the source, scans are joined before landmarks are taken, the pose is refined beyond the size of a cell, places are
//! judged by the scans, and where several fit alike the robot looks again from elsewhere. Read [`search`] first, then
//! [`locator`].

mod params;
mod plugin;

pub mod expected_views;
pub mod fit;
pub mod locator;
pub mod match_score;
pub mod matching;
pub mod model_making;
pub mod model_seat;
pub mod motion;
pub mod next_move;
pub mod open_ways;
pub mod panorama;
pub mod refinement;
pub mod relaxation;
pub mod search;
pub mod sighting;
pub mod traced_beams;

#[cfg(test)]
mod tests;

pub use params::{LandmarkRelaxationParams, ModelCache};
