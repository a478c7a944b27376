//! `rbpf_slam`: many guesses of the robot's way, each with the map that belongs to it.
//!
//! A Rao-Blackwellized particle filter on occupancy grids (Grisetti, Stachniss, Burgard, *Improved Techniques for Grid
//! Mapping with Rao-Blackwellized Particle Filters*, IEEE T-RO 2007): each particle matches the scan with its own map, draws
//! its pose from what the match and the step so far say together, and is weighed by how well they agree. Differs from the
//! source: the step is not the wheels' alone, but what registering the scan on those just before it makes of it
//! ([`follower`]), once for all particles. Maps share what they have in common ([`rumbo_kit::tile_map`]). And a loop
//! that no particle closes is looked for ([`closing`]); what it was open by goes back over the way ([`bending`]). Read
//! [`filter`] first, then [`tracker`], which decides when.

mod params;
mod plugin;

pub mod archive;
pub mod bending;
pub mod closing;
pub mod diary;
pub mod filter;
pub mod follower;
pub mod lineage;
pub mod motion;
pub mod particle;
pub mod proposal;
mod saved;
pub mod settings;
pub mod tracker;
pub mod weights;

#[cfg(test)]
mod tests;

pub use params::RbpfSlamParams;
pub use plugin::RbpfSlam;
