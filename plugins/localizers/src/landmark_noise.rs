//! Noise on landmarks as a parameter, for experiments.

use rumbo_core::stages::BuildError;
use rumbo_kit::landmarks::LandmarkNoise;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Noise on landmarks, uniform in distance and bearing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkNoiseParams {
    /// Each landmark has noise with this probability; both parts at once.
    pub share: f64,
    /// Largest error of the distance, meters.
    pub distance_m: f64,
    /// Largest error of the bearing, degrees.
    pub bearing_deg: f64,
}

impl Default for LandmarkNoiseParams {
    fn default() -> Self {
        LandmarkNoiseParams { share: 0.2, distance_m: 0.02, bearing_deg: 5.0 }
    }
}

impl LandmarkNoiseParams {
    /// What is wrong with them.
    pub fn faults(&self) -> Vec<BuildError> {
        let ranges = [
            ("share", self.share, 1.0),
            ("distance_m", self.distance_m, 1.0),
            ("bearing_deg", self.bearing_deg, 180.0),
        ];
        let bad = ranges.into_iter().filter(|(_, value, most)| !(0.0..=*most).contains(value));
        bad.map(|(key, value, most)| {
            BuildError::at(format!("landmark_noise.{key}"), format!("is {value}, expected 0 to {most}"))
        })
        .collect()
    }

    /// In the units of the kit.
    pub fn noise(&self) -> LandmarkNoise {
        LandmarkNoise {
            share: self.share,
            distance_m: self.distance_m,
            bearing_rad: self.bearing_deg.to_radians(),
        }
    }
}
