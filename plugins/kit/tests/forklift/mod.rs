//! The forklift experiment: a hall with six columns, driven through in circles; recorded, or simulated with a seed.
#![allow(dead_code, unused_imports, clippy::unwrap_used, clippy::panic)]

mod metrics;
mod recorded;
mod run;
mod simulated;
mod truth;
mod world;

pub use recorded::recorded;
pub use run::{Mode, Outcome, Setup, run};
pub use simulated::{simulated, simulated_scan};
pub use truth::truth;
pub use world::{Hall, hall};

use rumbo_kit::lines::SensedLine;

/// Between two steps, seconds.
pub const BASE_S: f64 = 0.05;
/// Steps of 60 seconds, with the first.
pub const N_STEPS: usize = 1201;
/// Steps from one scan to the next.
pub const SCAN_EVERY: usize = 10;

/// What the sensors say at one step.
#[derive(Debug, Clone, Default)]
pub struct Step {
    /// Left and right wheel, m/s.
    pub wheels: Option<[f64; 2]>,
    /// Steering angle, radians.
    pub steering: Option<f64>,
    /// Lines of a scan.
    pub lines: Option<Vec<SensedLine>>,
    /// x, y, theta in truth, where it is known.
    pub truth: Option<[f64; 3]>,
}
