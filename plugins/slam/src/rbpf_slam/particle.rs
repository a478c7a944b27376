//! One guess of the robot's way, and the map that belongs to it.

use super::follower::Followed;
use super::proposal::{LEAST_FLOOR, Proposal, SAMPLED_FLOOR, coordinates, difference};
use super::settings::{FilterSettings, ProposalRule};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_core::rng::{Rng, RngExt as _};
use rumbo_kit::scan_match::{
    Linearized, MatchStatus, PosePrior, ScanMatch, ScanPoints, linearize, match_scan,
};
use rumbo_kit::tile_map::{LevelView, TileMap};

/// What speaks against a scan being where the robot was followed to; each is also what comes before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Doubt {
    /// Nothing.
    None,
    /// Nothing ties it to the scans before: only a match that nobody can doubt counts.
    Untied,
    /// The robot was lost, and that it was found is not proven: nothing is drawn.
    Unproven,
    /// The robot is lost: what does not match is not weighed.
    Lost,
}

/// A scan as the filter gets it.
#[derive(Debug, Clone)]
pub struct KeyScan<'a> {
    /// As it was seen.
    pub scan: &'a LaserScan,
    /// From where.
    pub base_from_sensor: Pose3,
    /// Its points in the base frame.
    pub points: &'a ScanPoints,
    /// The step since the last scan that the filter took in, as the robot was followed.
    pub followed: Followed,
    /// Draw it into the map although it overlaps with it too little to be matched.
    pub explores: bool,
    /// How sure it is that it belongs there.
    pub doubt: Doubt,
}

/// One guess.
#[derive(Debug, Clone)]
pub struct Particle {
    /// Where the robot is.
    pub map_from_base: Pose2,
    /// Since particles were drawn anew.
    pub ln_weight: f64,
    /// Since the beginning.
    pub ln_total: f64,
    /// Its map.
    pub map: TileMap,
}

/// What the scan was to a particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Looked {
    /// Whether it was matched.
    pub status: MatchStatus,
    /// The scan belongs into the map.
    pub is_drawn: bool,
    /// What the scan says of x, y, yaw; what it does not see is the step's.
    pub covariance: Matrix3<f64>,
    /// The particle's step.
    pub before_from_after: Pose2,
}

/// A match with a map, judged.
fn matched(
    map: &TileMap,
    key: &KeyScan<'_>,
    prior: &PosePrior,
    settings: &FilterSettings,
) -> Option<(ScanMatch, MatchStatus)> {
    let views: Vec<LevelView<'_>> = map.views();
    let found = match_scan(&views, key.points, &prior.map_from_base, Some(prior), &settings.matching)?;
    let mut status = settings.gate.judge(&found, &prior.map_from_base);
    let needs_proof = key.doubt >= Doubt::Untied;
    let least = if needs_proof { SURE_SCORE.max(settings.minimum_score) } else { settings.minimum_score };
    let is_doubtful = needs_proof && (status == MatchStatus::Degenerate || found.known() < SURE_KNOWN);
    if status.is_match() && (found.end.mean_value() < least || is_doubtful) {
        status = MatchStatus::Diverged;
    }
    Some((found, status))
}

/// Where proof is needed, matches of this mean value are believed, ...
const SURE_SCORE: f64 = 0.65;
/// ... of which this share lies on cells that some scan has touched.
const SURE_KNOWN: f64 = 0.8;

/// The step as the robot was followed, from here, as a prior of a match.
fn prior_of(map_from_before: &Pose2, followed: &Followed, settings: &FilterSettings) -> PosePrior {
    let covariance = followed.covariance_in(map_from_before);
    PosePrior {
        map_from_base: map_from_before * followed.before_from_after,
        information: covariance.try_inverse().unwrap_or_else(Matrix3::identity),
        residual_variance: settings.likelihood_variance,
    }
}

/// Logarithm of how probable a scan is that was looked up in a map. A point beside the map says as much as one on cells
/// that nobody has seen.
fn ln_likelihood(looked: &Linearized, n_points: usize, variance: f64) -> f64 {
    const UNKNOWN_COST: f64 = 0.25;
    let n_beside = n_points.saturating_sub(looked.n_used) as f64;
    -(looked.cost + UNKNOWN_COST * n_beside) / (2.0 * variance)
}

