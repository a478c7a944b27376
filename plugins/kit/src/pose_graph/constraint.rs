//! What is known between two poses, and how far they are from it.

use super::kernel::RobustKernel;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, wrap_angle};

/// The pose `to` as seen from the pose `from`, and how surely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    /// Node that is looked from; none where the map itself is: a prior.
    pub from: Option<usize>,
    /// Node that is seen.
    pub to: usize,
    /// What was measured.
    pub from_to: Pose2,
    /// Inverse covariance of x, y (in the measured frame) and turn.
    pub information: Matrix3<f64>,
    /// How far it may be off before it counts less.
    pub kernel: RobustKernel,
}

/// Error of a constraint and its slopes by both poses (x, y, turn added to each).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearized {
    /// x, y in the measured frame, turn.
    pub error: Vector3<f64>,
    /// By the pose looked from.
    pub by_from: Matrix3<f64>,
    /// By the pose seen.
    pub by_to: Matrix3<f64>,
}

impl Constraint {
    /// Error alone; poses are x, y, turn.
    pub fn error(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
        let z = self.from_to.translation.vector;
        let (sin, cos) = from.z.sin_cos();
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let off = nalgebra::Vector2::new(cos * dx + sin * dy - z.x, -sin * dx + cos * dy - z.y);
        let off = self.from_to.rotation.inverse() * off;
        Vector3::new(off.x, off.y, wrap_angle(to.z - from.z - self.from_to.rotation.angle()))
    }

    /// Error and slopes.
    pub fn linearize(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Linearized {
        let (sin, cos) = (from.z + self.from_to.rotation.angle()).sin_cos();
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        // Measured frame from map.
        let by_to = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let mut by_from = -by_to;
        by_from[(0, 2)] = -sin * dx + cos * dy;
        by_from[(1, 2)] = -cos * dx - sin * dy;
        Linearized { error: self.error(from, to), by_from, by_to }
    }

    /// Squared error in units of its variance.
    pub fn chi2(&self, error: &Vector3<f64>) -> f64 {
        error.dot(&(self.information * error)).max(0.0)
    }
}
