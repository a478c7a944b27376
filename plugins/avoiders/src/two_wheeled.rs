//! What the avoiders for a robot of two wheels and something that sees tell the framework of themselves.

use rumbo_core::messages::ObservationKind;
use rumbo_core::registry::Manifest;
use rumbo_core::robot::{DriveKind, Robot};
use rumbo_core::stages::BuildError;

/// They see by scanners, sonars and clouds, in any mix, twenty times a second.
pub fn manifest() -> Manifest {
    let eyes = vec![ObservationKind::LaserScan, ObservationKind::RangeRing, ObservationKind::PointCloud];
    Manifest {
        consumes: vec![eyes],
        drives: vec![DriveKind::Differential],
        default_rate_hz: Some(20.0),
        ..Manifest::default()
    }
}

/// The robot has other wheels.
pub fn other_drive(robot: &Robot) -> BuildError {
    let kind = robot.drive.kind().name();
    BuildError::at("", format!("steers the two wheels of a differential drive, and the robot's is {kind}"))
}
