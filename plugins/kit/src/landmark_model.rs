//! What a scanner would see from every free cell of a map, as natural landmarks: the model of global localization.
//! S. Hernández Alamilla, master's thesis (2005), section 7.1.
//!
//! The source stores each landmark with each cell that sees it. Here a landmark is stored by what it looks like (kind,
//! distance, extent) with the list of cells that see one like it, little more than a byte each, and the question which
//! cells see what the robot sees is answered without looking at the others. The few cells that are left are traced again
//! for their bearings, see [`Tracer::landmarks_of`].

mod band;
mod build;
mod file;
mod filter;
mod look;
mod order;
mod regions;
mod surroundings;

#[cfg(test)]
mod tests;

pub use build::{LandmarkModel, ModelBuilder, Progress};
pub use file::{ModelFileError, fingerprint, load_model, save_model, settings_name};
pub use filter::{CellScore, Filter, Similarity};
pub use look::{Look, LookKind};
pub use surroundings::{ModelSettings, Surroundings, Tracer};
