mod fits;
mod scans;
mod segmentation;
mod weights;

use super::*;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/line_slam/");

/// A full circle in steps of half a degree that begins behind the robot.
fn circle() -> BeamFan {
    BeamFan {
        first_bearing_rad: -std::f64::consts::PI,
        bearing_step_rad: 0.5f64.to_radians(),
        min_range_m: 0.0,
        max_range_m: 40.0,
    }
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} for {expected}");
}
