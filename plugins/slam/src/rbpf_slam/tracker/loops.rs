//! A loop that no guess has closed by itself.

use super::Tracker;
use crate::graph_slam::surface::Surface;
use crate::rbpf_slam::archive::{Link, turned_into};
use crate::rbpf_slam::bending::bent;
use crate::rbpf_slam::closing::{Adrift, Recognized};
use crate::rbpf_slam::proposal::coordinates;
use crate::unseen::reach_m;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;

/// Steps from one look for places to the next.
const LOOK_EVERY: usize = 4;
/// What is believed of a recognized place at most, meters and radians.
const LINK_FLOOR: [f64; 2] = [0.02, 0.003];
/// Share of what its pairs of points say that is believed: neighboring points err alike.
const BELIEVED_SHARE: f64 = 0.05;
/// Guesses that are this near (deviations, meters and radians) close the loop by themselves.
const NEAR: [f64; 2] = [0.1, 0.013];
const NEAR_DEVIATIONS: f64 = 2.0;

fn diagonal([way_m, turn_rad]: [f64; 2]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(way_m * way_m, way_m * way_m, turn_rad * turn_rad))
}

impl Tracker {
    /// A robot that did not know its way may see what it saw before that again.
    pub(super) fn meets_known(&mut self, surface: &Surface) {
        let Some(since) = self.adrift_since else { return };
        let way = self.filter.lineage().way_of(self.filter.best_index());
        if self.closing.lies_on(surface, &self.archive, &way, since, &self.settings.closing) {
            self.adrift_since = None;
        }
    }

    /// Looks where the robot has come back to. Where the best guess is too far off to find that by itself, its way is bent,
    /// and all guesses go on from there.
    pub(super) fn look_for_loops(&mut self, sees_all: bool) {
        let n_steps = self.archive.len();
        let is_linked = self.archive.links.last().is_some_and(|link| link.later + LOOK_EVERY > n_steps);
        let looks_back = self.adrift_since.is_some() && sees_all && !is_linked;
        let is_due = looks_back || n_steps.is_multiple_of(LOOK_EVERY);
        if !is_due || self.settings.closing.most_reach_m <= 0.0 {
            return;
        }
        let way = self.filter.lineage().way_of(self.filter.best_index());
        let adrift = self.adrift_since.map(|since| Adrift { since, reach_m: reach_m(&self.covariance) });
        let Some(found) = self.closing.find(&self.archive, &way, adrift, &self.settings.closing) else {
            return;
        };
        let Some(link) = link_of(&found, way.len() - 1) else { return };
        let (Some(place), Some(here)) = (way.get(found.place), way.last()) else { return };
        let guess_from_found = (place.inverse() * here).inverse() * found.place_from_here;
        if is_near(&guess_from_found, &link) {
            self.archive.links.push(link);
        } else if let Some(bent) = bent(&self.archive, &way, &link, &found.place_from_here) {
            self.archive.links.push(link);
            self.filter.settle(bent, &self.archive);
            self.counters.loops += 1;
        }
    }
}

fn link_of(found: &Recognized, later: usize) -> Option<Link> {
    let covariance = (found.information * BELIEVED_SHARE).try_inverse()? + diagonal(LINK_FLOOR);
    let information = turned_into(&found.place_from_here, &covariance.try_inverse()?);
    Some(Link { earlier: found.place, later, information })
}

/// Along what the place tells.
fn is_near(guess_from_found: &Pose2, link: &Link) -> bool {
    let covariance = link.information.try_inverse().unwrap_or_else(Matrix3::identity) + diagonal(NEAR);
    let off = coordinates(guess_from_found);
    let square = covariance.try_inverse().map_or(0.0, |information| off.dot(&(information * off)));
    square < NEAR_DEVIATIONS * NEAR_DEVIATIONS
}
