//! Where the robot will be, before a scan says so.

use super::motion::Step;
use super::tracker::{ScanTracker, Tracked};
use crate::unseen::{KNOWN_M, STANDING, Told, is_unsure, kept, not_sharper};
use nalgebra::{Matrix3, Rotation2};
use rumbo_core::frames::Pose2;
use rumbo_core::map::Map;
use rumbo_core::time::Time;
use rumbo_kit::scan_match::{ScanMatch, ScanPoints, ShapePoint, drawn_along, drawn_near, levels_of};

/// Without a scan for so long the robot is not followed any more but reckoned, seconds.
const BLIND_AFTER_S: f64 = 1.0;
/// A robot is where a map shows it if so large a share of what it sees is drawn there.
const LEAST_KNOWN: f64 = 0.9;

impl Tracked {
    /// After this step, by which the covariance has grown.
    pub(super) fn after(&self, step: &Step, grown: &Matrix3<f64>, stamp: Time) -> Tracked {
        let map_from_base = self.map_from_base * step.before_from_after;
        Tracked { stamp, map_from_base, covariance: self.covariance + grown }
    }
}

impl ScanTracker {
    /// The motion from there to a time, and by what the covariance grows with it, in the map's axes.
    pub(super) fn step_to(&self, state: &Tracked, stamp: Time) -> (Step, Matrix3<f64>) {
        let step = self.motion.predict(stamp);
        let axes = in_map(&state.map_from_base);
        (step, axes * step.covariance * axes.transpose())
    }

    /// What is known of the robot at this time: where the last scan had it, and once scans stay away where it must be by now.
    pub(super) fn reckoned(&self, state: &Tracked, now: Time) -> Tracked {
        if let Some((map_from_base, covariance)) = self.pending {
            // Somebody has said where it is, and no scan has come since then.
            return Tracked { map_from_base, covariance, ..*state };
        }
        if (now - state.stamp).as_secs() <= BLIND_AFTER_S {
            return *state;
        }
        let (step, grown) = self.step_to(state, now);
        state.after(&step, &grown, now)
    }

    /// A covariance after a scan. Where nobody tells the way, the map as it is now is kept aside: on what is drawn from then on the
    /// robot finds its way, but not where it is on the rest.
    pub(super) fn known_after(
        &mut self,
        found: &ScanMatch,
        by_scan: &Matrix3<f64>,
        before: &Matrix3<f64>,
        told: Told,
    ) -> Matrix3<f64> {
        let is_met = |levels: &Map| is_on(levels, &self.points, &found.map_from_base);
        if found.seen.is_complete() && self.sure_levels.as_ref().is_some_and(is_met) {
            self.sure_levels = None;
        }
        let last = self.state.filter(|_| self.sure_levels.is_some());
        let by_scan = last.map_or(*by_scan, |last| not_sharper(by_scan, &last.covariance));
        let covariance = kept(&found.seen, &by_scan, before, told);
        let is_blind = !found.seen.is_complete() && !told.by_wheels();
        if is_blind && is_unsure(&covariance) && self.sure_levels.is_none() {
            self.sure_levels = Some(self.levels.clone());
        }
        covariance
    }

    /// What was known before, and who else knows the way since then.
    pub(super) fn told_beside(&self, predicted: &Tracked) -> (Matrix3<f64>, Told) {
        // The prediction has the wheels' errors in it, and what somebody has said.
        let known = (predicted.covariance, Told::ByWheels { deviation_m: 0.0 });
        let Some(state) = self.state.filter(|_| !self.is_put) else { return known };
        if !self.is_by_odometer || !self.motion.hears_wheels(predicted.stamp) {
            let seconds = (predicted.stamp - state.stamp).as_secs();
            return (predicted.covariance, Told::ByNobody { seconds });
        }
        let step = state.map_from_base.inverse() * predicted.map_from_base;
        let stands = step.translation.vector.norm() < STANDING && step.rotation.angle().abs() < STANDING;
        if stands { (state.covariance, known.1) } else { known }
    }
}

/// Most of the scan lies on what is drawn, and that tells all directions.
pub(super) fn is_on(levels: &Map, points: &ScanPoints, map_from_base: &Pose2) -> bool {
    let levels = levels_of(levels);
    let is_known = drawn_near(&levels, map_from_base, KNOWN_M);
    let is_proven = drawn_along(&levels, map_from_base, KNOWN_M);
    let of_place = |[x, y, _]: &[f32; 3]| ShapePoint { at: [*x, *y], normal: None, is_end: false };
    let n_known = points.iter().filter(|point| is_known(&of_place(point))).count();
    let is_told = || points.shape().is_none_or(|shape| shape.proves_where(&is_proven));
    n_known as f64 >= LEAST_KNOWN * points.len() as f64 && is_told()
}

/// Turns covariances of the base's axes into the map's.
fn in_map(map_from_base: &Pose2) -> Matrix3<f64> {
    let mut axes = Matrix3::identity();
    let turn = Rotation2::new(map_from_base.rotation.angle());
    axes.fixed_view_mut::<2, 2>(0, 0).copy_from(turn.matrix());
    axes
}
