//! Two plugins that Rumbo does not ship, in a library of their own: a planner and an avoider.
//!
//! What makes it a plugin library is the last line, and `crate-type = ["cdylib"]` in `Cargo.toml`.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod follow_gap;
pub mod theta_star;

rumbo_core::export_plugins!();
