//! What `[map_builder] plugin = "static_map"` takes.

use std::path::PathBuf;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A map from a file: a grid, and wall lines when a stage needs them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StaticMapParams {
    /// A map_server YAML file or a TOML world file, relative to the pipeline's folder. Without it: the world's map.
    pub file: Option<PathBuf>,
    /// Edge of a cell where a world file has no picture behind it, meters.
    pub resolution_m: f64,
    /// Shorter pieces of wall give no line, meters.
    pub min_line_m: f64,
    /// A map with more cells is refused.
    pub max_cells: u64,
}

impl Default for StaticMapParams {
    fn default() -> Self {
        Self {
            file: None,
            resolution_m: 0.05,
            min_line_m: 0.4,
            max_cells: rumbo_kit::map_file::DEFAULT_MAX_CELLS,
        }
    }
}

impl Params for StaticMapParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        for (key, value) in [("resolution_m", self.resolution_m), ("min_line_m", self.min_line_m)] {
            if !(value.is_finite() && value > 0.0) {
                faults.push(BuildError::at(key, format!("is {value}, expected a finite length above 0")));
            }
        }
        if self.max_cells == 0 {
            faults.push(BuildError::at("max_cells", "is 0, expected at least 1"));
        }
        faults
    }
}
