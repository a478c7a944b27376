//! Where has the robot come back to? What was seen lately is laid on what was seen there before, wherever it may fit.

use super::atlas::{Atlas, TieSettings};
use super::place_search::{Belief, PlaceSearch, apart_from};
use super::point_table::thinned;
use super::surface::SurfacePoint;
use rumbo_core::frames::Pose2;
use rumbo_kit::correlative::SearchWindow;

/// How places are recognized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LoopSettings {
    /// Share of the way through the graph that the place may be off.
    pub drift_share: f64,
    /// At least so far is looked, meters.
    pub least_reach_m: f64,
    /// And at most so far.
    pub most_reach_m: f64,
    /// Turns to each side, radians.
    pub reach_rad: f64,
    /// Places that fit less are none, 0 to 1.
    pub least_score: f64,
    /// A place elsewhere must fit less than this share of the best one.
    pub most_rival: f64,
    /// Frames that what was seen lately consists of.
    pub n_lately: usize,
    /// Places that are looked at for one frame.
    pub most_places: usize,
}

impl LoopSettings {
    /// For a robot that has come a long way by dead reckoning.
    pub fn wide(&self) -> LoopSettings {
        let reach_rad = (2.0 * self.reach_rad).min(std::f64::consts::PI);
        LoopSettings { drift_share: 2.0 * self.drift_share, reach_rad, ..*self }
    }

    fn reach_m(&self, way_m: f64) -> f64 {
        (self.least_reach_m + self.drift_share * way_m).min(self.most_reach_m)
    }
}

const MOST_NODES: usize = 400_000;
/// Frames of a place lie at most this far from its middle, meters, and come at most so many before or after it.
const PLACE_REACH_M: f64 = 4.0;
const PLACE_FRAMES: usize = 15;
/// Places that are this far apart are looked at separately, meters.
const PLACES_APART_M: f64 = 4.0;
/// Frames that nothing ties together are taken to be so far apart, meters.
const NO_WAY_M: f64 = 1e3;

/// Where a frame was taken, as seen from one of an earlier visit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recognized {
    pub place: usize,
    pub place_from_frame: Pose2,
    pub score: f64,
    /// Frames of the place.
    pub frames: Vec<usize>,
}

/// A search for a place of an earlier visit, which can be done a few places at a time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Look {
    /// Frame that is looked for.
    pub frame: usize,
    /// It has come a long way by dead reckoning.
    pub is_wide: bool,
    /// Places that are still to be looked at, with the way that the graph knows to them, meters.
    pub places: Vec<(usize, f64)>,
    /// The best one so far.
    pub best: Option<Recognized>,
}

impl Look {
    /// Among the places that may be here although the graph knows only a long way to them.
    pub fn begin(atlas: &Atlas, frame: usize, is_wide: bool, settings: &LoopSettings) -> Look {
        let settings = if is_wide { settings.wide() } else { *settings };
        let ways_m = atlas.ways_from(frame, f64::INFINITY);
        let here = atlas.pose(frame).translation.vector;
        let mut candidates: Vec<(u64, usize, f64)> = Vec::new();
        for (other, way_m) in ways_m.iter().enumerate() {
            let off_m = (here - atlas.pose(other).translation.vector).norm();
            if *way_m > atlas.settings.trusted_way_m && off_m < settings.reach_m(*way_m) + 1.0 {
                // Where nothing leads to it may be anywhere.
                let way_m = if way_m.is_finite() { *way_m } else { NO_WAY_M };
                candidates.push(((off_m * 1e6) as u64, other, way_m));
            }
        }
        candidates.sort_unstable_by_key(|(off, other, _)| (*off, *other));
        let mut places: Vec<(usize, f64)> = Vec::new();
        for (_, place, way_m) in candidates {
            let at = atlas.pose(place).translation.vector;
            let is_near = |(other, _): &(usize, f64)| {
                (atlas.pose(*other).translation.vector - at).norm() < PLACES_APART_M
            };
            if places.len() < settings.most_places && !places.iter().any(is_near) {
                places.push((place, way_m));
            }
        }
        Look { frame, is_wide, places, best: None }
    }
}

/// Searches places, and keeps its memory.
#[derive(Debug, Default)]
pub(super) struct LoopSearch {
    search: PlaceSearch,
}

impl LoopSearch {
    /// Looks at some of the places that are left; the best of them all is known when none is.
    pub fn go_on(&mut self, atlas: &Atlas, look: &mut Look, settings: &LoopSettings, n_places: usize) {
        let settings = if look.is_wide { settings.wide() } else { *settings };
        let here = atlas.pose(look.frame);
        let lately = lately(atlas, look.frame, settings.n_lately);
        for (place, way_m) in look.places.drain(..n_places.min(look.places.len())).collect::<Vec<_>>() {
            let window = SearchWindow {
                grid_from_base: atlas.pose(place).inverse() * here,
                reach_m: settings.reach_m(way_m),
                reach_rad: settings.reach_rad,
                step_rad: 0.0,
                least_score: look.best.as_ref().map_or(settings.least_score, |best| best.score),
                most_nodes: MOST_NODES,
            };
            let found = self.look(atlas, (place, atlas.frames.len()), &lately, &window, settings.most_rival);
            look.best = found.or_else(|| look.best.take());
        }
    }

