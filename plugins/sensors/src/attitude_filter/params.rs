//! What `[[sensor]] plugin = "attitude_filter"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_core::time::Span;
use rumbo_kit::nav_filter::NavSettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Roll and pitch of a device that measures turning rates and accelerations only: the rates turn the attitude, and gravity
/// levels it, while the bias of the rates is found (Arroyo Sánchez, 2013, section 3.2).
///
/// `inputs` is the device. Each of its readings is given again with an attitude; everybody else sees these instead. An
/// attitude that the device gives itself is not looked at. Yaw is that of the rates alone: it begins with 0 and drifts.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AttitudeFilterParams {
    /// Standard deviation of each turning rate, degrees a second.
    pub gyro_noise_deg_s: f64,
    /// How the bias of the rates walks, degrees a second per root of a second.
    pub gyro_bias_walk_deg_s: f64,
    /// Standard deviation of the bias of the rates at the start, degrees a second.
    pub gyro_bias_deg_s: f64,
    /// Accelerations whose length is this near to gravity level the attitude, m/s².
    pub gravity_gate_m_s2: f64,
    /// At turning rates beyond this, leveling counts less, degrees a second.
    pub leveling_rate_deg_s: f64,
    /// Standard deviation of a leveling, degrees: on a robot that speeds up and brakes, more.
    pub leveling_std_deg: f64,
    /// Leveled at most so often, times a second.
    pub leveling_rate_hz: f64,
    /// The rates do not turn the attitude over a longer gap between two readings, seconds.
    pub max_gap_s: f64,
}

impl Default for AttitudeFilterParams {
    fn default() -> Self {
        Self {
            gyro_noise_deg_s: 0.6,
            gyro_bias_walk_deg_s: 0.006,
            gyro_bias_deg_s: 1.0,
            gravity_gate_m_s2: 0.5,
            leveling_rate_deg_s: 17.2,
            leveling_std_deg: 2.865,
            leveling_rate_hz: 20.0,
            max_gap_s: 0.2,
        }
    }
}

impl AttitudeFilterParams {
    /// The settings of the filter.
    pub(super) fn settings(&self) -> NavSettings {
        NavSettings {
            gyro_noise_rad_s: self.gyro_noise_deg_s.to_radians(),
            gyro_bias_walk: self.gyro_bias_walk_deg_s.to_radians(),
            gyro_bias_rad_s: self.gyro_bias_deg_s.to_radians(),
            gravity_gate_m_s2: self.gravity_gate_m_s2,
            leveling_rate_rad_s: self.leveling_rate_deg_s.to_radians(),
            leveling_std_rad: self.leveling_std_deg.to_radians(),
            aid_period: Span::from_secs(1.0 / self.leveling_rate_hz),
            max_gap: Span::from_secs(self.max_gap_s),
            ..NavSettings::default()
        }
    }
}

impl Params for AttitudeFilterParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        for (key, value, is_fine) in [
            ("gyro_noise_deg_s", self.gyro_noise_deg_s, self.gyro_noise_deg_s > 0.0),
            ("gyro_bias_walk_deg_s", self.gyro_bias_walk_deg_s, self.gyro_bias_walk_deg_s >= 0.0),
            ("gyro_bias_deg_s", self.gyro_bias_deg_s, self.gyro_bias_deg_s >= 0.0),
            ("gravity_gate_m_s2", self.gravity_gate_m_s2, self.gravity_gate_m_s2 > 0.0),
            ("leveling_rate_deg_s", self.leveling_rate_deg_s, self.leveling_rate_deg_s > 0.0),
            ("leveling_std_deg", self.leveling_std_deg, self.leveling_std_deg > 0.0),
            ("leveling_rate_hz", self.leveling_rate_hz, self.leveling_rate_hz > 0.0),
            ("max_gap_s", self.max_gap_s, self.max_gap_s > 0.0),
        ] {
            if !(value.is_finite() && is_fine) {
                let least = if key.starts_with("gyro_bias") { "of at least 0" } else { "above 0" };
                faults.push(BuildError::at(key, format!("is {value}, expected a number {least}")));
            }
        }
        faults
    }
}
