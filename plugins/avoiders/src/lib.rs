//! Avoiders of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod explained;
pub mod listening;
pub mod progress;
pub mod pure_pursuit;
pub mod sightings;
pub mod stop_and_replan;
