//! Covariances of poses in other frames.

use nalgebra::{Matrix3, Vector2};
use rumbo_core::frames::Pose2;

/// Covariance of a pose that is fixed to another at `lever` from it (in the same axes).
pub fn moved_by(covariance: &Matrix3<f64>, lever: &Vector2<f64>) -> Matrix3<f64> {
    let mut through = Matrix3::identity();
    through[(0, 2)] = -lever.y;
    through[(1, 2)] = lever.x;
    through * covariance * through.transpose()
}

/// The same covariance in the axes of a pose that is seen in the axes it is given in.
pub fn in_axes_of(frame: &Pose2, covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let (sin, cos) = frame.rotation.angle().sin_cos();
    let turn = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
    turn * covariance * turn.transpose()
}
