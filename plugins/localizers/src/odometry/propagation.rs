//! First-order propagation of the pose's covariance along the way.
//!
//! The pose moves as p' = p + R(yaw) d, so an error of the pose goes through its Jacobian F, and the odometer's own
//! errors come in through theirs (Siegwart and Nourbakhsh, *Introduction to Autonomous Mobile Robots* (2004), section
//! 5.2.4). Constant errors keep one Jacobian for the whole way (Borenstein and Feng 1996: most of a robot's odometry
//! error is of this kind); random ones add a variance that is proportional to the way (Chong and Kleeman 1997).
//! Both give the same result however finely the way is reported.

use nalgebra::{Matrix3, Vector2, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How errors of an odometer add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ErrorGrowth {
    /// The same error all the time: standard deviations grow with the way.
    #[default]
    Constant,
    /// A new error every moment: standard deviations grow with the square root of the way.
    Random,
}

/// A way of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// In the map's axes, meters.
    pub along: Vector2<f64>,
    /// Turn on the way, radians.
    pub turn_rad: f64,
}

impl Way {
    /// How the pose changes with the odometer's errors of distance (m/m), direction (rad/m) and turn (rad/rad), one a
    /// column. Half of a heading error that grows on the way acts on the way itself.
    pub fn by_errors(&self) -> Matrix3<f64> {
        let across = Vector2::new(-self.along.y, self.along.x);
        let bends = |rad: f64| Vector3::new(across.x * rad / 2.0, across.y * rad / 2.0, rad);
        let distance = Vector3::new(self.along.x, self.along.y, 0.0);
        Matrix3::from_columns(&[distance, bends(self.along.norm()), bends(self.turn_rad)])
    }

    /// How the pose after the way changes with the pose before it.
    pub fn by_pose(&self) -> Matrix3<f64> {
        let mut through = Matrix3::identity();
        through[(0, 2)] = -self.along.y;
        through[(1, 2)] = self.along.x;
        through
    }
}

/// How unsure a dead-reckoned pose is.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// From the start and from random errors; x, y, yaw in the map's axes.
    covariance: Matrix3<f64>,
    /// What one standard deviation of each constant error (distance, direction, turn) did to the pose so far.
    drift: Matrix3<f64>,
}

impl Uncertainty {
    /// At the start.
    pub fn new(covariance: Matrix3<f64>) -> Uncertainty {
        Uncertainty { covariance, drift: Matrix3::zeros() }
    }

    /// Covariance of x, y, yaw in the map's axes.
    pub fn covariance(&self) -> Matrix3<f64> {
        let full = self.covariance + self.drift * self.drift.transpose();
        // Rounding must not make it lopsided.
        (full + full.transpose()) / 2.0
    }

    /// The robot moved by `way` (in the map's axes) and turned by `turn_rad`; `noise` is what the odometer claims:
    /// standard deviations of distance (m/m), direction (rad/m) and turn (rad/rad).
    pub fn advance(&mut self, way: Vector2<f64>, turn_rad: f64, noise: [f64; 3], growth: ErrorGrowth) {
        let way = Way { along: way, turn_rad };
        let (through, by_errors) = (way.by_pose(), way.by_errors());
        self.covariance = through * self.covariance * through.transpose();
        self.drift = through * self.drift;
        let length_m = way.along.norm();
        let amounts = [length_m, length_m, turn_rad.abs()];
        for (idx, amount) in amounts.into_iter().enumerate() {
            let effect = by_errors.column(idx) * noise[idx];
            match growth {
                ErrorGrowth::Constant => {
                    let column = self.drift.column(idx) + effect;
                    self.drift.set_column(idx, &column);
                }
                ErrorGrowth::Random if amount > 0.0 => {
                    self.covariance += effect * effect.transpose() / amount;
                }
                ErrorGrowth::Random => {}
            }
        }
    }

    /// The robot may have moved this far in any direction without anybody knowing.
    pub fn widen(&mut self, reach_m: f64, turn_rad: f64) {
        self.covariance += Matrix3::from_diagonal(&Vector3::new(reach_m, reach_m, turn_rad).map(|v| v * v));
    }
}
