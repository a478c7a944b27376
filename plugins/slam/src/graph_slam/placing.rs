//! Does a scan fit where the robot should be? If not for long, the robot is lost and looks for its place in the whole map.

use super::contradiction::{View, denied_share};
use super::front_end::{Prediction, SURE_FIT};
use super::point_table::thinned;
use super::registration::Registered;
use super::tracker::{Fit, Tracker};
use crate::unseen::{SILENT_S, STANDING, Told, is_unsure, kept, not_sharper};
use nalgebra::Matrix3;
use rumbo_core::time::Time;

/// A robot whose scans fit no better than this for some time is somewhere else.
const POOR_FIT: f64 = 0.6;
/// Nor is one that meets things where the key frame before saw free space, or the other way round: share of what both see.
const MOST_DENIED: f64 = 0.1;
/// A robot that has doubted its place is sure again where no more than this contradicts it.
const SURELY_DENIED: f64 = 0.05;
/// Nor is a place that was searched for in the whole map taken where more does: corners of buildings are alike.
const HARDLY_DENIED: f64 = 0.03;
/// So many scans in a row may fit badly before it takes a good one to be sure again.
const MISSED_BY_CHANCE: u32 = 2;
/// Lost robots look for themselves every so many scans ...
const LOOK_EVERY: u32 = 10;
/// ... this often; then the pause doubles with each look in vain ...
const PATIENT_LOOKS: u32 = 8;
/// ... up to so many times as long.
const LONGEST_PAUSE: u32 = 32;

/// Standard deviation by wheels of a step that scans do not tell, at least, meters, unless the wheels stand.
const STEP_M: f64 = 0.004;

impl Tracker {
    pub(super) fn place(&mut self, view: &View<'_>, prediction: &Prediction) {
        let surface = view.surface;
        if self.atlas.frames.is_empty() {
            self.fit = if surface.len() < self.settings.min_points { Fit::Guessed } else { Fit::Placed };
            return;
        }
        if surface.len() < self.settings.min_points {
            self.left_out.too_few_points += 1;
            self.guess(prediction);
            return;
        }
        // A lost robot would take the next best corridor for the one that it remembers.
        let is_lost = self.fit == Fit::Lost;
        // Nor is what was seen before a long way without scans any help.
        self.is_adrift |= prediction.is_far;
        self.is_doubtful |= prediction.is_blind;
        let found = if is_lost || prediction.is_far {
            None
        } else {
            self.front.place(&self.atlas, surface, prediction)
        };
        if let Some(found) = found {
            self.frame_from_base = found.reference_from_scan;
            self.covariance = self.known_after(&found, prediction);
            let is_told = found.blind.is_none() || self.told_beside(prediction).by_wheels();
            if !is_told && is_unsure(&self.covariance) {
                self.unsure_since.get_or_insert(self.atlas.frames.len());
                self.is_adrift = true;
            }
            // A robot that was carried away must not settle where it fits least badly.
            let (least_fit, most_denied) = if view.is_narrow() {
                (0.0, 1.0)
            } else if self.is_doubtful || self.n_missed > MISSED_BY_CHANCE {
                (SURE_FIT, SURELY_DENIED)
            } else {
                (POOR_FIT, MOST_DENIED)
            };
            let denied_share = self.denied_share(view);
            // A doubt was none when nothing is denied any more.
            let is_fine = !self.is_doubtful && found.fit() >= POOR_FIT && denied_share <= HARDLY_DENIED;
            if is_fine || found.fit() >= least_fit && denied_share <= most_denied {
                self.fit = Fit::Placed;
                (self.n_missed, self.is_doubtful) = (0, false);
                return;
            }
            self.fit = Fit::Guessed;
        } else {
            self.left_out.unplaced += 1;
            self.guess(prediction);
        }
        self.n_missed += 1;
        if self.n_missed >= self.settings.lost_after_scans {
            self.fit = Fit::Lost;
            if self.looks_now() {
                self.look_anywhere(view);
            }
        }
    }

