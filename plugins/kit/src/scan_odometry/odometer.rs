//! From scans to a way: which scan is the key, and what happens when a match fails.

use super::key_scan::KeyScan;
use super::points::ScanPoints;
use super::registration::{MatchStatus, PosePrior, Registrar, Registration, numbers};
use super::settings::ScanOdometrySettings;
use crate::compounded::compounded;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3};
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
        self.take_with(scan, base_from_sensor, (step, step_covariance), None)
    }

    /// The same where there is a second opinion of how the base moved: it counts where clearly more points support it.
    pub fn take_with(
        &mut self,
        scan: &LaserScan,
        base_from_sensor: &Pose3,
        (step, step_covariance): (&Pose2, &Matrix3<f64>),
        other: Option<(&Pose2, &Matrix3<f64>)>,
    ) -> ScanStep {
        self.points.place(scan, base_from_sensor);
        let mut matched = self.best(&self.prior(step, step_covariance));
        if let Some((step, step_covariance)) = other {
            let again = self.best(&self.prior(step, step_covariance));
            if again.is_better_than(&matched, LEAST_GAIN_OF_OTHER) {
                matched = again;
            }
        }
        let before = std::mem::replace(&mut self.key_from_base, matched.key_from_base);
        self.covariance = matched.covariance;
        self.n_failed = if matched.status.is_good() { 0 } else { self.n_failed.saturating_add(1) };
        let is_key = self.points.len() >= self.settings.min_points && self.wants_key(&matched);
        if is_key {
            self.begin_key();
        }
        ScanStep { last_from_base: before.inverse() * matched.key_from_base, matched, is_key }
    }

    fn prior(&self, step: &Pose2, step_covariance: &Matrix3<f64>) -> PosePrior {
        PosePrior {
            key_from_base: self.key_from_base * step,
            covariance: compounded(&self.covariance, &self.key_from_base, step, step_covariance),
        }
    }

    fn wants_key(&self, matched: &Registration) -> bool {
        let step = numbers(&matched.key_from_base);
        self.key.len() < self.settings.min_points
            || self.n_failed >= FAILURES_TO_NEW_KEY
            || self.n_failed == 0
                && (step.xy().norm() > self.settings.key_distance_m
                    || step.z.abs() > self.settings.key_angle_rad
                    || matched.overlap < self.settings.key_overlap)
    }

    fn begin_key(&mut self) {
        self.key_covariance = self.covariance();
        self.odom_from_key = self.odom_from_base();
        self.key_from_base = Pose2::identity();
        self.covariance = Matrix3::zeros();
        self.n_failed = 0;
        self.key.take(&self.points, &self.settings);
    }

    /// The match from the prior; where that fails, the one from other directions that most points support.
    fn best(&mut self, prior: &PosePrior) -> Registration {
        let Self { registrar, key, points, settings, .. } = self;
        let first = registrar.register(key, points, prior, settings);
        let is_fine = first.status.is_good() && first.support >= settings.retry_support;
        let is_hopeless = key.len() < settings.min_points || points.len() < settings.min_points;
        if is_fine || is_hopeless {
            return first;
        }
        let (mut best, start) = (first, numbers(&prior.key_from_base));
        for k in 1..=settings.n_retries {
            for side in [-1.0, 1.0] {
                let turned = start + Vector3::z() * (side * k as f64 * settings.retry_step_rad);
                let again = registrar.register_from(key, points, turned, prior, settings);
                if again.is_better_than(&best, LEAST_GAIN) {
                    best = again;
                }
            }
        }
        best
    }
}

/// Another start must find so much more support: in a corridor all are alike.
const LEAST_GAIN: f64 = 0.1;

/// A second opinion must find so much more.
const LEAST_GAIN_OF_OTHER: f64 = 0.02;

impl Registration {
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
