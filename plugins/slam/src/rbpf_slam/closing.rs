//! Where has the robot come back to? What was seen lately is laid on what was seen there before, wherever it may fit.
//!
//! Some tens of guesses cannot cover how far a robot may be off after hundreds of meters, so places are also looked for
//! where no guess is: Olson, "Real-time correlative scan matching" (2009), over as much room as the way may have drifted. A
//! place that could be several is none.

mod places;
mod sheet;

use super::archive::Archive;
use crate::graph_slam::nearest::NearestTable;
use crate::graph_slam::place_search::{Belief, PlaceSearch, apart_from};
use crate::graph_slam::point_table::thinned;
use crate::graph_slam::registration::{Expected, RegistrationSettings, register};
use crate::graph_slam::surface::{Surface, SurfaceLimits, SurfacePoint};
use crate::unseen::SURE_OVERLAP;
use nalgebra::Matrix3;
use places::{TRUSTED_WAY_M, along, around, places_of};
use rumbo_core::frames::Pose2;
use rumbo_kit::correlative::SearchWindow;
use sheet::surfaces;

/// How places are recognized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosingSettings {
    /// Share of the way since a place was seen that the robot may be off.
    pub drift_share: f64,
    /// At most so far is looked, meters; 0 looks nowhere.
    pub most_reach_m: f64,
    /// Places that fit less are none, 0 to 1.
    pub least_score: f64,
    pub(crate) limits: SurfaceLimits,
    pub(crate) registration: RegistrationSettings,
    pub(crate) least_overlap: f64,
    pub(crate) least_agreement: f64,
}

impl ClosingSettings {
    fn reach_m(&self, way_m: f64) -> f64 {
        (LEAST_REACH_M + self.drift_share * way_m).min(self.most_reach_m)
    }
}

/// A robot that nobody told how far it went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adrift {
    /// The first step that it took so.
    pub since: usize,
    /// Places that it saw before may be so far from where they seem to be, meters.
    pub reach_m: f64,
}

/// A place that the robot has come back to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recognized {
    /// The step that saw it first.
    pub place: usize,
    /// The newest step, seen from there.
    pub place_from_here: Pose2,
    /// What the pairs of points say of x, y, turn, in the axes of the place.
    pub information: Matrix3<f64>,
    score: f64,
}

/// At least so far is looked, meters.
const LEAST_REACH_M: f64 = 1.0;
/// Where the robot believes that it is, places up to so far away are those that it must see, meters; it is looked for so
/// near, meters and radians.
const KNOWN_PLACES_M: f64 = 3.0;
const KNOWN_REACH: [f64; 2] = [0.4, 0.1];
/// So far to each side turned, radians.
const REACH_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// A place elsewhere must fit less than this share of the best one.
const MOST_RIVAL: f64 = 0.9;
/// Steps that what was seen lately consists of.
const N_LATELY: usize = 12;
/// After so many nodes a search gives up.
const MOST_NODES: usize = 400_000;

/// Looks for places, and keeps its memory.
#[derive(Debug, Default)]
pub struct Closing {
    search: PlaceSearch,
    table: NearestTable,
}

impl Closing {
    /// The place of an earlier visit that fits best what the robot has seen lately, among those that may be here although
    /// only a long way leads to them; `way` is where the robot was at all steps.
    pub fn find(
        &mut self,
        archive: &Archive,
        way: &[Pose2],
        adrift: Option<Adrift>,
        settings: &ClosingSettings,
    ) -> Option<Recognized> {
        let here = way.len().checked_sub(1)?;
        let mut ways_m = archive.ways_from(here, way);
        let mut reaches_m: Vec<f64> = ways_m.iter().map(|way_m| settings.reach_m(*way_m)).collect();
        if let Some(Adrift { since, reach_m }) = adrift {
            // Nobody knows the way to what was before.
            ways_m.iter_mut().take(since).for_each(|way_m| *way_m = f64::INFINITY);
            let within_m = reach_m.min(settings.most_reach_m);
            reaches_m.iter_mut().take(since).for_each(|reach| *reach = reach.max(within_m));
        }
        let places = places_of(archive, way, &ways_m, &|step| reaches_m.get(step).map_or(0.0, |m| m + 1.0));
        if places.is_empty() {
            return None;
        }
        let since = adrift.map_or(0, |adrift| adrift.since);
        let oldest = way.len().saturating_sub(N_LATELY).max(since);
        let lately = thinned(surfaces(archive, way, oldest..way.len(), here, &settings.limits).into_iter());
        let seen = Seen { archive, way, settings, lately, reaches_m, since };
        // Where the robot believes that it is, it is, unless it fits clearly better elsewhere.
        let known = self.known(&seen);
        let least_score =
            known.map_or(settings.least_score, |known| settings.least_score.max(known.score / MOST_RIVAL));
        let elsewhere = self.elsewhere(&seen, &places, least_score);
        if !elsewhere.is_empty() {
            return without_rival(&elsewhere, way);
        }
        // A place that only a long way leads to is one only if there is none like it as far as the robot may have drifted.
        let known =
            known.filter(|known| ways_m.get(known.place).is_some_and(|way_m| *way_m > TRUSTED_WAY_M))?;
        let window = seen.window(known.place, None, MOST_RIVAL * known.score)?;
        self.look(&seen, known.place, &window, Some(MOST_RIVAL))
    }

