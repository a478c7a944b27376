//! What `[map_builder] plugin = "known_marks"` takes.

use std::path::PathBuf;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Marks that a robot can recognize, from a file: the map's layer `landmarks`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct KnownMarksParams {
    /// A TOML file with tables `[[mark]]` (`identity`, `x_m`, `y_m`, `deviation_m`), or an MRCLAM folder, relative to the
    /// pipeline's folder. Without it: the `[[mark]]` tables of the world's own map, a TOML world file.
    pub file: Option<PathBuf>,
    /// No mark is surer than this, meters (standard deviation of x and of y).
    pub least_deviation_m: f64,
}

impl Params for KnownMarksParams {
    fn check(&self) -> Vec<BuildError> {
        let value = self.least_deviation_m;
        if value.is_finite() && value >= 0.0 {
            return Vec::new();
        }
        vec![BuildError::at(
            "least_deviation_m",
            format!("is {value}, expected a finite length of at least 0"),
        )]
    }
}
