//! Simultaneous localization and mapping for Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod ekf_line_slam;
pub mod graph_slam;
mod gyro;
pub mod rbpf_slam;
pub mod scan_match_slam;
mod turning;
mod unseen;
