//! One scan: the robot is followed to it, and the filter takes it in where that is due.

use super::Tracker;
use super::estimate::SCANLESS_S;
use crate::graph_slam::registration::Registered;
use crate::graph_slam::surface::Surface;
use crate::rbpf_slam::filter::Outcome;
use crate::rbpf_slam::follower::is_degenerate;
use crate::rbpf_slam::motion::Step;
use crate::rbpf_slam::particle::{Doubt, KeyScan};
use crate::unseen::{KNOWN_M, Told, is_unsure, kept, not_sharper};
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{LaserScan, Observation};
use rumbo_core::time::Time;
use rumbo_kit::scan_match::{Observability, drawn_along};

/// Share of the way from step to step after which the filter takes in what may show a robot again where it is.
const SOON: f64 = 0.2;
/// Of scans in a row that fit nowhere every so many is matched by all particles.
const LOOK_EVERY: u32 = 5;

impl Tracker {
    pub(super) fn take_scan(&mut self, observation: &Observation, scan: &LaserScan) -> bool {
        let stamp = observation.stamp;
        let step = self.step_to(stamp);
        self.counters.scans += 1;
        self.filter.settings().preparation.prepare(scan, &observation.base_from_sensor, &mut self.points);
        self.since_step = self.since_step.then(&step);
        let before = self.step_from_base;
        let surface = self.follower.surface(scan, &observation.base_from_sensor);
        let placed = self.follow(&surface, &step);
        let moved = before.inverse() * self.step_from_base;
        let (known, blind) = (self.covariance, self.blind(&surface, placed.as_ref()));
        self.way_unmatched_m += moved.translation.vector.norm();
        let is_due = self.is_due(stamp, placed.is_some(), blind.is_none());
        if is_due {
            self.take_step(observation, scan, surface, placed.as_ref(), blind.as_ref());
        } else {
            self.found(placed.is_some());
            self.diary.note(stamp, &self.step_from_base);
        }
        if let Some(blind) = blind.filter(|_| self.odometer.at_scan.is_none()) {
            self.keep_unseen(&blind, &known, stamp);
        }
        if let Some(last) = self.stamp {
            self.odometer.learn_velocity(&moved, (stamp - last).as_secs());
        }
        self.stamp = Some(stamp);
        is_due
    }

    /// Without wheels nobody knows the way that the scan does not show.
    fn keep_unseen(&mut self, blind: &Observability, known: &Matrix3<f64>, stamp: Time) {
        let start_from_scan =
            self.filter.best().map_or(self.step_from_base, |best| best.map_from_base * self.step_from_base);
        let seconds = self.stamp.map_or(0.0, |last| (stamp - last).as_secs());
        let seen = blind.turned(&start_from_scan.rotation);
        self.covariance = kept(&seen, &self.covariance, known, Told::ByNobody { seconds });
        if is_unsure(&self.covariance) {
            self.adrift_since.get_or_insert(self.archive.len());
        }
    }

    /// Directions, in the base frame, that the scan does not tell by what the scans before it know; by itself, where it does not
    /// lie on them.
    fn blind(&self, surface: &Surface, placed: Option<&Registered>) -> Option<Observability> {
        match placed {
            Some(placed) => Some(placed.blind?.turned(&placed.reference_from_scan.rotation.inverse())),
            None => surface.shape.as_ref()?.blind(),
        }
    }

    /// Of a robot that is not lost only those points count that lie on something in the best guess's map.
    fn count_known(&mut self) {
        let Some(best) = self.filter.best() else { return };
        let views = best.map.views();
        if !views.is_empty() {
            let start_from_scan = best.map_from_base * self.step_from_base;
            self.points.count_where(drawn_along(&views, &start_from_scan, KNOWN_M));
        }
    }

    /// The step from the last scan. A robot that for long neither saw nor counted wheels may be anywhere.
    fn step_to(&mut self, stamp: Time) -> Step {
        let had_wheels = self.odometer.at_scan.is_some();
        let step = self.odometer.step_to(stamp, self.stamp);
        let has_wheels = had_wheels && self.odometer.at_scan.is_some();
        let was_blind = self.stamp.is_some_and(|last| (stamp - last).as_secs() > SCANLESS_S);
        if was_blind && !has_wheels {
            self.n_unmatched = self.n_unmatched.max(self.settings.lost_after_scans);
        }
        step
    }

    /// The robot's step as the odometer has it, and then as the last scans have it.
    fn follow(&mut self, surface: &Surface, step: &Step) -> Option<Registered> {
        let motion = &self.settings.motion;
        let covariance = motion.covariance(&self.step_from_base, step);
        let expected = self.step_from_base * step.before_from_after;
        let placed = self.follower.place(surface, &expected, &self.step_from_base, &covariance);
        self.step_from_base = placed.map_or(expected, |placed| placed.reference_from_scan);
        self.counters.degenerate += u64::from(placed.as_ref().is_some_and(is_degenerate));
        placed
    }

