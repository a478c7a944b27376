//! Map builders of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod known_marks;
pub mod occupancy_grid;
pub mod static_map;
