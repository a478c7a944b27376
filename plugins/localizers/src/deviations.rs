//! How far off a planar pose may be, in two numbers.

use nalgebra::Matrix3;

/// Of a covariance of x, y, yaw: largest standard deviation of the position in any direction (m), and that of the heading
/// (rad).
pub fn deviations(covariance: &Matrix3<f64>) -> [f64; 2] {
    let position = covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let largest_m2: f64 = position.symmetric_eigenvalues().max();
    [largest_m2.max(0.0).sqrt(), covariance[(2, 2)].max(0.0).sqrt()]
}
