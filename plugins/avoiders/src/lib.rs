//! Avoiders of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod pure_pursuit;
pub mod stop_and_replan;
