//! What `[world] plugin = "sim"` takes.

use std::path::PathBuf;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::slip::Slip;

/// A simulated place in 2.5 dimensions: walls and objects with heights, glass, doors and people.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SimParams {
    /// A TOML world file, or a map_server YAML file, relative to the pipeline's folder. Without it: an endless plain.
    pub map: Option<PathBuf>,
    /// Where the robot stands at the start.
    pub start: Start,
    /// How the wheels slip, such as `{ model = "gaussian", speed = 0.02, turn = 0.02, drift_deg_m = 0.5 }`; without it
    /// they grip.
    #[schemars(schema_with = "slip_schema")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip: Option<Box<dyn Slip>>,
    /// A map picture with more cells is refused.
    pub max_cells: u64,
}

/// A pose in the map.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// Along the map's x axis, meters.
    pub x_m: f64,
    /// Along the map's y axis, meters.
    pub y_m: f64,
    /// Counter-clockwise from the map's x axis, degrees.
    pub yaw_deg: f64,
}

impl Default for SimParams {
    fn default() -> Self {
        Self {
            map: None,
            start: Start::default(),
            slip: None,
            max_cells: rumbo_kit::map_file::DEFAULT_MAX_CELLS,
        }
    }
}

/// Slip models are an open family: their names and keys are known to the program that links them.
pub(crate) fn slip_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": ["object", "null"],
        "properties": { "model": { "type": "string" } },
        "required": ["model"]
    })
}

impl Params for SimParams {
    fn check(&self) -> Vec<BuildError> {
        let Start { x_m, y_m, yaw_deg } = self.start;
        let numbers = [("start.x_m", x_m), ("start.y_m", y_m), ("start.yaw_deg", yaw_deg)];
        let mut faults: Vec<BuildError> = numbers
            .into_iter()
            .filter(|(_, value)| !value.is_finite())
            .map(|(key, value)| BuildError::at(key, format!("is {value}, expected a finite number")))
            .collect();
        if self.max_cells == 0 {
            faults.push(BuildError::at("max_cells", "is 0, expected at least 1"));
        }
        for (key, message) in self.slip.iter().flat_map(|slip| slip.faults()) {
            faults.push(BuildError::at(format!("slip.{key}"), message));
        }
        faults
    }
}
