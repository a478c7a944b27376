//! Whether a match is to be believed.

use super::matcher::ScanMatch;
use super::step::difference;
use rumbo_core::frames::Pose2;

/// What a match is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MatchStatus {
    /// The pose of the match holds.
    Ok,
    /// It holds along some directions; along the others it is the prior's.
    Degenerate,
    /// The scan has too few points: the prior is all there is.
    TooFewPoints,
    /// Too little of what the scan shows is on the map.
    LowOverlap,
    /// The match ran away, or did not find a place that fits.
    Diverged,
}

impl MatchStatus {
    /// The pose of the match is better than the prior.
    pub fn is_match(self) -> bool {
        matches!(self, MatchStatus::Ok | MatchStatus::Degenerate)
    }
}

/// When a match is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchGate {
    /// Fewer points are not matched.
    pub min_points: usize,
    /// Share of the points that must lie on the map.
    pub min_overlap: f64,
    /// Share of those that must lie on cells some scan has touched.
    pub min_known: f64,
    /// The farthest from the prior, meters.
    pub max_correction_m: f64,
    /// The farthest turn from the prior, radians.
    pub max_correction_rad: f64,
    /// The largest mean of `(1 - M)²`.
    pub max_mean_cost: f64,
}

impl Default for MatchGate {
    fn default() -> Self {
        MatchGate {
            min_points: 30,
            min_overlap: 0.5,
            min_known: 0.3,
            max_correction_m: 0.5,
            max_correction_rad: 0.35,
            max_mean_cost: 0.5,
        }
    }
}

impl MatchGate {
    /// Judges a match against the pose that was expected. Differs from the specification: a mean cost that did not fall
    /// refuses nothing, since with a prior the scan's own part may rise while both together fall.
    pub fn judge(&self, found: &ScanMatch, map_from_expected: &Pose2) -> MatchStatus {
        let away = difference(map_from_expected, &found.map_from_base);
        let is_far = away.xy().norm() > self.max_correction_m || away.z.abs() > self.max_correction_rad;
        if found.n_points < self.min_points {
            MatchStatus::TooFewPoints
        } else if found.overlap() < self.min_overlap
            || found.known() < self.min_known
            || found.seen.is_empty()
        {
            MatchStatus::LowOverlap
        } else if is_far || found.end.mean_cost() > self.max_mean_cost {
            MatchStatus::Diverged
        } else if found.seen.is_complete() {
            MatchStatus::Ok
        } else {
            MatchStatus::Degenerate
        }
    }
}
