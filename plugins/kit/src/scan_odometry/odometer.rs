//! From scans to a way: which scan is the key, and what happens when a match fails.

use super::key_scan::KeyScan;
use super::points::ScanPoints;
use super::registration::{MatchStatus, PosePrior, Registrar, Registration, numbers};
use super::settings::ScanOdometrySettings;
use crate::compounded::compounded;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;

/// What one scan did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanStep {
    /// The base where this scan was made, seen from where it was for the scan before.
    pub last_from_base: Pose2,
    /// The match.
    pub matched: Registration,
    /// This scan is the key scan now.
    pub is_key: bool,
}

/// Adds up where the base is from scan to scan.
#[derive(Debug, Clone)]
pub struct ScanOdometer {
    settings: ScanOdometrySettings,
    points: ScanPoints,
    key: KeyScan,
    registrar: Registrar,
    odom_from_key: Pose2,
    /// Of `odom_from_key`.
    key_covariance: Matrix3<f64>,
    key_from_base: Pose2,
    /// Of `key_from_base`.
    covariance: Matrix3<f64>,
    /// Matches that failed in a row.
    n_failed: u32,
    /// Places to begin from, with how many points are near there.
    far: Vec<(usize, Vector3<f64>)>,
}

/// So many failures in a row, and the scan begins anew as the key: what the old one shows is not here any more.
const FAILURES_TO_NEW_KEY: u32 = 2;

impl ScanOdometer {
    /// At this pose, with this covariance of x, y, yaw.
    pub fn new(
        settings: ScanOdometrySettings,
        odom_from_base: Pose2,
        covariance: Matrix3<f64>,
    ) -> ScanOdometer {
        ScanOdometer {
            settings,
            points: ScanPoints::default(),
            key: KeyScan::default(),
            registrar: Registrar::default(),
            odom_from_key: odom_from_base,
            key_covariance: covariance,
            key_from_base: Pose2::identity(),
            covariance: Matrix3::zeros(),
            n_failed: 0,
            far: Vec::new(),
        }
    }

    /// Where the base was for the last scan.
    pub fn odom_from_base(&self) -> Pose2 {
        self.odom_from_key * self.key_from_base
    }

    /// Covariance of x, y, yaw of that, in the odometer's axes.
    pub fn covariance(&self) -> Matrix3<f64> {
        compounded(&self.key_covariance, &self.odom_from_key, &self.key_from_base, &self.covariance)
    }

    /// Matches that failed in a row.
    pub fn n_failed(&self) -> u32 {
        self.n_failed
    }

    /// Takes in the next scan. `step` is how the base probably moved since the last one, with the covariance of its x, y,
    /// yaw: the match begins there, and where the scan says nothing, it stands.
    pub fn take(
        &mut self,
        scan: &LaserScan,
        base_from_sensor: &Pose3,
        step: &Pose2,
        step_covariance: &Matrix3<f64>,
    ) -> ScanStep {
        self.take_placed(|points| points.place(scan, base_from_sensor), step, step_covariance)
    }

    /// The same for points that are placed otherwise.
    pub fn take_placed(
        &mut self,
        place: impl FnOnce(&mut ScanPoints),
        step: &Pose2,
        step_covariance: &Matrix3<f64>,
    ) -> ScanStep {
        let (matched, _) = self.look(place, &self.prior(step, step_covariance), None);
        self.settle(&matched, &matched.key_from_base, &matched.covariance)
    }

    /// Where points were seen, from where the base probably is in the key scan's frame: also from a second opinion, which
    /// counts (and is told) where clearly more points support it. Nothing is taken in yet.
    pub fn look(
        &mut self,
        place: impl FnOnce(&mut ScanPoints),
        first: &PosePrior,
        other: Option<&PosePrior>,
    ) -> (Registration, bool) {
        place(&mut self.points);
        let matched = self.best(first);
        let again = other.map(|other| self.best(other));
        match again.filter(|again| again.is_better_than(&matched, LEAST_GAIN_OF_OTHER)) {
            Some(again) => (again, true),
            None => (matched, false),
        }
    }

    /// Takes in the scan that was looked at, as made at this pose in the key scan's frame.
    pub fn settle(
        &mut self,
        matched: &Registration,
        key_from_base: &Pose2,
        covariance: &Matrix3<f64>,
    ) -> ScanStep {
        let before = std::mem::replace(&mut self.key_from_base, *key_from_base);
        self.covariance = *covariance;
        self.n_failed = if matched.status.is_good() { 0 } else { self.n_failed.saturating_add(1) };
        let is_key = self.points.len() >= self.settings.min_points && self.wants_key(matched.overlap);
        if is_key {
            self.begin_key();
        }
        ScanStep { last_from_base: before.inverse() * key_from_base, matched: *matched, is_key }
    }

