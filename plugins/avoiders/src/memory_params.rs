//! Parameters of the short-term memory for obstacles, which several avoiders have.

use crate::faults::Faults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What left the view of the sensors a moment ago.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MemoryParams {
    /// It is kept for so long, seconds; 0 forgets at once.
    pub seconds: f64,
    /// No motion sweeps the hull over it.
    pub rotation_check: bool,
    /// It pushes, or is fled from, like what is seen: makes doors harder to pass.
    pub repel: bool,
}

impl Default for MemoryParams {
    fn default() -> Self {
        MemoryParams { seconds: 5.0, rotation_check: true, repel: false }
    }
}

impl MemoryParams {
    /// Adds what is wrong.
    pub fn check(&self, faults: &mut Faults) {
        faults.range("memory.seconds", self.seconds, 0.0, 600.0);
    }
}
