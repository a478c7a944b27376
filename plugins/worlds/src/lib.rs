//! Worlds of Rumbo: the 2.5-D simulator, recordings, and the real robot.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod log;
pub mod robot;
pub mod sim;
