//! What `[avoider] plugin = "follow_gap"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Goes for a point ahead on the path, through the gap between obstacles that turns least away from it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FollowGapParams {
    /// The point ahead lies this far along the path, meters. More rounds corners, less follows the path closely.
    #[schemars(range(min = 0.1, max = 5.0))]
    pub look_ahead_m: f64,
    /// Free space wanted at both sides of the hull, meters; where there is no such gap the guard's margin must do.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub side_clearance_m: f64,
    /// Nearer to an obstacle than this the robot goes slower, down to a quarter of its speed, meters from the hull.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub slow_within_m: f64,
    /// Gaps farther off the path's direction than this are none, degrees.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub max_detour_deg: f64,
    /// A robot that gets no nearer to the end of the path for so long asks for another one, seconds.
    #[schemars(range(min = 0.5))]
    pub stuck_after_s: f64,
}

impl Default for FollowGapParams {
    fn default() -> Self {
        Self {
            look_ahead_m: 0.6,
            side_clearance_m: 0.08,
            slow_within_m: 0.3,
            max_detour_deg: 100.0,
            stuck_after_s: 15.0,
        }
    }
}

impl Params for FollowGapParams {
    fn check(&self) -> Vec<BuildError> {
        let ranges = [
            ("look_ahead_m", self.look_ahead_m, 0.1, 5.0),
            ("side_clearance_m", self.side_clearance_m, 0.0, 2.0),
            ("slow_within_m", self.slow_within_m, 0.0, 5.0),
            ("max_detour_deg", self.max_detour_deg, 0.0, 180.0),
            ("stuck_after_s", self.stuck_after_s, 0.5, f64::MAX),
        ];
        let wrong = ranges.into_iter().filter(|(_, found, least, most)| !(least..=most).contains(&found));
        wrong
            .map(|(key, found, least, most)| {
                let up_to = if most < f64::MAX {
                    format!("from {least} to {most}")
                } else {
                    format!("of {least} or more")
                };
                BuildError::at(key, format!("is {found}, expected a number {up_to}"))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_impossible_value_is_named_at_once() {
        let params = FollowGapParams {
            look_ahead_m: 0.0,
            side_clearance_m: f64::NAN,
            stuck_after_s: 0.0,
            ..FollowGapParams::default()
        };
        let keys: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
        assert_eq!(keys, ["look_ahead_m", "side_clearance_m", "stuck_after_s"]);
        assert!(FollowGapParams::default().check().is_empty());
    }
}
