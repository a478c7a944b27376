//! How the uncertainties of two motions, one after the other, add up (Smith, Self, Cheeseman 1990, compounding).

use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;

/// Covariance of a pose that is made of two: of `first` in a frame, and of `then` in that of `first`.
pub(crate) fn compounded(
    first_covariance: &Matrix3<f64>,
    first: &Pose2,
    then: &Pose2,
    then_covariance: &Matrix3<f64>,
) -> Matrix3<f64> {
    let (by_first, by_then) = by_parts(first, then);
    let sum =
        by_first * first_covariance * by_first.transpose() + by_then * then_covariance * by_then.transpose();
    (sum + sum.transpose()) * 0.5
}

/// How errors of `first`, in the axes of its frame, and of `then`, in those of `first`, move what they make together.
pub(crate) fn by_parts(first: &Pose2, then: &Pose2) -> (Matrix3<f64>, Matrix3<f64>) {
    let way = first.rotation * then.translation.vector;
    let mut by_first = Matrix3::identity();
    by_first[(0, 2)] = -way.y;
    by_first[(1, 2)] = way.x;
    (by_first, first.rotation.to_rotation_matrix().to_homogeneous())
}
