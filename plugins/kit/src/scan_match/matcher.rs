//! From a start pose to the best one: coarse levels first, only steps that make it better.

use super::covariance::{CovarianceRule, CovarianceSettings, moved};
use super::level::MatchLevel;
use super::linearized::{Linearized, linearize};
use super::observability::{Observability, ObservabilitySettings};
use super::points::ScanPoints;
use super::step::{PosePrior, step};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;

/// How long to search, and what to believe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchSettings {
    /// Steps tried on the finest level.
    pub finest_iterations: u32,
    /// Steps tried on each other level.
    pub coarse_iterations: u32,
    /// The longest step, cells of the level.
    pub max_step_cells: f64,
    /// The largest turn of a step, radians.
    pub max_step_rad: f64,
    /// A shorter step ends a level, meters.
    pub converge_m: f64,
    /// With a smaller turn, radians.
    pub converge_rad: f64,
    /// A step of so few cells ends a coarse level, too: the next finer one goes on from there anyway.
    pub coarse_converge_cells: f64,
    /// The same on the finest level: for a match that is polished afterwards.
    pub finest_converge_cells: f64,
    /// Coarse levels look at every second, third, ... point where so many are left; 0 looks at all of them.
    pub coarse_points: usize,
    /// Damping of the first step of a level.
    pub first_damping: f64,
    /// Which directions are seen.
    pub observability: ObservabilitySettings,
    /// How sure the answer is.
    pub covariance: CovarianceSettings,
}

impl Default for MatchSettings {
    fn default() -> Self {
        MatchSettings {
            finest_iterations: 8,
            coarse_iterations: 4,
            max_step_cells: 4.0,
            max_step_rad: 0.2,
            converge_m: 1e-4,
            converge_rad: 1e-4,
            coarse_converge_cells: 0.02,
            finest_converge_cells: 0.0,
            coarse_points: 0,
            first_damping: 1e-3,
            observability: ObservabilitySettings::default(),
            covariance: CovarianceSettings::default(),
        }
    }
}

impl MatchSettings {
    /// With less work on coarse levels, which only have to bring the search to where the next finer one finds its way: a third of
    /// the time from a start that is far off, at the same errors.
    pub fn quick() -> MatchSettings {
        MatchSettings { coarse_converge_cells: 0.1, coarse_points: 120, ..MatchSettings::default() }
    }
}

/// Damping beyond which no step will help.
const MOST_DAMPING: f64 = 1e6;
/// Damping below which it changes nothing.
const LEAST_DAMPING: f64 = 1e-9;

/// What came of a match.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanMatch {
    /// The best pose; along directions that the scan does not see it is the prior's, or where the search began.
    pub map_from_base: Pose2,
    /// Of x, y, yaw in the map's axes: what the scan alone says, without the prior.
    pub covariance: Matrix3<f64>,
    /// The finest level at the best pose.
    pub end: Linearized,
    /// The finest level where the search began.
    pub start: Linearized,
    /// What is seen from the best pose.
    pub seen: Observability,
    /// Points of the scan (N).
    pub n_points: usize,
    /// Poses looked at.
    pub n_evaluations: u32,
}

impl ScanMatch {
    /// Share of the points that lie on the map.
    pub fn overlap(&self) -> f64 {
        self.end.n_used as f64 / self.n_points.max(1) as f64
    }

    /// Share of those that lie on cells some scan has touched.
    pub fn known(&self) -> f64 {
        self.end.n_known as f64 / self.end.n_used.max(1) as f64
    }
}

/// Matches points against levels, finest first. None where there is no level.
pub fn match_scan<L: MatchLevel>(
    levels: &[L],
    points: &ScanPoints,
    map_from_start: &Pose2,
    prior: Option<&PosePrior>,
    settings: &MatchSettings,
) -> Option<ScanMatch> {
    let (finest, coarse) = levels.split_first()?;
    let mut search = Search { points, prior, settings, extent_m: points.extent_m(), n_evaluations: 1 };
    let few = (!coarse.is_empty()).then(|| few_of(points, settings.coarse_points)).flatten();
    let start = linearize(finest, points, map_from_start);
    let mut map_from_base = *map_from_start;
    search.points = few.as_ref().unwrap_or(points);
    for level in coarse.iter().rev() {
        let enough_cells = settings.coarse_converge_cells;
        (map_from_base, _) =
            search.descend(level, map_from_base, settings.coarse_iterations, None, enough_cells);
    }
    search.points = points;
    // Without coarse levels the search begins where the first look was.
    let first = coarse.is_empty().then_some(start);
    let (mut map_from_base, mut end) = search.descend(
        finest,
        map_from_base,
        settings.finest_iterations,
        first,
        settings.finest_converge_cells,
    );
    // Coarse levels may lead a good start astray: cells that are large say less than it knew.
    let objective = |look: &Linearized, pose: &Pose2| search.objective(look, start.weight, pose);
    if !coarse.is_empty() && objective(&end, &map_from_base) > objective(&start, map_from_start) {
        (map_from_base, end) = search.descend(
            finest,
            *map_from_start,
            settings.finest_iterations,
            Some(start),
            settings.finest_converge_cells,
        );
    }
    let seen = Observability::of(&end, search.extent_m, &settings.observability);
    let map_from_prior = prior.map_or(*map_from_start, |prior| prior.map_from_base);
    let mut answer = map_from_base;
    if !seen.is_complete() {
        answer = seen.held(&map_from_prior, &map_from_base);
        end = search.look(finest, &answer);
    }
    let mut covariance = settings.covariance.from_curvature(&end, &seen);
    if settings.covariance.rule == CovarianceRule::Sampled {
        covariance = settings.covariance.sampled(finest, points, &answer).1;
        if !seen.is_complete() {
            covariance = seen.with_blind(&covariance, |_| settings.covariance.blind_deviation_m.powi(2));
        }
    }
    let (n_points, n_evaluations) = (points.len(), search.n_evaluations);
    Some(ScanMatch { map_from_base: answer, covariance, end, start, seen, n_points, n_evaluations })
}

