//! The engine: the only place where stages meet.
//!
//! Read [`Engine::step`] first: it tells on one page how data flows from the sensors to the wheels.

mod act;
mod at_work;
mod build;
mod build_faults;
mod check;
mod closest;
mod cloud_cells;
mod errors;
mod events;
mod following;
mod guard;
mod inbox;
mod known_grid;
mod localization;
mod metrics;
mod navigator;
mod observer;
mod obstacles;
mod order;
mod orders;
mod patience;
mod planning;
mod range_points;
mod ring;
mod run;
mod save;
mod schedule;
mod scripted;
mod seat;
mod seats;
mod sense;
mod sight;
mod slam;
mod stall;
mod step;
mod stop_zone;
mod timing;
mod view;
mod watchdog;
mod wish;

pub use build::EngineError;
pub use check::WaypointFault;
pub use events::{Event, EventKind, Intervention};
pub use inbox::Inbox;
pub use metrics::{Counted, Metrics, Summary};
pub use navigator::Outcome;
pub use observer::{Observer, StepView};
pub use order::{Order, State};
pub use run::{EndReason, RunEnd};
pub use save::{SaveError, SavedMap};
pub use slam::AskError;
pub use step::{Engine, Stepped};
pub use timing::{Part, StageTimes};
pub use watchdog::{Lost, StepLimits, on_lost};
