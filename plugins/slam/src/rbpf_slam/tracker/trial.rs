//! A lost robot that believes to have found itself has to prove it.

use super::Tracker;

/// It has over this way, meters: a place that is only like it is another one a step further.
const PROOF_WAY_M: f64 = 1.0;

impl Tracker {
    /// It may have found itself, and what it sees is not to be drawn yet.
    pub(in crate::rbpf_slam) fn is_on_trial(&self) -> bool {
        self.proven_m.is_some()
    }

    /// A step of the filter after this way, and whether it matched.
    pub(super) fn prove(&mut self, was_lost: bool, is_matched: bool, way_m: f64) {
        // How it came to where it was found proves nothing.
        let proven_m = if was_lost { Some(0.0) } else { self.proven_m.map(|proven_m| proven_m + way_m) };
        let Some(proven_m) = proven_m else { return };
        self.proven_m = (is_matched && proven_m < PROOF_WAY_M).then_some(proven_m);
        if !is_matched {
            self.n_unmatched = self.n_unmatched.max(self.settings.lost_after_scans);
        }
    }
}
