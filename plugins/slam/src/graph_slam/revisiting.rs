//! A place that was mapped often enough needs no more key frames: a robot on patrol would fill its memory with them, and each
//! optimization would take longer than the one before.

use super::contradiction::View;
use super::loops::{Recognized, frames_of};
use super::point_table::thinned;
use super::registration::Registered;
use super::tracker::Tracker;
use crate::unseen::{SURE_OVERLAP, reach_m};

/// Key frames as near as this are at the same place, meters and radians.
const SAME_PLACE: [f64; 2] = [0.5, 0.35];
/// Key frames this far apart in the order in which they were taken are of different visits.
const VISITS_APART: usize = 20;
/// From the new frame the robot is where it was from the old one, meters and radians: else the graph is not settled there.
const MOST_MOVED: [f64; 2] = [0.1, 0.03];

/// A robot that did not know its way is put right by no more than this where it seems to be, meters and radians.
const MOST_CORRECTED: [f64; 2] = [0.5, 0.1];

impl Tracker {
    /// Instead of a new key frame the robot is seen from an old one, where enough of them are around and the scan surely fits.
    /// Where something has changed it does not, and a new one is added.
    pub(super) fn goes_on_from_known(&mut self, view: &View<'_>) -> bool {
        let Some(place) = self.well_known_place() else { return false };
        let frames = frames_of(&self.atlas, place);
        self.goes_on_from(place, &frames, view, MOST_MOVED)
    }

    /// A robot that did not know its way lies again on what was mapped before, and goes on from there.
    pub(super) fn meets_known(&mut self, view: &View<'_>) -> bool {
        let Some(since) = self.unsure_since else { return false };
        if view.surface.shape.as_ref().is_some_and(|shape| shape.blind().is_some()) {
            return false;
        }
        let here = self.map_from_base().translation.vector;
        let off_m = |frame: &usize| (self.atlas.pose(*frame).translation.vector - here).norm();
        let old = 0..since.min(self.atlas.frames.len());
        let Some(place) = old.min_by(|a, b| off_m(a).total_cmp(&off_m(b))) else { return false };
        let frames: Vec<usize> =
            frames_of(&self.atlas, place).into_iter().filter(|frame| *frame < since).collect();
        let is_met = self.goes_on_from(place, &frames, view, MOST_CORRECTED) || self.finds_known(view, since);
        if is_met {
            self.is_placed_again();
        }
        is_met
    }

    /// Looks for what was mapped before as far around as the robot may be off.
    fn finds_known(&mut self, view: &View<'_>, since: usize) -> bool {
        let reach_m = reach_m(&self.covariance).min(self.settings.loops.most_reach_m);
        let points = thinned(view.surface.iter().copied());
        let here = self.map_from_base();
        let found = self.search.around(&self.atlas, &points, since, (&here, reach_m), &self.settings.loops);
        let Some(Recognized { place, place_from_frame, frames, .. }) = found else { return false };
        self.frame_from_base = self.map_from_frame().inverse() * self.atlas.pose(place) * place_from_frame;
        let is_found = self.goes_on_from(place, &frames, view, MOST_CORRECTED);
        if !is_found {
            self.frame_from_base = self.map_from_frame().inverse() * here;
        }
        is_found
    }

    fn goes_on_from(
        &mut self,
        place: usize,
        place_frames: &[usize],
        view: &View<'_>,
        most_moved: [f64; 2],
    ) -> bool {
        let here = self.map_from_base();
        let (frame, frame_from_base) = (self.front.frame, self.frame_from_base);
        let (frames, frame_reckoned) = (self.front.frames().to_vec(), self.frame_reckoned);
        let covariance = self.covariance;
        let place_from_base = self.atlas.pose(place).inverse() * here;
        self.stand(place, place_from_base, place_frames);
        let tells_all = |found: &Registered| found.blind.is_none() && found.overlap >= SURE_OVERLAP;
        let found = self.surely_placed(view).filter(|found| self.unsure_since.is_none() || tells_all(found));
        if found.is_some() {
            let off = here.inverse() * self.map_from_base();
            if off.translation.vector.norm() <= most_moved[0] && off.rotation.angle().abs() <= most_moved[1] {
                return true;
            }
        }
        self.stand(frame, frame_from_base, &frames);
        (self.frame_reckoned, self.covariance) = (frame_reckoned, covariance);
        false
    }

    /// The nearest key frame here, if it was mapped at enough visits to which a short way through the graph leads.
    fn well_known_place(&self) -> Option<usize> {
        let here = self.map_from_base();
        let off = |frame: usize| {
            let off = here.inverse() * self.atlas.pose(frame);
            (off.translation.vector.norm(), off.rotation.angle().abs())
        };
        let near: Vec<usize> = (0..self.atlas.frames.len())
            .filter(|frame| {
                let (off_m, off_rad) = off(*frame);
                off_m <= SAME_PLACE[0] && off_rad <= SAME_PLACE[1]
            })
            .collect();
        if near.len() < self.settings.most_visits {
            return None;
        }
        let ways = self.atlas.ways_from(self.front.frame, self.settings.tie.trusted_way_m);
        let known: Vec<usize> =
            near.into_iter().filter(|frame| ways.get(*frame).is_some_and(|way| way.is_finite())).collect();
        let n_visits = 1 + known
            .iter()
            .zip(known.iter().skip(1))
            .filter(|(one, next)| *next - *one > VISITS_APART)
            .count();
        let nearest = known.iter().copied().min_by(|a, b| off(*a).0.total_cmp(&off(*b).0))?;
        (n_visits >= self.settings.most_visits).then_some(nearest)
    }
}
