//! A scan against the key scan.

use super::degeneracy::Split;
use super::key_scan::KeyScan;
use super::matches::Matches;
use super::points::ScanPoints;
use super::settings::ScanOdometrySettings;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2};

/// What became of a match.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatchStatus {
    /// All three numbers of the pose are observed.
    Ok,
    /// Some are the prior's.
    Degenerate,
    /// Too few points to say anything: the pose is the prior.
    TooFewPoints,
    /// Too small a share of the points, or none of the directions: the pose is the prior.
    LowOverlap,
    /// What matched does not fit, or is too far from the prior: the pose is the prior.
    Diverged,
}

impl MatchStatus {
    /// The scan said something.
    pub fn is_good(self) -> bool {
        matches!(self, MatchStatus::Ok | MatchStatus::Degenerate)
    }
}

/// Where the scan was probably made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosePrior {
    /// The base in the frame of the key scan's base.
    pub key_from_base: Pose2,
    /// Covariance of its x, y, yaw.
    pub covariance: Matrix3<f64>,
}

/// A matched scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Registration {
    /// The base in the frame of the key scan's base.
    pub key_from_base: Pose2,
    /// Covariance of its x, y, yaw.
    pub covariance: Matrix3<f64>,
    /// What the scan alone says of them, in the key scan's axes: the inverse of a covariance, and zero along directions that
    /// are not observed.
    pub information: Matrix3<f64>,
    /// What became of the match.
    pub status: MatchStatus,
    /// Share of the points that are matched at the largest distance.
    pub overlap: f64,
    /// Share of the points that are matched at the smallest.
    pub support: f64,
    /// Root of the mean square of residuals, meters.
    pub rms_m: f64,
    /// Steps that it took.
    pub n_iterations: usize,
    /// Which of x, y, yaw are the prior's.
    pub unobserved: [bool; 3],
}

/// Registers scans in memory that is kept.
#[derive(Debug, Clone, Default)]
pub struct Registrar {
    matches: Matches,
}

/// The residuals show the noise of the scan; that of the key scan, which is as large, hides in lines that neighbors share.
const KEY_AND_SCAN: f64 = 2.0;

/// Residuals without any noise tell no more than those of a tenth of a millimeter, m².
const LEAST_VARIANCE_M2: f64 = 1e-8;

/// Share of the largest distance of matches that is near for a first look.
const NEAR_SHARE: f64 = 0.5;

/// Steps with one distance before it is halved.
const STEPS_A_DISTANCE: usize = 3;

/// Longest step, meters and radians: beyond it the lines are not those of the points any more.
const LONGEST_STEP: [f64; 2] = [0.5, 0.3];

impl Registrar {
    /// Where the scan was made, beginning at the prior.
    pub fn register(
        &mut self,
        key: &KeyScan,
        points: &ScanPoints,
        prior: &PosePrior,
        settings: &ScanOdometrySettings,
    ) -> Registration {
        let start = numbers(&prior.key_from_base);
        self.register_from(key, points, (start, &prior.key_from_base), prior, settings)
    }

    /// The same, beginning elsewhere (x, y, yaw), and taken to be a match near this pose only; the prior stands where the scan
    /// says nothing.
    pub fn register_from(
        &mut self,
        key: &KeyScan,
        points: &ScanPoints,
        (start, near): (Vector3<f64>, &Pose2),
        prior: &PosePrior,
        settings: &ScanOdometrySettings,
    ) -> Registration {
        let (mut pose, mut n_iterations, mut within_m) = (start, 0, settings.max_match_m);
        let mut n_with_distance = 0;
        while n_iterations < settings.max_iterations {
            self.matches.find(key, points, &pose, within_m);
            let Some(step) = self.step(settings, within_m) else { break };
            pose += step;
            n_iterations += 1;
            n_with_distance += 1;
            let is_small = step.xy().norm() < settings.converged && step.z.abs() < settings.converged;
            let is_last = within_m <= settings.least_match_m;
            if is_small && is_last {
                break;
            }
            // With a distance this coarse it is enough to be near.
            let is_near = step.xy().norm() < 0.1 * within_m && step.z.abs() < 0.03 * within_m;
            if !is_last && (is_near || n_with_distance >= STEPS_A_DISTANCE) {
                within_m = (0.5 * within_m).max(settings.least_match_m);
                n_with_distance = 0;
            }
        }
        self.judge(key, points, (pose, near), prior, settings, n_iterations)
    }

