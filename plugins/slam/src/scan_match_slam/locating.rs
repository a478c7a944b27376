//! Where the robot is by a scan: near the prediction, else near that, else anywhere on the map.

use super::reckoning::is_on;
use super::tracker::{ScanTracker, Tracked};
use crate::unseen::{KNOWN_M, reach_m};
use rumbo_core::frames::Pose2;
use rumbo_kit::scan_match::{
    MatchStatus, PosePrior, ScanMatch, drawn_near, levels_of, levels_within, match_scan,
};

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Located {
    pub found: Option<ScanMatch>,
    pub status: MatchStatus,
    /// The place was searched for: the prediction was wrong.
    pub is_searched: bool,
}

/// When a robot that is lost looks over the whole map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Look {
    /// Somebody said that it may be anywhere: where it was says nothing.
    pub is_anywhere: bool,
    /// Scans until the next look.
    pub wait_scans: u32,
    /// Looks that found no place.
    pub n_in_vain: u32,
}

/// Each look in vain doubles the wait, so many times at most: what did not fit anywhere will hardly fit soon.
const MOST_DOUBLINGS: u32 = 5;

impl ScanTracker {
    /// Matches around the prediction; where that fails, around the best place near it, and of a lost robot anywhere.
    pub(super) fn locate(&mut self, predicted: &Tracked) -> Located {
        let none = |status| Located { found: None, status, is_searched: false };
        if self.points.len() < self.settings.gate.min_points {
            return none(MatchStatus::TooFewPoints);
        }
        let mut status = MatchStatus::LowOverlap;
        if !self.look.is_anywhere {
            let here = self.match_here(predicted);
            // Beyond the largest cells a match ends where it begins to fit: it must stand against the best place around.
            if here.status.is_match() && !self.is_beyond_levels() {
                return self.look_back(predicted, &here).unwrap_or(here);
            }
            status = here.status;
            let near = self.look_near(predicted).filter(|near| !fits_better(&here, near));
            self.counters.found_near += u64::from(near.is_some());
            if let Some(best) = near.or_else(|| here.status.is_match().then_some(here)) {
                return best;
            }
        }
        if self.is_lost() {
            if self.look.wait_scans > 0 {
                self.look.wait_scans -= 1;
            } else if let Some(far) = self.look_everywhere() {
                self.counters.found_anywhere += 1;
                return far;
            }
        }
        none(status)
    }

    fn match_here(&mut self, predicted: &Tracked) -> Located {
        let start = &predicted.map_from_base;
        let within_m = KNOWN_M.max(self.likely_reach_m());
        self.points.count_where(drawn_near(&levels_of(&self.levels), start, within_m));
        let here = self.match_from(start, Some(predicted), self.doubt() * self.likely_reach_m());
        if here.status.is_match() { here } else { self.match_from(start, Some(predicted), f64::INFINITY) }
    }

    fn is_beyond_levels(&self) -> bool {
        let coarsest = self.levels.coarse_grids.last().or(self.levels.grid.as_ref());
        coarsest.is_some_and(|grid| self.likely_reach_m() > grid.resolution_m())
    }

    fn look_near(&mut self, predicted: &Tracked) -> Option<Located> {
        if self.settings.near_reach[0] <= 0.0 {
            return None;
        }
        let reach = self.reach();
        let place = self.places.near(&self.levels, &self.points, &predicted.map_from_base, reach)?;
        self.found_at(&place)
    }

    /// A robot that did not know its way sees something that is not drawn where it may be, but elsewhere as near as that.
    fn look_back(&mut self, predicted: &Tracked, here: &Located) -> Option<Located> {
        let levels = self.sure_levels.clone().filter(|_| here.status == MatchStatus::Degenerate)?;
        let [near_m, turn_rad] = self.settings.near_reach;
        if near_m <= 0.0 || !self.shows_all() {
            return None;
        }
        let reach = [reach_m(&predicted.covariance).clamp(near_m, 4.0 * near_m), turn_rad];
        let place = self.places.near(&levels, &self.points, &predicted.map_from_base, reach)?;
        let back = self.found_at(&place)?;
        back.found.as_ref().filter(|found| is_on(&levels, &self.points, &found.map_from_base))?;
        self.counters.found_near += 1;
        Some(back)
    }

