//! What several Rumbo plugins share: ray casting, distance fields, grid search, map and world files, robot
//! logs.
//!
//! The grid kernels work on plain slices and sizes in cells, so they can be used without the framework.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod cost_field;
pub mod distance_field;
pub mod generated_world;
mod grid_size;
pub mod log_file;
pub mod map_file;
pub mod occupancy;
pub mod proximity;
pub mod ray;
pub mod recording;
pub mod segment;
pub mod simd;
pub mod world_file;

pub use grid_size::{GridSize, NEIGHBORS_8};
