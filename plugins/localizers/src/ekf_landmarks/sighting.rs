//! What a camera measures of a mark: range and bearing.

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2};
use rumbo_core::frames::{Pose2, wrap_angle};

/// A mark whose sensor stands nearer to it than this has no bearing, meters.
const NEAREST_M: f64 = 1e-3;

/// One measured mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Range (m) and bearing (rad).
    pub measured: Vector2<f64>,
    /// Their covariance.
    pub noise: Matrix2<f64>,
    /// The sensor, seen from where the base is in the belief: a mark that was seen a moment before or after that is seen
    /// from where the sensor was then.
    pub base_from_sensor: Pose2,
}

/// What is expected of a mark at a pose, and how that changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Range (m) and bearing (rad).
    pub expected: Vector2<f64>,
    /// By x, y, yaw of the base.
    pub by_pose: Matrix2x3<f64>,
    /// By the place of the mark.
    pub by_mark: Matrix2<f64>,
}

/// Range and bearing of a mark from a pose of the base; none where the sensor stands on the mark.
pub fn expect(map_from_base: &Pose2, base_from_sensor: &Pose2, mark: &Point2<f64>) -> Option<Expected> {
    let arm = map_from_base.rotation * base_from_sensor.translation.vector;
    let to_mark = mark.coords - map_from_base.translation.vector - arm;
    let range_m = to_mark.norm();
    if range_m < NEAREST_M {
        return None;
    }
    let heading_rad = map_from_base.rotation.angle() + base_from_sensor.rotation.angle();
    let bearing_rad = wrap_angle(to_mark.y.atan2(to_mark.x) - heading_rad);
    let (along, across) = (to_mark / range_m, Vector2::new(-to_mark.y, to_mark.x) / range_m.powi(2));
    let by_mark = Matrix2::from_rows(&[along.transpose(), across.transpose()]);
    // When the base turns, its sensor moves on a circle.
    let sensor_by_yaw = Vector2::new(-arm.y, arm.x);
    let by_yaw = -(by_mark * sensor_by_yaw) - Vector2::new(0.0, 1.0);
    let by_pose = Matrix2x3::from_columns(&[-by_mark.column(0), -by_mark.column(1), by_yaw]);
    Some(Expected { expected: Vector2::new(range_m, bearing_rad), by_pose, by_mark })
}

impl Sighting {
    /// Measured minus expected, the bearing the short way round.
    pub fn minus(&self, expected: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(self.measured.x - expected.x, wrap_angle(self.measured.y - expected.y))
    }

    /// The point that was seen, in the base's frame.
    pub fn in_base(&self) -> Point2<f64> {
        let (sin, cos) = self.measured.y.sin_cos();
        self.base_from_sensor * (Point2::new(cos, sin) * self.measured.x)
    }
}
