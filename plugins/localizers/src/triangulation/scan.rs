//! A scan as a tracker gets it, and what came of it.

use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::time::Time;
use rumbo_kit::landmarks::BeamFan;

/// One scan in the frame of a sensor whose axis is upright.
#[derive(Debug)]
pub struct SeenScan<'a> {
    /// When.
    pub stamp: Time,
    /// Its beams.
    pub fan: BeamFan,
    /// Its ranges, meters.
    pub ranges_m: &'a [f32],
    /// Where the sensor sits.
    pub base_from_sensor: Pose2,
}

/// What came of a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The robot.
    pub map_from_base: Pose2,
    /// Covariance of x, y, yaw in the map's axes.
    pub covariance: Matrix3<f64>,
    /// Landmarks seen that are related to known ones and may be what they seem.
    pub n_related: usize,
    /// Estimates that the pose was made from: pairs, or single landmarks.
    pub n_estimates: usize,
    /// Share of the beams that the map explains.
    pub explained: Option<f64>,
}

impl Found {
    /// Landmarks add nothing to what the odometry says.
    pub fn by_odometry(map_from_base: Pose2, covariance: Matrix3<f64>, n_related: usize) -> Found {
        Found { map_from_base, covariance, n_related, n_estimates: 0, explained: None }
    }
}
