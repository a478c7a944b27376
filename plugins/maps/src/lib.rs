//! Map builders of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod known_marks;
pub mod lasting_changes;
pub mod occupancy_grid;
mod scan_poses;
pub mod static_map;
