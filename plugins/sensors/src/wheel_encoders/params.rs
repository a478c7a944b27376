//! What `[[sensor]] plugin = "wheel_encoders"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::odometer::Steps;

/// Odometry from the wheels of any drive. Slip is the world's: encoders count what the wheels roll.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WheelEncodersParams {
    /// Rolled distance of one encoder count, meters; 0 counts exactly.
    pub wheel_step_m: f64,
    /// Step of the reported position, meters; 0 reports exactly. A Nomad Super Scout II has a tenth of an inch.
    pub position_step_m: f64,
    /// Step of the reported heading, degrees; 0 reports exactly. A Nomad Super Scout II has 0.1.
    pub heading_step_deg: f64,
    /// Standard deviation of each wheel's speed between two reports, m/s.
    pub speed_noise_m_s: f64,
    /// Standard deviation of the distance that the report claims, meters per meter.
    pub claimed_distance: f64,
    /// Standard deviation of the direction that the report claims, degrees per meter.
    pub claimed_direction_deg_m: f64,
    /// Standard deviation of the turn that the report claims, radians per radian.
    pub claimed_turn: f64,
}

impl Default for WheelEncodersParams {
    fn default() -> Self {
        Self {
            wheel_step_m: 0.0,
            position_step_m: 0.0,
            heading_step_deg: 0.0,
            speed_noise_m_s: 0.0,
            claimed_distance: 0.02,
            claimed_direction_deg_m: 0.5,
            claimed_turn: 0.02,
        }
    }
}

impl Params for WheelEncodersParams {
    fn check(&self) -> Vec<BuildError> {
        let numbers = [
            ("wheel_step_m", self.wheel_step_m),
            ("position_step_m", self.position_step_m),
            ("heading_step_deg", self.heading_step_deg),
            ("speed_noise_m_s", self.speed_noise_m_s),
            ("claimed_distance", self.claimed_distance),
            ("claimed_direction_deg_m", self.claimed_direction_deg_m),
            ("claimed_turn", self.claimed_turn),
        ];
        numbers
            .into_iter()
            .filter(|(_, value)| !(value.is_finite() && *value >= 0.0))
            .map(|(key, value)| {
                BuildError::at(key, format!("is {value}, expected a finite number, 0 or more"))
            })
            .collect()
    }
}

impl WheelEncodersParams {
    /// Steps of the device.
    pub(super) fn steps(&self) -> Steps {
        Steps {
            wheel_m: self.wheel_step_m,
            position_m: self.position_step_m,
            heading_rad: self.heading_step_deg.to_radians(),
        }
    }
}
