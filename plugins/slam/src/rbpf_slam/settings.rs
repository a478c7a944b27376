//! Numbers of the filter, in the units of the algorithm.

use super::closing::ClosingSettings;
use super::follower::FollowSettings;
use super::motion::MotionNoise;
use rumbo_kit::occupancy::{BeamLimits, Evidence, FreeSpace};
use rumbo_kit::scan_match::{MatchGate, MatchSettings, ScanPreparation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a particle's new pose is drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ProposalRule {
    /// A Gaussian around the match, as narrow as the scan's evidence and the odometer's make it.
    #[default]
    Curvature,
    /// A Gaussian fitted to weighed poses that are tried around the match (Grisetti et al. 2007, equations 15 to 19). With
    /// many beams nearly all of the weight falls on one of the tried poses, so that the answer is as coarse as they are.
    Sampled,
}

/// How the filter takes in a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterSettings {
    /// How many particles.
    pub n_particles: usize,
    /// Edge of the finest cells, meters.
    pub resolution_m: f64,
    /// Levels of each map.
    pub n_levels: u32,
    /// Which readings are matched.
    pub preparation: ScanPreparation,
    /// How the search goes.
    pub matching: MatchSettings,
    /// When a match is believed.
    pub gate: MatchGate,
    /// And the least mean value of the map under the points.
    pub minimum_score: f64,
    /// Variance of one point's `1 - M`.
    pub likelihood_variance: f64,
    /// Where poses are drawn from.
    pub proposal: ProposalRule,
    /// Poses tried by [`ProposalRule::Sampled`].
    pub proposal_samples: usize,
    /// They lie within this of the match, meters and radians.
    pub proposal_range: [f64; 2],
    /// Particles are drawn anew when fewer than this share of them say something.
    pub resample_threshold: f64,
    /// Weights are flattened by this times the number of particles; 0 leaves them.
    pub ogain: f64,
    /// Which readings are drawn into maps.
    pub limits: BeamLimits,
    /// Which cells they free.
    pub free_space: FreeSpace,
    /// How much they say.
    pub evidence: Evidence,
    /// A scan that overlaps little with the map is drawn into it up to this way after the last that did, meters.
    pub explore_grace_m: f64,
}

/// When the filter takes in a scan, and what else there is to decide.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// How.
    pub filter: FilterSettings,
    /// How the robot is followed from scan to scan.
    pub follow: FollowSettings,
    /// How places are recognized.
    pub closing: ClosingSettings,
    /// How much the odometer errs.
    pub motion: MotionNoise,
    /// After this way, meters.
    pub linear_update_m: f64,
    /// Or this turn, radians.
    pub angular_update_rad: f64,
    /// Or this time, seconds; below zero never by time alone.
    pub temporal_update_s: f64,
    /// So many scans in a row that match nothing, and the robot is lost.
    pub lost_after_scans: u32,
    /// Readings of the odometer that are farther apart than this have jumped, meters.
    pub max_odom_jump_m: f64,
    /// The map is written at most once in this time, seconds.
    pub publish_period_s: f64,
    /// It has at most so many cells.
    pub max_cells: u64,
}
