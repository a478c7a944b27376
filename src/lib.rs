//! The `rumbo` command, as a library: one module a verb, and the registry of everything that is shipped.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

// A plugin crate that nothing refers to is dropped by the linker, and its plugins with it.
use rumbo_avoiders as _;
use rumbo_localizers as _;
use rumbo_maps as _;
use rumbo_planners as _;
use rumbo_sensors as _;
use rumbo_slam as _;
use rumbo_worlds as _;

pub mod check;
pub mod cli;
pub mod compare;
pub mod completions;
pub mod config;
pub mod diagnostics;
pub mod drive;
pub mod emulate;
pub mod eval;
pub mod exit;
pub mod laws;
pub mod load;
pub mod map;
pub mod new;
pub mod outcome;
pub mod picture;
pub mod plot;
pub mod plugins;
pub mod queue;
pub mod record;
pub mod recording;
pub mod replay;
pub mod report;
pub mod run;
pub mod schema;
pub mod terminal;
pub mod test;
pub mod usage;

pub use load::registry;
