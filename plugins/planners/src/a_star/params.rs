//! Parameters of `a_star`.

use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The shortest path over eight neighbors that keeps a clearance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AStarParams {
    /// Distance from the path to the edge of the nearest obstacle, meters. Absent: the radius of the robot's hull plus
    /// 0.10 m, which leaves the guard its margin. With zero, every free cell is open.
    pub clearance_m: Option<f64>,
    /// Cells of which nobody knows what they are count as obstacles. Otherwise no path enters them, but paths need not
    /// keep away from them.
    pub undetermined_is_obstacle: bool,
}

impl Default for AStarParams {
    fn default() -> Self {
        Self { clearance_m: None, undetermined_is_obstacle: true }
    }
}

/// Beyond the hull, where no clearance is given: what the guard keeps free, and room for an estimate that is off.
const HULL_MARGIN_M: f64 = 0.10;

impl AStarParams {
    /// Every impossible value.
    pub fn faults(&self) -> Vec<BuildError> {
        let wrong = self.clearance_m.filter(|clearance_m| !(clearance_m.is_finite() && *clearance_m >= 0.0));
        let fault = |clearance_m| {
            let message = format!("is {clearance_m}, expected a finite number of at least zero");
            BuildError::at("clearance_m", message)
        };
        wrong.map(fault).into_iter().collect()
    }

    /// The clearance for a robot of this radius.
    pub fn clearance_m(&self, robot_radius_m: f64) -> f64 {
        self.clearance_m.unwrap_or(robot_radius_m + HULL_MARGIN_M)
    }
}
