//! `lasting_changes`: what stands elsewhere than on the map in several visits becomes part of it, and what is gone leaves
//! it.
//!
//! Hernández Alamilla (2005) keeps the map as it was made and names that a limit of his system; this takes the limit away.
//! Within a visit each cell gathers scans that end in it or see through it; at its end a cell that differs from the map
//! counts once. Cells that differ in several visits, one after the other, change the map.

mod beams;
mod conclusion;
mod evidence;
mod memory;
mod memory_file;
mod params;
mod plugin;
mod raster;
mod visit;

pub use beams::{Beam, BeamFan, cells_on};
pub use conclusion::{Conclusion, Removal, Rules, conclude};
pub use evidence::{CellEvidence, Verdict, VisitRules};
pub use memory::{CellMemory, Memory};
pub use memory_file::{MemoryFault, memory_bytes, memory_of};
pub use params::{LastingChangesParams, RemovalRule};
pub use plugin::LastingChanges;
pub use raster::Raster;
pub use visit::Visit;
