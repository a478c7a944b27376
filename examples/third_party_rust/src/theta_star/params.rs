//! What `[planner] plugin = "theta_star"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Short paths that are not bound to the directions of the grid.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ThetaStarParams {
    /// Free space between the robot's middle and every obstacle, meters; the radius of the hull and 0.05 m when absent.
    #[schemars(range(min = 0.0))]
    pub clearance_m: Option<f64>,
    /// How much the distance that is left counts: 1 gives the shortest path, more ends sooner with a longer one.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub greediness: f64,
}

impl Default for ThetaStarParams {
    fn default() -> Self {
        Self { clearance_m: None, greediness: 1.0 }
    }
}

impl Params for ThetaStarParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if let Some(found) = self.clearance_m.filter(|m| !(m.is_finite() && *m >= 0.0)) {
            faults.push(BuildError::at("clearance_m", format!("is {found}, expected a number of 0 or more")));
        }
        if !(1.0..=10.0).contains(&self.greediness) {
            let found = self.greediness;
            faults.push(BuildError::at("greediness", format!("is {found}, expected a number from 1 to 10")));
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_impossible_value_is_named_at_once() {
        let params = ThetaStarParams { clearance_m: Some(-0.1), greediness: f64::NAN };
        let keys: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
        assert_eq!(keys, ["clearance_m", "greediness"]);
        assert!(ThetaStarParams::default().check().is_empty());
    }
}
