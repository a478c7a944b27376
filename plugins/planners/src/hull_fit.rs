//! Whether a planner's clearance lets the robot's hull through at all.

use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;

/// Paths that come nearer to obstacles than the hull reaches to every side cannot be driven.
///
/// # Errors
/// A fault of the key that holds the clearance (from the robot's middle, meters).
pub(crate) fn fits_hull(key: &str, clearance_m: f64, robot: &Robot) -> Result<(), BuildError> {
    let inner_radius_m = robot.hull().inner_radius_m();
    if clearance_m >= inner_radius_m {
        return Ok(());
    }
    let message =
        format!("is {clearance_m}, but the hull reaches {inner_radius_m} m from the middle of the robot");
    Err(BuildError::at(key, message).help("a path that near to a wall cannot be driven; raise the clearance"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_that_is_wider_than_the_clearance_is_told() {
        let robot = Robot { radius_m: 0.35, ..Robot::default() };
        let fault = fits_hull("minimum_clearance_m", 0.3, &robot).unwrap_err();
        assert_eq!((fault.path.as_str(), fault.message.contains("0.35 m")), ("minimum_clearance_m", true));
        assert!(fits_hull("minimum_clearance_m", 0.35, &robot).is_ok());
    }
}
