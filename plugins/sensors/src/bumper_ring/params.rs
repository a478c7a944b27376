//! What `[[sensor]] plugin = "bumper_ring"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A ring of touch sensors, numbered counter-clockwise from the mount's x axis; each feels the sector around it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BumperRingParams {
    /// How many, evenly around the ring; at most 64. The Nomad Super Scout II has 16.
    pub bumpers: u32,
}

impl Default for BumperRingParams {
    fn default() -> Self {
        Self { bumpers: 16 }
    }
}

impl Params for BumperRingParams {
    fn check(&self) -> Vec<BuildError> {
        if (1..=64).contains(&self.bumpers) {
            return Vec::new();
        }
        vec![BuildError::at("bumpers", format!("is {}, expected 1 to 64", self.bumpers))]
    }
}
