//! What `[[sensor]] plugin = "steering_encoder"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An encoder on the steered wheel of a tricycle: its angle, counter-clockwise from straight ahead. A vehicle that turns
/// left has a front wheel at a positive angle, a rear wheel at a negative one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SteeringEncoderParams {
    /// Standard deviation of the angle, degrees.
    pub deviation_deg: f64,
    /// Step of the reported angle, degrees; 0 reports exactly.
    pub step_deg: f64,
    /// What the encoder says when the wheel points straight ahead, degrees: it was not mounted quite right.
    pub offset_deg: f64,
}

impl Default for SteeringEncoderParams {
    fn default() -> Self {
        Self { deviation_deg: 0.5, step_deg: 0.0, offset_deg: 0.0 }
    }
}

impl Params for SteeringEncoderParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        for (key, value) in [("deviation_deg", self.deviation_deg), ("step_deg", self.step_deg)] {
            if !(0.0..=90.0).contains(&value) {
                faults.push(BuildError::at(key, format!("is {value}, expected 0 to 90")));
            }
        }
        if !(-90.0..=90.0).contains(&self.offset_deg) {
            faults.push(BuildError::at("offset_deg", format!("is {}, expected -90 to 90", self.offset_deg)));
        }
        faults
    }
}
