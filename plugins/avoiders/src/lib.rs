//! Avoiders of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod braitenberg;
pub mod clear_way;
pub mod effort;
pub mod explained;
pub mod faults;
pub mod listening;
pub mod lookout;
pub mod memory_params;
pub mod near_points;
pub mod nearest;
pub mod potential_field;
pub mod progress;
pub mod pulse;
pub mod pure_pursuit;
pub mod short_memory;
pub mod sightings;
pub mod stop_and_replan;
pub mod two_wheeled;
pub mod view;
pub mod wheels;

#[cfg(test)]
mod spec_samples;