/// Every second, third, ... point, so that at least so many are left; none where all of them are needed.
fn few_of(points: &ScanPoints, n_least: usize) -> Option<ScanPoints> {
    let every = points.len().checked_div(n_least).filter(|every| *every > 1)?;
    // Those that are left stand for the others, also against a prior.
    let mut few = ScanPoints::default();
    points.iter().step_by(every).for_each(|[x, y, weight]| few.push(x, y, weight * every as f32));
    few.set_blind(points.blind().copied());
    Some(few)
}

struct Search<'a> {
    points: &'a ScanPoints,
    prior: Option<&'a PosePrior>,
    settings: &'a MatchSettings,
    extent_m: f64,
    n_evaluations: u32,
}

impl Search<'_> {
    fn look<L: MatchLevel>(&mut self, level: &L, map_from_base: &Pose2) -> Linearized {
        self.n_evaluations += 1;
        linearize(level, self.points, map_from_base)
    }

    /// Goes down on one level, by steps that make the mean cost (with a prior: the sum of both) smaller and keep at
    /// least half of the points on the map; a step of less than so many cells is the last.
    fn descend<L: MatchLevel>(
        &mut self,
        level: &L,
        start: Pose2,
        n_iterations: u32,
        first: Option<Linearized>,
        enough_cells: f64,
    ) -> (Pose2, Linearized) {
        let (mut pose, mut here) = (start, first.unwrap_or_else(|| self.look(level, &start)));
        let (n_start, weight) = (here.n_used, here.weight);
        let mut objective = self.objective(&here, weight, &pose);
        let mut damping = self.settings.first_damping;
        let (enough_m, enough_rad) = (
            self.settings.converge_m.max(enough_cells * level.resolution_m()),
            self.settings.converge_rad.max(enough_cells * level.resolution_m() / self.extent_m),
        );
        for _ in 0..n_iterations {
            let Some(change) = self.change(&here, &pose, damping, level.resolution_m()) else { break };
            let is_small = change.xy().norm() < enough_m && change.z.abs() < enough_rad;
            let tried = moved(&pose, &change);
            let there = self.look(level, &tried);
            let tried_objective = self.objective(&there, weight, &tried);
            let is_better = tried_objective < objective && 2 * there.n_used >= n_start;
            if is_better {
                (pose, here, objective) = (tried, there, tried_objective);
                damping = (damping / 10.0).max(LEAST_DAMPING);
            } else {
                damping *= 10.0;
            }
            // Also where a step that small did not help: only rounding decides then.
            if is_small || damping > MOST_DAMPING {
                break;
            }
        }
        (pose, here)
    }

    fn change(&self, here: &Linearized, pose: &Pose2, damping: f64, cell_m: f64) -> Option<Vector3<f64>> {
        let settings = &self.settings.observability;
        let blind = Observability::unless_complete(here, self.extent_m, settings);
        let prior = self.prior.map(|prior| (prior, prior.difference_from(pose)));
        let mut change = step(here, damping, blind.as_ref(), prior)?;
        let too_long = change.xy().norm() / (self.settings.max_step_cells * cell_m);
        if too_long > 1.0 {
            change.x /= too_long;
            change.y /= too_long;
        }
        change.z = change.z.clamp(-self.settings.max_step_rad, self.settings.max_step_rad);
        change.iter().all(|v| v.is_finite()).then_some(change)
    }

    /// Mean cost, or with a prior what the step of both lowers, with the scan's part as if all points of the start counted.
    fn objective(&self, here: &Linearized, weight: f64, pose: &Pose2) -> f64 {
        let Some(prior) = self.prior else { return here.mean_cost() };
        let away = prior.difference_from(pose);
        here.mean_cost() * weight / prior.residual_variance + away.dot(&(prior.information * away))
    }
}
