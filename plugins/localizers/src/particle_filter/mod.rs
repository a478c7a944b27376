//! `particle_filter`: Monte-Carlo localization on a grid map.
//!
//! KLD-adaptive (Fox 2001), with recovery from kidnapping (augmented MCL; Thrun, Burgard, Fox, *Probabilistic Robotics*
//! (2005), chapters 4 to 6 and 8). One update: move the particles, weigh them by the scans, say where the robot is,
//! draw new ones. While the robot is followed, beams that end at what the map does not show are left out
//! (`unmapped.rs`). Read [`filter`] first, then [`monte_carlo`], which decides when.

mod params;
mod plugin;

pub mod anchor;
pub mod beams;
pub mod clusters;
mod continuity;
pub mod filter;
mod flattening;
pub mod free_space;
pub mod kld;
pub mod measurement;
pub mod monte_carlo;
pub mod motion;
pub mod particles;
pub mod pose_bins;
pub mod recovery;
pub mod scan_queue;
mod silence;
mod slip;
pub mod streams;
pub mod sureness;
pub mod terrain;
pub mod tracker_settings;
mod unmapped;
pub mod wishes;

#[cfg(test)]
mod tests;

pub use params::ParticleFilterParams;
