//! What `[[sensor]] plugin = "mark_camera"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::MarkNoise;

/// A camera that recognizes marks, such as bar codes, and measures range and bearing to them. It looks along its mount's
/// x axis; things at the height of its mount that stand before a mark hide it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MarkCameraParams {
    /// Field of view, degrees.
    pub field_of_view_deg: f64,
    /// Marks farther away are not recognized, meters.
    pub max_range_m: f64,
    /// Standard deviation of the range, meters.
    pub range_deviation_m: f64,
    /// Part of that deviation that grows with the range, meters per meter.
    pub range_share: f64,
    /// Standard deviation of the bearing, degrees.
    pub bearing_deviation_deg: f64,
    /// Share of marks in view that are overlooked.
    pub miss_share: f64,
    /// Share of marks that are taken for the one with the number below or above.
    pub wrong_identity_share: f64,
    /// Share of marks that are seen, but not told apart.
    pub unknown_identity_share: f64,
}

impl Default for MarkCameraParams {
    fn default() -> Self {
        Self {
            field_of_view_deg: 60.0,
            max_range_m: 8.0,
            range_deviation_m: 0.05,
            range_share: 0.01,
            bearing_deviation_deg: 1.0,
            miss_share: 0.1,
            wrong_identity_share: 0.0,
            unknown_identity_share: 0.0,
        }
    }
}

impl MarkCameraParams {
    /// The errors of its readings.
    pub(super) fn noise(&self) -> MarkNoise {
        MarkNoise {
            range_m: self.range_deviation_m,
            range_share: self.range_share,
            bearing_rad: self.bearing_deviation_deg.to_radians(),
            miss: self.miss_share,
            wrong_identity: self.wrong_identity_share,
            unknown_identity: self.unknown_identity_share,
        }
    }
}

impl Params for MarkCameraParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, value: f64, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        let view = self.field_of_view_deg;
        expect(view > 0.0 && view <= 360.0, "field_of_view_deg", view, "an angle above 0, up to 360");
        let reach = self.max_range_m;
        expect(reach.is_finite() && reach > 0.0, "max_range_m", reach, "a finite range above 0");
        for (key, value) in [
            ("range_deviation_m", self.range_deviation_m),
            ("range_share", self.range_share),
            ("bearing_deviation_deg", self.bearing_deviation_deg),
        ] {
            expect(value.is_finite() && value >= 0.0, key, value, "a finite number, 0 or more");
        }
        for (key, value) in [
            ("miss_share", self.miss_share),
            ("wrong_identity_share", self.wrong_identity_share),
            ("unknown_identity_share", self.unknown_identity_share),
        ] {
            expect((0.0..=1.0).contains(&value), key, value, "a share from 0 to 1");
        }
        let both = self.wrong_identity_share + self.unknown_identity_share;
        expect(
            both.is_nan() || both <= 1.0,
            "unknown_identity_share",
            self.unknown_identity_share,
            "at most 1 with wrong_identity_share",
        );
        faults
    }
}
