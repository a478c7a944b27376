//! A pipeline: read from its file, checked, and understood: what an [`Engine`](crate::engine::Engine) is built from.
//!
//! [`Loaded::read`] reads a file in two steps: the framework's keys first, then each plugin's keys by its registry
//! entry. [`schema`] describes the whole file for editors.

mod doubts;
mod draft;
mod fits;
mod followed;
mod libraries;
mod load;
mod mission;
mod own_sections;
mod reserved;
mod schema;
mod script;
mod seat;
mod section;
mod sensors;
mod spec;

pub use libraries::{Pinned, PluginFile};
pub use load::Loaded;
pub use mission::{Expect, Follow, InitialPose, Mission, PipelineTest, Waypoint, WellKnownPose};
pub use own_sections::{Head, RecordTo};
pub use reserved::{Mount, Reserved};
pub use schema::schema;
pub use script::{Script, ScriptError};
pub use seat::Seat;
pub use spec::{Pipeline, Rate, SensorSpec, StageSpec};

#[cfg(test)]
mod tests;
