//! Keys for how unsure the sensors are.

use super::odometer_noise::OdometerNoise;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How unsure the sensors are: standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SensorNoiseParams {
    /// Of the speed of each wheel, m/s (sigma_1, sigma_2); also of an odometer that says nothing of its errors.
    pub wheel_speed_m_s: f64,
    /// Of the angle of the steered wheel, degrees (sigma_beta).
    pub steering_deg: f64,
    /// Of a range, meters (sigma_r).
    pub range_m: f64,
    /// Of a bearing, degrees (sigma_alpha).
    pub bearing_deg: f64,
    /// Of a wall's surface, meters (sigma_xy).
    pub surface_m: f64,
    /// Of an odometer.
    pub odometer: OdometerNoiseParams,
    /// No line's distance is surer than this, meters.
    pub least_distance_m: f64,
    /// No line's normal is surer than this, degrees.
    pub least_normal_deg: f64,
}

impl Default for SensorNoiseParams {
    fn default() -> Self {
        SensorNoiseParams {
            wheel_speed_m_s: 0.02,
            steering_deg: 0.5,
            range_m: 0.03,
            bearing_deg: 0.1,
            surface_m: 0.005,
            odometer: OdometerNoiseParams::default(),
            least_distance_m: 0.005,
            least_normal_deg: 0.1,
        }
    }
}

/// How unsure an odometer is: standard deviations. Those of the way grow with its root; 0 is what the odometer says of
/// itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OdometerNoiseParams {
    /// Of the distance after one meter, meters.
    pub distance: f64,
    /// Of the direction after one meter, degrees.
    pub direction_deg_m: f64,
    /// Of a turn by one radian, radians.
    pub turn: f64,
    /// Of the place after one second in which the wheels may stand, meters.
    pub standing_m: f64,
    /// Of the direction after one second in which the wheels may stand, degrees: robots that are pushed, or that push
    /// against something, turn without their wheels.
    pub standing_deg: f64,
}

impl Default for OdometerNoiseParams {
    fn default() -> Self {
        OdometerNoiseParams {
            distance: 0.0,
            direction_deg_m: 0.0,
            turn: 0.0,
            standing_m: 0.001,
            standing_deg: 0.03,
        }
    }
}

impl OdometerNoiseParams {
    /// As numbers of the filter.
    pub(super) fn noise(&self) -> OdometerNoise {
        OdometerNoise {
            way: [self.distance, self.direction_deg_m.to_radians(), self.turn],
            standing: [self.standing_m, self.standing_deg.to_radians()],
            wheels: None,
        }
    }
}
