//! What the odometer says of a step, and how much it may err.

use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_kit::turn_way_turn::TurnWayTurn;

/// Errors of the odometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionNoise {
    /// Variances per square: turn by turn, turn by way (rad²/m²), way by way, way by turn (m²/rad²).
    pub alpha: [f64; 4],
    /// Standard deviation of any step, meters.
    pub floor_m: f64,
    /// The same of the heading, radians.
    pub floor_rad: f64,
}

/// A step of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The step as the odometer, or without one the velocity so far, has it.
    pub before_from_after: Pose2,
    /// Variances beside the odometer's, where it was silent or jumped: m² along each axis, and rad².
    pub stray: [f64; 2],
    /// Variance of its turn, rad², where a gyroscope has measured that.
    pub measured_turn: Option<f64>,
}

impl Default for Step {
    /// No step.
    fn default() -> Self {
        Step { before_from_after: Pose2::identity(), stray: [0.0; 2], measured_turn: None }
    }
}

impl Step {
    /// This step and then another.
    pub fn then(&self, next: &Step) -> Step {
        let both = self.measured_turn.zip(next.measured_turn).map(|(first, then)| first + then);
        Step {
            before_from_after: self.before_from_after * next.before_from_after,
            stray: [self.stray[0] + next.stray[0], self.stray[1] + next.stray[1]],
            measured_turn: if *self == Step::default() { next.measured_turn } else { both },
        }
    }
}

impl MotionNoise {
    fn parts(&self, step: &Step) -> TurnWayTurn {
        TurnWayTurn::between(&Pose2::identity(), &step.before_from_after, self.alpha)
    }

    /// Covariance of x, y, yaw after a step from here, in the map's axes: to first order in the noise of the two turns and
    /// the way.
    pub fn covariance(&self, map_from_before: &Pose2, step: &Step) -> Matrix3<f64> {
        let parts = self.parts(step);
        let [turn, way, _] = parts.mean;
        let (sin, cos) = (map_from_before.rotation.angle() + turn).sin_cos();
        let by_parts = Matrix3::new(-way * sin, cos, 0.0, way * cos, sin, 0.0, 1.0, 0.0, 1.0);
        let variance = Matrix3::from_diagonal(&Vector3::from(parts.variance));
        let (way, turn) = (self.floor_m.powi(2) + step.stray[0], self.floor_rad.powi(2) + step.stray[1]);
        let by_wheels = by_parts * variance * by_parts.transpose()
            + Matrix3::from_diagonal(&Vector3::new(way, way, turn));
        let Some(measured) = step.measured_turn else { return by_wheels };
        // Given the turn, less is open of the way, too.
        let with_turn = by_wheels.column(2).into_owned();
        by_wheels - with_turn * with_turn.transpose() / (with_turn.z + measured)
    }
}
