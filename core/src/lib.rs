//! Messages, maps, stage traits, registry, pipeline file and engine of Rumbo.
//!
//! Stages, messages and maps are the seams; the engine is the only place where they meet.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod boundary;
pub mod document;
pub mod engine;
pub mod frames;
pub mod map;
pub mod messages;
pub mod odometry_track;
pub mod pipeline;
pub mod registry;
pub mod rng;
pub mod robot;
pub mod saved_state;
pub mod seal;
pub mod stages;
pub mod time;
pub mod trace;

/// Poses and covariances are made of it: a plugin names it from here, and so in the version that fits.
pub use nalgebra;

/// What the registration macros need to name from other crates.
#[doc(hidden)]
pub mod macro_support {
    pub use inventory;
}