    /// What scan and prediction know together. Along directions that the scan cannot tell nothing corrects the prediction, whose
    /// errors add up.
    fn known_after(&self, found: &Registered, prediction: &Prediction) -> Matrix3<f64> {
        let information = found.information * self.settings.tie.believed_share;
        let [off_m, off_rad] = prediction.deviation;
        let known = nalgebra::Vector3::new(off_m.powi(-2), off_m.powi(-2), off_rad.powi(-2));
        let inverse = (information + Matrix3::from_diagonal(&known)).try_inverse();
        let mut covariance = inverse.unwrap_or(self.covariance);
        if self.unsure_since.is_some() {
            covariance = not_sharper(&covariance, &self.covariance);
        }
        let Some(seen) = &found.blind else { return covariance };
        kept(seen, &covariance, &self.covariance, self.told_beside(prediction))
    }

    /// Who else knows the way since the scan before.
    fn told_beside(&self, prediction: &Prediction) -> Told {
        let since = self.before.map(|before| before.reckoned.stamp);
        let is_heard = |newest: Time| since.is_none_or(|since| (since - newest).as_secs() < SILENT_S);
        if !self.odometry.newest().is_some_and(|(newest, _)| is_heard(newest)) {
            return Told::ByNobody { seconds: prediction.seconds };
        }
        // Without what the prediction is doubted by at least, so that scans can correct it.
        let step_m = prediction.deviation[0] - self.settings.tie.odometer[0];
        let deviation_m = if step_m > STANDING { step_m.hypot(STEP_M) } else { 0.0 };
        Told::ByWheels { deviation_m }
    }

    /// How much of the scan contradicts the key frame that the robot is seen from.
    fn denied_share(&self, view: &View<'_>) -> f64 {
        let Some(frame) = self.atlas.frames.get(self.front.frame) else { return 0.0 };
        denied_share(&frame.view(), view, &self.frame_from_base)
    }

    fn guess(&mut self, prediction: &Prediction) {
        let [off_m, off_rad] = prediction.deviation;
        let more = nalgebra::Vector3::new(off_m.powi(2), off_m.powi(2), off_rad.powi(2));
        self.covariance += Matrix3::from_diagonal(&more);
        if self.fit == Fit::Placed {
            self.fit = Fit::Guessed;
        }
    }

    /// Looks in vain make the pause longer: what did not fit anywhere will hardly fit soon.
    fn looks_now(&self) -> bool {
        let lost_for = self.n_missed.saturating_sub(self.settings.lost_after_scans);
        let pauses = lost_for / LOOK_EVERY;
        lost_for.is_multiple_of(LOOK_EVERY)
            && (pauses < PATIENT_LOOKS || pauses.is_power_of_two() || pauses.is_multiple_of(LONGEST_PAUSE))
    }

    /// A lost robot looks for its place in the whole map.
    fn look_anywhere(&mut self, view: &View<'_>) {
        let points = thinned(view.surface.iter().copied());
        let Some(found) = self.search.anywhere(&self.atlas, &points, &self.settings.loops) else { return };
        let (frame, frame_from_base) = (self.front.frame, self.frame_from_base);
        let (frames, covariance) = (self.front.frames().to_vec(), self.covariance);
        self.stand(found.place, found.place_from_frame, &found.frames);
        if self.surely_placed(view).is_none() {
            self.stand(frame, frame_from_base, &frames);
            self.covariance = covariance;
            return;
        }
        (self.fit, self.n_missed) = (Fit::Placed, 0);
        if self.unsure_since.is_none_or(|since| found.place < since) {
            self.is_placed_again();
        }
        self.is_doubtful = false;
    }

    /// The scan fits where the robot was put, and contradicts nothing: what is alike in parts is not enough.
    pub(super) fn surely_placed(&mut self, view: &View<'_>) -> Option<Registered> {
        let here = Prediction::around(self.frame_from_base);
        let found = self.front.place(&self.atlas, view.surface, &here)?;
        self.frame_from_base = found.reference_from_scan;
        let is_sure = found.fit() >= SURE_FIT && self.denied_share(view) <= HARDLY_DENIED;
        if is_sure {
            self.covariance = self.known_after(&found, &here);
        }
        is_sure.then_some(found)
    }
}
