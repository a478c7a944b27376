//! The field that draws the robot to its goal and pushes it off what is near.
//!
//! Valverde Moreno (2015), equations 4.7 to 4.10 and table 5. Both parts are multiples of the full speed, in the map's
//! frame.

use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The pull of the goal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Attraction {
    /// From `r_m` on, the pull grows over this distance, meters (s).
    pub s_m: f64,
    /// Nearer than this to the goal nothing pulls, meters (r); at most 10/11 of the mission's arrival radius, which else
    /// would never be met.
    pub r_m: f64,
    /// Pull for each meter (α).
    pub alpha: f64,
}

impl Default for Attraction {
    fn default() -> Self {
        Attraction { s_m: 1.0, r_m: 0.5, alpha: 1.0 }
    }
}

/// Where the push of what is very near points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NearField {
    /// Straight away from it.
    #[default]
    Radial,
    /// Along one of four diagonals of the map, by the signs of its direction, as published.
    Sign,
}

/// The push of what is near.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Repulsion {
    /// From `r_m` on, the push shrinks over this distance, meters (s).
    pub s_m: f64,
    /// Nearer than this it is `gamma`, meters (r).
    pub r_m: f64,
    /// Push for each meter (β).
    pub beta: f64,
    /// Push of what is very near (γ), no unit.
    pub gamma: f64,
    /// Where that one points: `radial`, or `sign` as published.
    pub near_field: NearField,
}

impl Default for Repulsion {
    fn default() -> Self {
        Repulsion { s_m: 0.5, r_m: 0.5, beta: 1.0, gamma: 0.7, near_field: NearField::Radial }
    }
}

/// A direction of the map's frame.
pub fn direction(angle_rad: f64) -> Vector2<f64> {
    let (sin, cos) = angle_rad.sin_cos();
    Vector2::new(cos, sin)
}

impl Attraction {
    /// The pull of a goal at this distance and angle (equations 4.7 and 4.8).
    pub fn at(&self, distance_m: f64, angle_rad: f64) -> Vector2<f64> {
        let beyond_m = (distance_m - self.r_m).clamp(0.0, self.s_m);
        direction(angle_rad) * (self.alpha * beyond_m)
    }
}

impl Repulsion {
    /// A direction along an axis has rounding in its other part, not a sign.
    const ON_AN_AXIS: f64 = 1e-8;

    /// Farther things do not push, meters.
    pub fn reach_m(&self) -> f64 {
        self.s_m + self.r_m
    }

    /// The push of something at this distance and angle (equations 4.9 and 4.10).
    pub fn at(&self, distance_m: f64, angle_rad: f64) -> Vector2<f64> {
        let toward = direction(angle_rad);
        if distance_m > self.reach_m() {
            return Vector2::zeros();
        }
        if distance_m >= self.r_m {
            return toward * (-self.beta * (self.reach_m() - distance_m));
        }
        let toward = match self.near_field {
            NearField::Radial => toward,
            NearField::Sign => {
                toward.map(|part| if part.abs() < Self::ON_AN_AXIS { 0.0 } else { part.signum() })
            }
        };
        toward * -self.gamma
    }
}