    /// How many points have a match from this pose (x, y, yaw).
    pub fn n_near(
        &mut self,
        key: &KeyScan,
        points: &ScanPoints,
        pose: &Vector3<f64>,
        settings: &ScanOdometrySettings,
    ) -> usize {
        self.matches.find(key, points, pose, NEAR_SHARE * settings.max_match_m);
        self.matches.len()
    }

    /// One step of Gauss and Newton; none where too few points match.
    fn step(&mut self, settings: &ScanOdometrySettings, within_m: f64) -> Option<Vector3<f64>> {
        if self.matches.len() < settings.min_points {
            return None;
        }
        let equations = self.matches.equations(settings, within_m);
        let step = Split::new(&equations, &settings.degeneracy)?.step(&equations.gradient);
        let share = (LONGEST_STEP[0] / step.xy().norm()).min(LONGEST_STEP[1] / step.z.abs()).min(1.0);
        Some(step * share)
    }

    fn judge(
        &mut self,
        key: &KeyScan,
        points: &ScanPoints,
        (pose, near): (Vector3<f64>, &Pose2),
        prior: &PosePrior,
        settings: &ScanOdometrySettings,
        n_iterations: usize,
    ) -> Registration {
        let n = points.len().max(1) as f64;
        self.matches.find(key, points, &pose, settings.max_match_m);
        let (overlap, rms_m) = (self.matches.len() as f64 / n, self.matches.rms_m(settings.trim));
        let n_common = self.matches.len();
        self.matches.find(key, points, &pose, settings.least_match_m);
        let support = self.matches.len() as f64 / n;
        let failed = |status| Registration {
            key_from_base: prior.key_from_base,
            covariance: prior.covariance,
            information: Matrix3::zeros(),
            status,
            overlap,
            support,
            rms_m,
            n_iterations,
            unobserved: [true; 3],
        };
        if n_common < settings.min_points {
            return failed(MatchStatus::TooFewPoints);
        }
        if overlap < settings.min_overlap {
            return failed(MatchStatus::LowOverlap);
        }
        let away = near.inverse() * pose2(pose.x, pose.y, pose.z);
        let is_far = away.translation.vector.norm() > settings.max_correction_m
            || away.rotation.angle().abs() > settings.max_correction_rad;
        if is_far || rms_m > settings.max_rms_m || self.matches.len() < settings.min_points {
            return failed(MatchStatus::Diverged);
        }
        let equations = self.matches.equations(settings, settings.least_match_m);
        let Some(split) = Split::new(&equations, &settings.degeneracy).filter(Split::observes_any) else {
            return failed(MatchStatus::LowOverlap);
        };
        let free = (equations.n as f64 - 3.0).max(1.0);
        let variance_m2 = KEY_AND_SCAN * self.matches.variance_m2() * equations.n as f64 / free;
        let pose = split.held(&pose, &numbers(&prior.key_from_base));
        let mut covariance = split.covariance(variance_m2, &prior.covariance, &settings.degeneracy);
        for (axis, floor) in [settings.min_std_m, settings.min_std_m, settings.min_std_rad].iter().enumerate()
        {
            covariance[(axis, axis)] += floor * floor;
        }
        let status = if split.observes_all() { MatchStatus::Ok } else { MatchStatus::Degenerate };
        Registration {
            key_from_base: pose2(pose.x, pose.y, pose.z),
            covariance,
            information: split.information(variance_m2.max(LEAST_VARIANCE_M2), &prior.covariance),
            status,
            unobserved: split.unobserved_axes(),
            ..failed(status)
        }
    }
}

/// x, y, yaw of a pose.
pub(super) fn numbers(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}
