//! A pipeline, understood and checked: what an [`Engine`](crate::engine::Engine) is built from.

mod mission;
mod spec;

pub use mission::{Expect, InitialPose, Mission, PipelineTest, Waypoint, WellKnownPose};
pub use spec::{Pipeline, Rate, SensorSpec, StageSpec};
