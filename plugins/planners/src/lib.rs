//! Planners of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod a_star;
pub mod dp;
mod hull_fit;
pub mod plan_grid;

#[cfg(test)]
mod text_world;
