//! What `[[sensor]] plugin = "lms200"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Lms200Mode, Lms200Unit};

/// The SICK LMS 200: ±15 mm, 8 m in millimeters or 80 m in centimeters, 180 or 100 degrees.
///
/// 0.25 degrees over 180 is not a variant of the device: it comes as four partial scans of 1 degree steps, each a
/// quarter degree further and each with its own stamp, so `rate_hz` then counts partial scans.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Lms200Params {
    /// 180 or 100 degrees.
    pub field_of_view_deg: f64,
    /// 1, 0.5 or 0.25 degrees.
    pub resolution_deg: f64,
    /// `"mm"` reaches 8.18 m, `"cm"` 81.8 m.
    pub unit: Lms200Unit,
    /// Exact readings in whole counts instead of readings within ±15 mm.
    pub exact: bool,
}

impl Default for Lms200Params {
    fn default() -> Self {
        Self { field_of_view_deg: 180.0, resolution_deg: 0.5, unit: Lms200Unit::Millimeters, exact: false }
    }
}

impl Params for Lms200Params {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if Lms200Mode::new(self.field_of_view_deg, 1.0).is_none() {
            let message =
                format!("is {}, expected 180 or 100: the device has no other", self.field_of_view_deg);
            faults.push(BuildError::at("field_of_view_deg", message));
        }
        if Lms200Mode::new(180.0, self.resolution_deg).is_none() {
            let message =
                format!("is {}, expected 1, 0.5 or 0.25: the device has no other", self.resolution_deg);
            faults.push(BuildError::at("resolution_deg", message));
        }
        faults
    }
}

impl Lms200Params {
    /// The device's variant; `None` when [`check`](Params::check) has faults.
    pub fn mode(&self) -> Option<Lms200Mode> {
        Lms200Mode::new(self.field_of_view_deg, self.resolution_deg)
    }
}
