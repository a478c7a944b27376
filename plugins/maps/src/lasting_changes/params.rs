//! What `[[map_builder]] plugin = "lasting_changes"` takes.

use super::conclusion::{Removal, Rules};
use super::evidence::VisitRules;
use rumbo_core::registry::{Params, Surroundings};
use rumbo_core::stages::BuildError;
use rumbo_kit::occupancy::doubtful_turn;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Corrects a grid that an earlier map builder loads, such as `static_map`, by what several visits have seen: what stands
/// elsewhere becomes part of the map, and what is gone leaves it. One run is one visit. `rumbo map PIPELINE -o MAP.yaml`
/// ends the visit: it writes the corrected map and, beside it, `MAP.yaml.NAME` with what must be remembered, where NAME is
/// that of this map builder; the next visit names that file in `memory`. Other commands write nothing. People who walk about
/// do not become part of the map, nor do those who stand, unless they stand at the same place in several visits in a row.
/// Only the layer `grid` is corrected, and only where the map knows something; wall lines stay as they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LastingChangesParams {
    /// What earlier visits left, relative to the pipeline's folder; without it this is the first visit. The map must be the
    /// one that was saved with it, or the one that the first visit began with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory: Option<PathBuf>,
    /// Visits in a row that must see the same change before it becomes part of the map. A visit that does not see the place
    /// does not count, one that sees it as the map has it begins anew.
    pub confirm_visits: u8,
    /// The grid of this run shows changes of earlier visits that are not yet confirmed, too: planners go around them. They
    /// are not saved.
    pub shows_unconfirmed: bool,
    /// What of the map is removed once visits have seen through it.
    pub removes: RemovalRule,
    /// A visit is sure of a cell after this many scans that end in it, or see through it; each from another pose.
    pub min_scans: u16,
    /// And the first and the last of them are at least this far apart, seconds.
    pub min_duration_s: f64,
    /// A scan counts once the robot has moved this far since the last one that did, meters, ...
    pub scan_distance_m: f64,
    /// ... or has turned this much, degrees.
    pub scan_angle_deg: f64,
    /// Beams count as far as the place of their end has at most this standard deviation, by the covariance of the
    /// estimate, meters: a heading that is not sure shortens them.
    pub max_end_std_m: f64,
    /// Beams count at most this far, meters.
    pub max_range_m: f64,
    /// Scans of which a smaller share of ends lies on or beside what the map shows do not count: the robot is not where
    /// the estimate says, or people stand around it.
    pub min_explained: f64,
    /// A scan farther than this from the estimate in time does not count, seconds: the odometer alone does not carry a pose
    /// that far.
    pub max_pose_age_s: f64,
}

/// What of the map is removed once visits have seen through it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RemovalRule {
    /// Things that a laser met at an earlier visit. Panes of glass stay, which it has seen through ever since.
    #[default]
    SeenBefore,
    /// Whatever the laser sees through: for places without glass, or maps that a laser has made.
    All,
    /// Nothing.
    Nothing,
}

impl Default for LastingChangesParams {
    fn default() -> Self {
        Self {
            memory: None,
            confirm_visits: 3,
            shows_unconfirmed: false,
            removes: RemovalRule::SeenBefore,
            min_scans: 6,
            min_duration_s: 3.0,
            scan_distance_m: 0.05,
            scan_angle_deg: 4.0,
            max_end_std_m: 0.04,
            max_range_m: 8.0,
            min_explained: 0.6,
            max_pose_age_s: 0.2,
        }
    }
}

impl Params for LastingChangesParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, found: &dyn std::fmt::Display, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {found}, expected {expected}")));
            }
        };
        expect(self.confirm_visits > 0, "confirm_visits", &self.confirm_visits, "at least 1");
        expect(self.min_scans > 0, "min_scans", &self.min_scans, "at least 1");
        for (key, value) in [("max_end_std_m", self.max_end_std_m), ("max_range_m", self.max_range_m)] {
            expect(value.is_finite() && value > 0.0, key, &value, "a finite length above 0");
        }
        let at_least_0 = [
            ("min_duration_s", self.min_duration_s),
            ("scan_distance_m", self.scan_distance_m),
            ("scan_angle_deg", self.scan_angle_deg),
            ("max_pose_age_s", self.max_pose_age_s),
        ];
        for (key, value) in at_least_0 {
            expect(value.is_finite() && value >= 0.0, key, &value, "a finite number, 0 or more");
        }
        let is_share = (0.0..=1.0).contains(&self.min_explained);
        expect(is_share, "min_explained", &self.min_explained, "a share from 0 to 1");
        faults
    }

    fn doubts(&self, surroundings: &Surroundings) -> Vec<BuildError> {
        doubtful_turn("scan_angle_deg", self.scan_angle_deg, surroundings.narrowest_view_rad)
            .into_iter()
            .collect()
    }
}

impl LastingChangesParams {
    pub(super) fn visit_rules(&self) -> VisitRules {
        VisitRules { min_scans: self.min_scans, min_duration_s: self.min_duration_s as f32 }
    }

    pub(super) fn rules(&self) -> Rules {
        let removal = match self.removes {
            RemovalRule::SeenBefore => Removal::SeenBefore,
            RemovalRule::All => Removal::All,
            RemovalRule::Nothing => Removal::Nothing,
        };
        Rules { confirm_visits: self.confirm_visits, removal }
    }
}