    /// Where the base was for the last scan, in the key scan's frame.
    pub fn key_from_base(&self) -> Pose2 {
        self.key_from_base
    }

    /// Moves all that was seen so far.
    pub fn shift_key(&mut self, odom_from_key: Pose2) {
        self.odom_from_key = odom_from_key;
    }

    /// Where the key scan was made.
    pub fn odom_from_key(&self) -> Pose2 {
        self.odom_from_key
    }

    fn prior(&self, step: &Pose2, step_covariance: &Matrix3<f64>) -> PosePrior {
        PosePrior {
            key_from_base: self.key_from_base * step,
            covariance: compounded(&self.covariance, &self.key_from_base, step, step_covariance),
        }
    }

    fn wants_key(&self, overlap: f64) -> bool {
        let step = numbers(&self.key_from_base);
        self.key.len() < self.settings.min_points
            || self.n_failed >= FAILURES_TO_NEW_KEY
            || self.n_failed == 0
                && (step.xy().norm() > self.settings.key_distance_m
                    || step.z.abs() > self.settings.key_angle_rad
                    || overlap < self.settings.key_overlap)
    }

    fn begin_key(&mut self) {
        self.key_covariance = self.covariance();
        self.odom_from_key = self.odom_from_base();
        self.key_from_base = Pose2::identity();
        self.covariance = Matrix3::zeros();
        self.n_failed = 0;
        self.key.take(&self.points, &self.settings);
    }

    /// The match from the prior; where that fails, the one from where the base was or from other directions that most points
    /// support.
    fn best(&mut self, prior: &PosePrior) -> Registration {
        let Self { registrar, key, points, settings, key_from_base, far, .. } = self;
        let first = registrar.register(key, points, prior, settings);
        let is_fine = first.status.is_good() && first.support >= settings.retry_support;
        let is_hopeless = key.len() < settings.min_points || points.len() < settings.min_points;
        if is_fine || is_hopeless || settings.n_retries == 0 {
            return first;
        }
        let (mut best, start) = (first, numbers(&prior.key_from_base));
        for turn_rad in both_sides(settings.n_retries, settings.retry_step_rad) {
            let turned = start + Vector3::z() * turn_rad;
            let again = registrar.register_from(key, points, (turned, &prior.key_from_base), prior, settings);
            best.give_way_to(again);
        }
        if settings.far_retries == 0 {
            return best;
        }
        // What was predicted may be all wrong: the base may have stopped, been turned, or a stamp was late.
        let last = numbers(key_from_base);
        far.clear();
        if !best.status.is_good() {
            let turns = both_sides(settings.far_retries * settings.n_retries, settings.retry_step_rad);
            let places = turns.map(|turn_rad| last + Vector3::z() * turn_rad);
            far.extend(places.map(|place| (registrar.n_near(key, points, &place, settings), place)));
            far.sort_unstable_by_key(|(n_near, _)| std::cmp::Reverse(*n_near));
        }
        for place in [last].into_iter().chain(far.iter().take(MOST_FAR).map(|(_, place)| *place)) {
            let near = pose2(place.x, place.y, place.z);
            let again = registrar.register_from(key, points, (place, &near), prior, settings);
            if again.support >= LEAST_FAR_SUPPORT
                && (again.status == MatchStatus::Ok || !settings.far_sees_all)
            {
                best.give_way_to(again);
            }
        }
        best
    }
}

/// Turns to both sides alternately, nearest first, radians.
fn both_sides(n: usize, step_rad: f64) -> impl Iterator<Item = f64> {
    (1..=n).flat_map(move |k| [-1.0, 1.0].map(|side| side * k as f64 * step_rad))
}

/// So many of them, those that have most points near, are followed to their ends.
const MOST_FAR: usize = 4;

/// What is found there must be supported by so many of the points.
const LEAST_FAR_SUPPORT: f64 = 0.4;

/// Another start must find so much more support: in a corridor all are alike.
const LEAST_GAIN: f64 = 0.1;

/// A second opinion must find so much more.
const LEAST_GAIN_OF_OTHER: f64 = 0.02;

impl Registration {
    fn give_way_to(&mut self, other: Registration) {
        let least_gain = if self.status.is_good() { LEAST_GAIN } else { 0.0 };
        if other.is_better_than(self, least_gain) {
            *self = other;
        }
    }

    fn is_better_than(&self, other: &Registration, least_gain: f64) -> bool {
        self.status.is_good() && (!other.status.is_good() || self.support > other.support + least_gain)
    }
}

impl MatchStatus {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            MatchStatus::Ok => "ok",
            MatchStatus::Degenerate => "degenerate",
            MatchStatus::TooFewPoints => "too few points",
            MatchStatus::LowOverlap => "low overlap",
            MatchStatus::Diverged => "diverged",
        }
    }
}