    /// A scan that fits nowhere may be rubbish, so it is not taken in unless many are like it.
    fn is_due(&self, stamp: Time, is_placed: bool, sees_all: bool) -> bool {
        if self.filter.lineage().is_empty() {
            return !self.points.is_empty();
        }
        if self.follower.is_empty() {
            return true;
        }
        if self.points.len() < self.settings.filter.gate.min_points {
            return false;
        }
        if !is_placed && self.n_unmatched % LOOK_EVERY == LOOK_EVERY - 1 {
            return true;
        }
        let way_m = self.step_from_base.translation.vector.norm();
        if is_placed
            && sees_all
            && is_unsure(&self.covariance)
            && way_m >= SOON * self.settings.linear_update_m
        {
            // It shows again what the scans before did not.
            return true;
        }
        if is_placed && self.is_lost() {
            // By chance, maybe: the maps have to prove it.
            return true;
        }
        if !is_placed && self.n_unmatched == 0 {
            return false;
        }
        let way = &self.step_from_base;
        let waited_s = (stamp - self.step_stamp).as_secs();
        let settings = &self.settings;
        way.translation.vector.norm() >= settings.linear_update_m
            || way.rotation.angle().abs() >= settings.angular_update_rad
            || settings.temporal_update_s >= 0.0 && waited_s >= settings.temporal_update_s
    }

    /// The filter takes the scan in.
    fn take_step(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        surface: Surface,
        placed: Option<&Registered>,
        blind: Option<&Observability>,
    ) {
        let (was_lost, doubt) = (self.is_lost(), self.doubt(placed));
        let may_draw = doubt < Doubt::Unproven;
        if doubt == Doubt::None && placed.is_some() {
            self.count_known();
        }
        let is_near = self.way_unmatched_m <= self.settings.filter.explore_grace_m;
        let (placed_step, since_step) = (&self.step_from_base, &self.since_step);
        let motion = &self.settings.motion;
        let followed = self.follower.followed(placed_step, placed, since_step, motion, blind);
        let key = KeyScan {
            scan,
            base_from_sensor: observation.base_from_sensor,
            points: &self.points,
            followed,
            explores: is_near && placed.is_some() && may_draw,
            doubt,
        };
        let is_first = self.filter.lineage().is_empty();
        let outcome = self.filter.take(&key);
        self.count(&outcome, is_first);
        let is_matched = outcome.n_matched > 0;
        let is_seen = is_first || is_matched || outcome.best.is_some_and(|best| best.is_drawn);
        let is_drawn = is_seen && may_draw;
        if let (None, true, Some(best)) = (placed, is_matched, &outcome.best) {
            self.step_from_base = best.before_from_after;
        }
        self.prove(was_lost, is_matched, self.step_from_base.translation.vector.norm());
        self.archive.push(scan, &observation.base_from_sensor, is_drawn, &followed);
        if is_matched && blind.is_none() {
            self.meets_known(&surface);
        }
        self.follower.step(&self.step_from_base, is_seen.then_some(surface.points));
        self.diary.step(observation.stamp, &self.step_from_base);
        if is_drawn {
            self.look_for_loops(blind.is_none());
        }
        (self.step_stamp, self.step_from_base) = (observation.stamp, Pose2::identity());
        self.since_step = Step::default();
    }

    fn doubt(&self, placed: Option<&Registered>) -> Doubt {
        if self.is_lost() {
            Doubt::Lost
        } else if self.is_on_trial() {
            Doubt::Unproven
        } else if placed.is_none() && self.may_be_anywhere() {
            Doubt::Untied
        } else {
            Doubt::None
        }
    }

    /// Nothing ties a scan to those before it that does not fit on them: no wheels do, or many in a row do not fit.
    fn may_be_anywhere(&self) -> bool {
        let has_wheels = self.odometer.at_scan.is_some();
        !self.follower.is_empty() && (!has_wheels || self.n_unmatched >= LOOK_EVERY - 1)
    }

    fn count(&mut self, outcome: &Outcome, is_first: bool) {
        self.counters.updates += 1;
        self.counters.resampled += u64::from(outcome.is_resampled);
        self.counters.without_weight += u64::from(outcome.is_degenerate);
        if let Some(looked) = &outcome.best {
            let before = self.covariance;
            self.covariance = looked.covariance;
            if self.adrift_since.is_some() {
                self.covariance = not_sharper(&looked.covariance, &before);
            }
        }
        self.found(is_first || outcome.n_matched > 0);
    }

    fn found(&mut self, is_matched: bool) {
        if is_matched {
            (self.n_unmatched, self.way_unmatched_m) = (0, 0.0);
        } else {
            self.n_unmatched = self.n_unmatched.saturating_add(1);
            self.counters.unmatched += 1;
        }
    }
}
