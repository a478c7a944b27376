//! The classical field, whose force is the negative gradient of a potential: Valverde Moreno (2015), section 2.3.2,
//! equations 2.1 to 2.6, after Khatib (1986).
//!
//! Correction of the source: a local minimum is where the *gradient* is zero, not the potential.

use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Numbers of the classical field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Classical {
    /// Pull for each meter to the goal (ξ).
    pub xi: f64,
    /// Push of what is near (η).
    pub eta: f64,
    /// Farther things do not push, meters (ρ0).
    pub reach_m: f64,
}

impl Default for Classical {
    fn default() -> Self {
        Classical { xi: 1.0, eta: 0.2, reach_m: 1.0 }
    }
}

impl Classical {
    /// Nearer things are taken to be this far, meters: the force has no bound.
    pub const LEAST_M: f64 = 1e-3;

    /// Potential of the goal: `½ ξ ρ²`.
    pub fn attractive_potential(&self, position: Point2, goal: Point2) -> f64 {
        0.5 * self.xi * (position - goal).norm_squared()
    }

    /// Potential of something near: `½ η (1/ρ - 1/ρ0)²`.
    pub fn repulsive_potential(&self, position: Point2, obstacle: Point2) -> f64 {
        let distance_m = (position - obstacle).norm().max(Self::LEAST_M);
        if distance_m > self.reach_m {
            return 0.0;
        }
        0.5 * self.eta * (1.0 / distance_m - 1.0 / self.reach_m).powi(2)
    }

    /// Force of the goal (equation 2.4).
    pub fn attraction(&self, position: Point2, goal: Point2) -> Vector2<f64> {
        (goal - position) * self.xi
    }

    /// Force of something near (equation 2.5): `away` is used where the robot stands on it.
    pub fn repulsion(&self, position: Point2, obstacle: Point2, away: Vector2<f64>) -> Vector2<f64> {
        let off = position - obstacle;
        let distance_m = off.norm();
        if distance_m > self.reach_m {
            return Vector2::zeros();
        }
        let away = if distance_m < Self::LEAST_M { away } else { off / distance_m };
        let distance_m = distance_m.max(Self::LEAST_M);
        away * (self.eta * (1.0 / distance_m - 1.0 / self.reach_m) / distance_m.powi(2))
    }
}
