//! Parameters of dead reckoning.

use super::propagation::ErrorGrowth;
use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Dead reckoning from a known start: trusts the odometer, and says how unsure the pose becomes on the way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryParams {
    /// How the odometer's errors add up: `constant` errors (a wrong wheel radius) grow with the way, `random` ones
    /// (slip) with its square root.
    pub error_growth: ErrorGrowth,
    /// Two readings farther apart than this, beyond what the robot can drive in between, are a jump of the odometer,
    /// meters: the pose stays, and the jump is reported.
    pub jump_m: f64,
    /// The same for the heading, degrees.
    pub jump_deg: f64,
}

impl Default for OdometryParams {
    fn default() -> Self {
        OdometryParams { error_growth: ErrorGrowth::Constant, jump_m: 1.0, jump_deg: 60.0 }
    }
}

impl Params for OdometryParams {
    fn check(&self) -> Vec<BuildError> {
        [("jump_m", self.jump_m), ("jump_deg", self.jump_deg)]
            .into_iter()
            .filter(|(_, value)| !(*value > 0.0 && value.is_finite()))
            .map(|(key, value)| {
                BuildError::at(key, format!("is {value}, expected a finite number above zero"))
            })
            .collect()
    }
}