    /// The scan by itself tells all directions.
    pub(super) fn shows_all(&self) -> bool {
        self.points.shape().is_none_or(|shape| shape.blind().is_none())
    }

    fn look_everywhere(&mut self) -> Option<Located> {
        let doublings = self.look.n_in_vain.min(MOST_DOUBLINGS);
        self.look.wait_scans = self.settings.look_every_scans.max(1).saturating_mul(1 << doublings) - 1;
        self.look.n_in_vain += 1;
        let place = self.places.anywhere(&self.levels, &self.points)?;
        self.found_at(&place)
    }

    /// The match at a place that was searched for, if it sees all directions and fits.
    fn found_at(&mut self, place: &Pose2) -> Option<Located> {
        self.points.count_where(|_| true);
        let located = self.match_from(place, None, f64::INFINITY);
        (located.status == MatchStatus::Ok).then_some(Located { is_searched: true, ..located })
    }

    /// How far the robot may be from the guess: more, the longer nothing has matched.
    fn reach(&self) -> [f64; 2] {
        let deviations = self.drift.diagonal().map(|v| v.max(0.0).sqrt());
        let [way, turn] = self.settings.near_reach;
        let most = [4.0 * way, std::f64::consts::PI];
        [(way + 2.0 * deviations.x.max(deviations.y)).min(most[0]), (turn + 2.0 * deviations.z).min(most[1])]
    }

    /// How far the points of the scan may lie from where the prediction puts them, twice its deviation.
    fn likely_reach_m(&self) -> f64 {
        let deviations = self.drift.diagonal().map(|v| v.max(0.0).sqrt());
        let at_points = deviations.z * self.points.extent_m();
        2.0 * deviations.x.max(deviations.y).max(at_points)
    }

    fn match_from(&self, start: &Pose2, predicted: Option<&Tracked>, reach_m: f64) -> Located {
        let prior = predicted.and_then(|predicted| self.prior(predicted));
        let levels = levels_of(&self.levels);
        let mut found = match_scan(
            levels_within(&levels, reach_m),
            &self.points,
            start,
            prior.as_ref(),
            &self.settings.matching,
        );
        let polishing = self.settings.polish.zip(self.surfaces.as_ref()).zip(found.as_mut());
        if let Some(((polish, surfaces), found)) = polishing {
            let covariance = &self.settings.matching.covariance;
            polish.polish(found, surfaces, &self.points, prior.as_ref(), covariance);
        }
        let mut gate = self.settings.gate;
        if predicted.is_some() {
            let deviations = self.drift.diagonal().map(|v| v.max(0.0).sqrt());
            gate.max_correction_m = gate.max_correction_m.max(3.0 * deviations.x.max(deviations.y));
            gate.max_correction_rad = gate.max_correction_rad.max(3.0 * deviations.z);
        }
        let judged = |found: &ScanMatch| match gate.judge(found, start) {
            // Only of what the map knows: new ground is no contradiction.
            status if status.is_match() && found.end.known_cost() > self.settings.max_known_cost => {
                MatchStatus::Diverged
            }
            status => status,
        };
        let status = found.as_ref().map_or(MatchStatus::LowOverlap, judged);
        Located { found, status, is_searched: false }
    }

    /// What the prediction says in the match.
    fn prior(&self, predicted: &Tracked) -> Option<PosePrior> {
        let residual_variance = self.settings.residual_variance?;
        let information = (self.drift * self.doubt().powi(2)).try_inverse()?;
        Some(PosePrior { map_from_base: predicted.map_from_base, information, residual_variance })
    }

    /// Errors of an odometer are alike from scan to scan: counted as if they were not, they add up in the map.
    fn doubt(&self) -> f64 {
        if self.is_by_odometer { self.settings.odometer_doubt } else { 1.0 }
    }
}

/// A match that holds, at no more misfit than the other place.
fn fits_better(here: &Located, other: &Located) -> bool {
    let cost = |located: &Located| located.found.as_ref().map_or(1.0, |found| found.end.known_cost());
    here.status.is_match() && cost(here) <= cost(other)
}