    /// What the newest step sees lies, where the robot believes that it is, on what was seen there before this step, and that tells
    /// all directions.
    pub(crate) fn lies_on(
        &mut self,
        surface: &Surface,
        archive: &Archive,
        way: &[Pose2],
        before: usize,
        settings: &ClosingSettings,
    ) -> bool {
        let Some((here, last)) = way.len().checked_sub(1).zip(way.last()) else { return false };
        let off_m = |pose: &Pose2| (pose.translation.vector - last.translation.vector).norm();
        let near =
            way.iter().take(before).map(off_m).enumerate().filter(|(_, off_m)| *off_m <= KNOWN_PLACES_M);
        let Some((place, _)) = near.min_by(|(_, a), (_, b)| a.total_cmp(b)) else { return false };
        let steps = around(archive, way, place).filter(|step| *step < before);
        self.table.fill(surfaces(archive, way, steps, here, &settings.limits).into_iter());
        let expected = Expected {
            reference_from_scan: Pose2::identity(),
            information: Matrix3::zeros(),
            first_gate_m: KNOWN_REACH[0],
            half_at: 1.0,
            shape: surface.shape.as_ref(),
            least_pairs: 0.0,
        };
        register(&self.table, surface, &expected, &settings.registration).is_some_and(|found| {
            let is_near = found.reference_from_scan.translation.vector.norm() <= KNOWN_REACH[0];
            let fits = found.overlap >= settings.least_overlap.max(SURE_OVERLAP)
                && found.agreement >= settings.least_agreement;
            is_near && fits && found.blind.is_none()
        })
    }

    /// Where the robot believes that it is, seen from the earlier visit that it fits best.
    fn known(&mut self, seen: &Seen<'_>) -> Option<Recognized> {
        let mut known: Option<Recognized> = None;
        for place in places_of(seen.archive, seen.way, &along(seen.way), &|_| KNOWN_PLACES_M) {
            let least_score = known.map_or(seen.settings.least_score, |known| known.score);
            let Some(window) = seen.window(place, Some(KNOWN_REACH), least_score) else { continue };
            known = self.look(seen, place, &window, None).or(known);
        }
        known
    }

    /// Places that fit better than this, and those that fit nearly as well as the best of them.
    fn elsewhere(&mut self, seen: &Seen<'_>, places: &[usize], least_score: f64) -> Vec<Recognized> {
        let mut all: Vec<Recognized> = Vec::new();
        let mut least_score = least_score;
        for place in places {
            if least_score >= 1.0 {
                break;
            }
            let Some(window) = seen.window(*place, None, least_score) else { continue };
            if let Some(found) = self.look(seen, *place, &window, Some(MOST_RIVAL)) {
                least_score = least_score.max(MOST_RIVAL * found.score);
                all.push(found);
            }
        }
        all
    }

    /// Lays points on the surroundings of a place; the window is seen from it. With a share, none may fit elsewhere by more.
    fn look(
        &mut self,
        seen: &Seen<'_>,
        place: usize,
        window: &SearchWindow,
        most_rival: Option<f64>,
    ) -> Option<Recognized> {
        let Seen { archive, way, settings, lately, since, .. } = seen;
        // What was seen lately says nothing of itself.
        let steps = around(archive, way, place).filter(|step| place >= *since || step < since);
        let sheet = surfaces(archive, way, steps, place, &settings.limits);
        let ClosingSettings { registration, least_overlap, least_agreement, .. } = **settings;
        let belief = Belief { registration, least_overlap, least_agreement };
        let found = self.search.find(&sheet, lately, window, most_rival, &belief)?;
        Some(Recognized {
            place,
            place_from_here: found.registered.reference_from_scan,
            information: found.registered.information,
            score: found.score,
        })
    }
}

/// What the robot has seen, and how far off it may be.
struct Seen<'a> {
    archive: &'a Archive,
    way: &'a [Pose2],
    settings: &'a ClosingSettings,
    /// From the newest step.
    lately: Vec<SurfacePoint>,
    /// From each step.
    reaches_m: Vec<f64>,
    /// What was seen lately is from this step on.
    since: usize,
}

impl Seen<'_> {
    /// Seen from a place; as wide as the robot may be off where nothing else is said.
    fn window(&self, place: usize, reach: Option<[f64; 2]>, least_score: f64) -> Option<SearchWindow> {
        let [reach_m, reach_rad] =
            reach.or(self.reaches_m.get(place).map(|reach_m| [*reach_m, REACH_RAD]))?;
        Some(SearchWindow {
            grid_from_base: self.way.get(place)?.inverse() * self.way.last()?,
            reach_m,
            reach_rad,
            step_rad: 0.0,
            least_score,
            most_nodes: MOST_NODES,
        })
    }
}

/// The place that fits best, unless another one fits about as well elsewhere on the map.
fn without_rival(places: &[Recognized], way: &[Pose2]) -> Option<Recognized> {
    let map_from_here = |found: &Recognized| Some(way.get(found.place)? * found.place_from_here);
    let best = places.iter().max_by(|a, b| a.score.total_cmp(&b.score))?;
    let here = apart_from(&map_from_here(best)?);
    let is_rival = |other: &Recognized| {
        let is_elsewhere = map_from_here(other).is_some_and(|pose| !here.excludes(&pose));
        is_elsewhere && other.score > MOST_RIVAL * best.score
    };
    (!places.iter().any(is_rival)).then_some(*best)
}