    /// The place among the first frames that fits best, as far around here as this.
    pub fn around(
        &mut self,
        atlas: &Atlas,
        lately: &[SurfacePoint],
        n_first: usize,
        (here, reach_m): (&Pose2, f64),
        settings: &LoopSettings,
    ) -> Option<Recognized> {
        let off_m = |pose: &Pose2| (pose.translation.vector - here.translation.vector).norm();
        let mut near: Vec<(f64, usize)> = (0..n_first.min(atlas.frames.len()))
            .map(|place| (off_m(&atlas.pose(place)), place))
            .filter(|(off_m, _)| *off_m <= reach_m)
            .collect();
        near.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut looked_at: Vec<Pose2> = Vec::new();
        let mut best: Option<Recognized> = None;
        for (_, place) in near {
            let pose = atlas.pose(place);
            let is_near =
                |other: &Pose2| (other.translation.vector - pose.translation.vector).norm() < PLACES_APART_M;
            if looked_at.len() == settings.most_places || looked_at.iter().any(is_near) {
                continue;
            }
            looked_at.push(pose);
            let window = SearchWindow {
                grid_from_base: pose.inverse() * here,
                reach_m,
                reach_rad: settings.reach_rad,
                step_rad: 0.0,
                least_score: best.as_ref().map_or(settings.least_score, |best| best.score),
                most_nodes: MOST_NODES,
            };
            best = self.look(atlas, (place, n_first), lately, &window, settings.most_rival).or(best);
        }
        best
    }

    /// The place that fits best of all, wherever the robot may be.
    pub fn anywhere(
        &mut self,
        atlas: &Atlas,
        lately: &[SurfacePoint],
        settings: &LoopSettings,
    ) -> Option<Recognized> {
        let mut looked_at: Vec<Pose2> = Vec::new();
        let mut all: Vec<Recognized> = Vec::new();
        for place in 0..atlas.frames.len() {
            let pose = atlas.pose(place);
            let is_near =
                |other: &Pose2| (other.translation.vector - pose.translation.vector).norm() < PLACES_APART_M;
            if looked_at.iter().any(is_near) {
                continue;
            }
            looked_at.push(pose);
            let window = SearchWindow {
                grid_from_base: Pose2::identity(),
                reach_m: PLACES_APART_M,
                reach_rad: std::f64::consts::PI,
                step_rad: 0.0,
                least_score: settings.least_score,
                most_nodes: MOST_NODES,
            };
            all.extend(self.look(atlas, (place, atlas.frames.len()), lately, &window, settings.most_rival));
        }
        let best = all.iter().max_by(|a, b| a.score.total_cmp(&b.score))?.clone();
        // The same place is found from several frames; another one that fits about as well is a rival.
        let map_from_frame = |found: &Recognized| atlas.pose(found.place) * found.place_from_frame;
        let here = apart_from(&map_from_frame(&best));
        let is_rival = |other: &Recognized| {
            other.score > settings.most_rival * best.score && !here.excludes(&map_from_frame(other))
        };
        (!all.iter().any(is_rival)).then_some(best)
    }

    /// Lays points on the surroundings of a place; the window is that of the place's frame.
    fn look(
        &mut self,
        atlas: &Atlas,
        (place, n_first): (usize, usize),
        lately: &[SurfacePoint],
        window: &SearchWindow,
        most_rival: f64,
    ) -> Option<Recognized> {
        let frames: Vec<usize> =
            frames_of(atlas, place).into_iter().filter(|frame| *frame < n_first).collect();
        let sheet: Vec<SurfacePoint> = atlas.surfaces(frames.iter().copied(), place).collect();
        let TieSettings { registration, least_overlap, least_agreement, .. } = atlas.settings;
        let belief = Belief { registration, least_overlap, least_agreement };
        let found = self.search.find(&sheet, lately, window, Some(most_rival), &belief)?;
        let place_from_frame = found.registered.reference_from_scan;
        Some(Recognized { place, place_from_frame, score: found.score, frames })
    }
}

/// What the last frames saw, from the last of them, thinned; no frames from before the robot had to guess.
fn lately(atlas: &Atlas, frame: usize, n_frames: usize) -> Vec<SurfacePoint> {
    let is_guessed = |other: &usize| atlas.frames.get(*other).is_some_and(|other| other.is_guessed);
    let oldest = (frame + 1).saturating_sub(n_frames);
    let first = (oldest..=frame).rev().find(is_guessed).unwrap_or(oldest);
    thinned(atlas.surfaces(first..frame + 1, frame))
}

/// Frames around a place, of the same visit.
pub(super) fn frames_of(atlas: &Atlas, place: usize) -> Vec<usize> {
    let here = atlas.pose(place).translation.vector;
    let near = |frame: &usize| (atlas.pose(*frame).translation.vector - here).norm() < PLACE_REACH_M;
    let end = (place + PLACE_FRAMES + 1).min(atlas.frames.len());
    (place.saturating_sub(PLACE_FRAMES)..end).filter(near).collect()
}
