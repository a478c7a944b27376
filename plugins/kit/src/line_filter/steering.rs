//! Angle of the steered wheel (equation 2 of the source, which prints the small-angle limit).
//!
//! The velocity of the wheel's contact point is `(v, -M omega)` in the robot's frame when the wheel is M behind the axle: a
//! robot that turns left has its rear wheel steered to the right.

use super::state::wrapped;
use super::update::Row;
use nalgebra::Vector5;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the angle has to do with the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SteeringModel {
    /// `beta = arctan(-M omega / v)`.
    #[default]
    Arctangent,
    /// `beta = -M omega / v`, as printed: at the curves of a forklift wrong by as much as the noise, always to one side.
    SmallAngle,
}

/// The steered wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering {
    /// What the angle has to do with the motion.
    pub model: SteeringModel,
    /// How far the wheel is behind the axle, meters (M); negative in front of it.
    pub behind_m: f64,
    /// Standard deviation of the angle, radians (sigma_beta).
    pub angle_rad: f64,
    /// Below this speed the angle says nothing, m/s.
    pub min_speed_m_s: f64,
}

impl Default for Steering {
    fn default() -> Self {
        Steering {
            model: SteeringModel::Arctangent,
            behind_m: 1.30,
            angle_rad: 0.5f64.to_radians(),
            min_speed_m_s: 0.5,
        }
    }
}

impl Steering {
    /// The angle that the wheel should have, radians; none where the robot is too slow.
    pub fn expected(&self, robot: &Vector5<f64>) -> Option<f64> {
        let (v, turn) = (robot[3], self.behind_m * robot[4]);
        // Driving backward the wheel stands as it does forward.
        let ratio = -turn / v;
        (v.abs() >= self.min_speed_m_s && ratio.is_finite()).then(|| match self.model {
            SteeringModel::Arctangent => ratio.atan(),
            SteeringModel::SmallAngle => ratio,
        })
    }

    /// The measurement of the angle; none where the robot is too slow.
    pub fn row(&self, robot: &Vector5<f64>, angle_rad: f64) -> Option<Row> {
        let expected = self.expected(robot)?;
        let (m, v, omega) = (self.behind_m, robot[3], robot[4]);
        let square = match self.model {
            SteeringModel::Arctangent => v * v + m * m * omega * omega,
            SteeringModel::SmallAngle => v * v,
        };
        let weights = [(3, m * omega / square), (4, -m * v / square)];
        Some(Row::new(&weights, wrapped(angle_rad - expected), self.angle_rad * self.angle_rad))
    }
}