impl Particle {
    /// Moves by what the follower and the scan on its own map say, and weighs itself.
    pub fn look(&mut self, key: &KeyScan<'_>, settings: &FilterSettings, rng: &mut Rng) -> Looked {
        let before = self.map_from_base;
        let prior = prior_of(&before, &key.followed, settings);
        let found = matched(&self.map, key, &prior, settings);
        if let Some((found, status)) = &found
            && status.is_match()
            && let Some(proposal) = self.propose(found, &prior, key.points, settings, rng)
        {
            let is_sampled = settings.proposal == ProposalRule::Sampled;
            let floor = if is_sampled { SAMPLED_FLOOR } else { LEAST_FLOOR };
            self.map_from_base = proposal.draw(floor, rng);
            self.add_weight(proposal.ln_weight);
            let before_from_after = before.inverse() * self.map_from_base;
            let both = || (found.covariance.try_inverse()? + prior.information).try_inverse();
            let with_prior = if found.seen.is_complete() { None } else { both() };
            return Looked {
                status: *status,
                is_drawn: key.doubt < Doubt::Unproven,
                covariance: with_prior.unwrap_or(found.covariance),
                before_from_after,
            };
        }
        let status = found.map_or(MatchStatus::TooFewPoints, |(_, status)| status);
        let covariance = key.followed.covariance_in(&before);
        let guess = Proposal { mean: coordinates(&prior.map_from_base), covariance, ln_weight: 0.0 };
        self.map_from_base = guess.draw(LEAST_FLOOR, rng);
        if let (Some(finest), false) =
            (self.map.finest(), status == MatchStatus::TooFewPoints || key.doubt == Doubt::Lost)
        {
            let looked = linearize(&LevelView::new(finest), key.points, &self.map_from_base);
            self.add_weight(ln_likelihood(&looked, key.points.len(), settings.likelihood_variance));
        }
        let is_drawn = status == MatchStatus::LowOverlap && key.explores;
        let before_from_after = before.inverse() * self.map_from_base;
        Looked { status, is_drawn, covariance, before_from_after }
    }

    fn add_weight(&mut self, ln: f64) {
        self.ln_weight += ln;
        self.ln_total += ln;
    }

    fn propose(
        &self,
        found: &ScanMatch,
        prior: &PosePrior,
        points: &ScanPoints,
        settings: &FilterSettings,
        rng: &mut Rng,
    ) -> Option<Proposal> {
        let mode = coordinates(&found.map_from_base);
        let variance = settings.likelihood_variance;
        if settings.proposal == ProposalRule::Curvature {
            let ln = ln_likelihood(&found.end, points.len(), variance);
            let away = difference(&prior.map_from_base, &found.map_from_base);
            let evidence = found.end.hessian / variance;
            return Proposal::of_curvature(&mode, ln, &evidence, &prior.information, &away);
        }
        let [way_m, turn_rad] = settings.proposal_range;
        let finest = LevelView::new(self.map.finest()?);
        let mut try_one = || {
            let mut within = |most: f64| most * rng.random_range(-1.0..=1.0);
            mode + Vector3::new(within(way_m), within(way_m), within(turn_rad))
        };
        let samples: Vec<Vector3<f64>> = (0..settings.proposal_samples).map(|_| try_one()).collect();
        let poses = || samples.iter().map(|sample| pose2(sample.x, sample.y, sample.z));
        let of_scan = |pose: Pose2| ln_likelihood(&linearize(&finest, points, &pose), points.len(), variance);
        let of_motion = |pose: Pose2| {
            let away = difference(&prior.map_from_base, &pose);
            -0.5 * away.dot(&(prior.information * away))
        };
        let ln_scan: Vec<f64> = poses().map(of_scan).collect();
        let ln_motion: Vec<f64> = poses().map(of_motion).collect();
        Proposal::of_samples(&mode, &samples, &ln_scan, &ln_motion)
    }
}
