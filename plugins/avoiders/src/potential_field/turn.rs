//! How far and which way the robot turns: Valverde Moreno (2015), section 4.2.4, figures 22 to 26.

use rumbo_core::frames::wrap_angle;
use std::f64::consts::PI;

/// From the robot's heading to where it should go, in (-π, π]: half a turn is counter-clockwise.
///
/// Correction of the source: where the signs differ and the difference is more than half a turn, it prints
/// `|yaw| - |path|`, which is 0 degrees for its own figure 24 instead of 90.
pub fn turn_error_rad(yaw_rad: f64, path_rad: f64) -> f64 {
    let error_rad = wrap_angle(path_rad - yaw_rad);
    if error_rad <= -PI { PI } else { error_rad }
}
