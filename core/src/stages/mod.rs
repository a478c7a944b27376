//! The seams: one trait a stage, one file a trait.

mod avoider;
mod context;
mod give_up;
mod localizer;
mod map_builder;
mod planner;
mod sensor;
mod slam;
mod world;

pub use avoider::{AvoidError, AvoidInput, Avoider, Steering};
pub use context::{Background, BackgroundJob, BuildContext, BuildError, Cx};
pub use give_up::GiveUp;
pub use localizer::{LocalizeError, Localizer};
pub use map_builder::{MapBuilder, MapError, MapInput};
pub use planner::{PlanError, PlanRequest, Planner};
pub use sensor::{Sensor, SensorError};
pub use slam::{Slam, SlamError};
pub use world::{
    Advance, Answer, Attitude, Drove, Medium, OwnDevice, Probe, Truth, WheelMotion, World, WorldError,
};
