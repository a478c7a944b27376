//! `ekf_line_slam`: one Kalman filter for the robot and the walls around it.
//!
//! The filter, and how lines are found in scans, is `rumbo_kit::line_filter` and `rumbo_kit::lines`; the localizer
//! `ekf_lines` follows the robot on the walls that this plugin has found.

mod params;
mod plugin;

#[cfg(test)]
mod tests;

pub use params::EkfLineSlamParams;
pub use plugin::EkfLineSlam;
