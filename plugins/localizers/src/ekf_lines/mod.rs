//! `ekf_lines`: the filter of `ekf_line_slam` on walls that are known.
//!
//! The filter, and how lines are found in scans, is `rumbo_kit::line_filter` and `rumbo_kit::lines`.

mod params;
mod plugin;

#[cfg(test)]
mod tests;

pub use params::EkfLinesParams;
pub use plugin::EkfLines;
