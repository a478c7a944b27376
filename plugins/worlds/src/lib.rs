//! Worlds of Rumbo: the 2.5-D simulator, and recordings.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod log;
pub mod sim;
