//! Planners of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod a_star;
pub mod dp;
pub mod fictitious_charges;
pub mod field_descent;
mod hull_fit;
pub mod plan_grid;
pub mod potential_field;

#[cfg(test)]
mod text_world;
