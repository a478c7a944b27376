//! Keys for the lasting errors of wheels and odometers.

use super::odometer_errors::OdometerModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Errors of the wheels or the odometer that go on all the time, which the filter learns from the walls: how large each may
/// be (standard deviations at the start). What is 0 is not learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OdometerErrorParams {
    /// Share by which distances are counted too long or too short: wheels of another size (k_v).
    pub distance_share: f64,
    /// Share by which turns are counted too far or too little: another track (k_omega).
    pub turn_share: f64,
    /// Turn that is counted for every meter though there is none, degrees per meter: wheels that are not alike (kappa).
    pub turn_deg_m: f64,
    /// Turn that is counted for every second though there is none, degrees per second: a gyroscope (b).
    pub turn_deg_s: f64,
    /// Time by which scans are stamped later than readings of the odometer of the same moment, seconds (tau).
    pub scan_delay_s: f64,
    /// How fast they change: share of those deviations in one second; it grows with the root of the time.
    pub wander: f64,
}

impl Default for OdometerErrorParams {
    fn default() -> Self {
        OdometerErrorParams {
            distance_share: 0.0,
            turn_share: 0.0,
            turn_deg_m: 0.0,
            turn_deg_s: 0.0,
            scan_delay_s: 0.0,
            wander: 0.02,
        }
    }
}

impl OdometerErrorParams {
    /// Keys, values and the most that still is an error and no other robot.
    pub(super) fn limits(&self) -> [(&'static str, f64, f64); 6] {
        [
            ("odometer_errors.distance_share", self.distance_share, 0.3),
            ("odometer_errors.turn_share", self.turn_share, 0.3),
            ("odometer_errors.turn_deg_m", self.turn_deg_m, 30.0),
            ("odometer_errors.turn_deg_s", self.turn_deg_s, 30.0),
            ("odometer_errors.scan_delay_s", self.scan_delay_s, 1.0),
            ("odometer_errors.wander", self.wander, 1.0),
        ]
    }

    /// As numbers of the filter.
    pub(super) fn model(&self) -> OdometerModel {
        let turns = [self.turn_deg_m, self.turn_deg_s].map(f64::to_radians);
        OdometerModel {
            deviations: [self.distance_share, self.turn_share, turns[0], turns[1], self.scan_delay_s],
            wander_per_s: self.wander,
        }
    }
}
