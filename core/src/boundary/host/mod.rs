//! The host's side: a library's entries become registry entries, and their instances stages like any other.

mod avoider;
mod call;
mod callbacks;
mod config;
mod entry;
#[cfg(feature = "host")]
mod file;
mod library;
mod localizer;
mod log;
mod map_builder;
mod map_mut;
mod module;
mod paths;
mod planner;
mod sensor;
mod slam;
mod world;

#[cfg(feature = "host")]
pub use file::FileError;
pub use library::{Library, LoadError, LoadReason};
pub use log::{LogLevel, PluginLog, log, on_log};
pub use module::ModuleError;

pub(super) use world::blank as blank_answer;
