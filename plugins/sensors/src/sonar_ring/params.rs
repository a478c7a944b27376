//! What `[[sensor]] plugin = "sonar_ring"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A ring of ultrasonic transducers, numbered counter-clockwise from the mount's x axis. The defaults are those of the
/// Nomad Super Scout II in Hernández Alamilla (2005): 16 transducers with cones of 25 degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SonarRingParams {
    /// How many transducers, evenly around the ring.
    pub transducers: u32,
    /// Full opening of a cone, degrees.
    pub cone_deg: f64,
    /// Distance of the transducers from the mount, meters; 0 takes the robot's radius.
    pub ring_radius_m: f64,
    /// Nearer echoes are not heard, meters.
    pub min_range_m: f64,
    /// Reach, meters.
    pub max_range_m: f64,
    /// Standard deviation of the range, meters.
    pub deviation_m: f64,
    /// Share of echoes that are lost.
    pub dropout: f64,
    /// Share of readings in which a transducer takes the ping of a neighbor for its own: it reads half of both ways
    /// together, too short where the neighbor's echo is nearer. Transducers that fire one after the other have none.
    pub crosstalk: f64,
}

impl Default for SonarRingParams {
    fn default() -> Self {
        Self {
            transducers: 16,
            cone_deg: 25.0,
            ring_radius_m: 0.0,
            min_range_m: 0.15,
            max_range_m: 6.5,
            deviation_m: 0.02,
            dropout: 0.0,
            crosstalk: 0.0,
        }
    }
}

/// A ring with more transducers than this is a mistake.
const MOST_TRANSDUCERS: u32 = 360;

impl Params for SonarRingParams {
    fn check(&self) -> Vec<BuildError> {
        let Self {
            transducers,
            cone_deg,
            ring_radius_m,
            min_range_m,
            max_range_m,
            deviation_m,
            dropout,
            crosstalk,
        } = *self;
        let mut faults = Vec::new();
        if !(1..=MOST_TRANSDUCERS).contains(&transducers) {
            faults.push(BuildError::at(
                "transducers",
                format!("is {transducers}, expected 1 to {MOST_TRANSDUCERS}"),
            ));
        }
        let mut expect = |fine: bool, key: &str, value: f64, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        expect(cone_deg > 0.0 && cone_deg <= 180.0, "cone_deg", cone_deg, "an angle above 0, up to 180");
        for (key, value) in
            [("ring_radius_m", ring_radius_m), ("min_range_m", min_range_m), ("deviation_m", deviation_m)]
        {
            expect(value.is_finite() && value >= 0.0, key, value, "a finite length, 0 or more");
        }
        let reach_fits = max_range_m.is_finite() && max_range_m > min_range_m;
        expect(reach_fits, "max_range_m", max_range_m, "a finite range above min_range_m");
        expect((0.0..=1.0).contains(&dropout), "dropout", dropout, "a share from 0 to 1");
        expect((0.0..=1.0).contains(&crosstalk), "crosstalk", crosstalk, "a share from 0 to 1");
        faults
    }
}
