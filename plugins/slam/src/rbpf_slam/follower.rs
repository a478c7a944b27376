//! From scan to scan: where is the robot, as seen from the scan that the filter took in last?
//!
//! Scans are registered on the surfaces of the last few that were taken in. All particles share the answer: it is where their
//! own matches begin, and a far better guess of the robot's step than wheels are.

use super::motion::{MotionNoise, Step};
use super::proposal::difference;
use crate::graph_slam::nearest::NearestTable;
use crate::graph_slam::registration::{Expected, LEAST_PAIRS, Registered, RegistrationSettings, register};
use crate::graph_slam::surface::{Surface, SurfaceLimits, SurfacePoint, Turn};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_kit::scan_match::Observability;
use std::collections::VecDeque;

/// How scans are registered, and when that is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowSettings {
    pub(crate) limits: SurfaceLimits,
    pub(crate) registration: RegistrationSettings,
    /// Scans that the next ones are registered on.
    pub n_recent: usize,
    /// Scans with fewer points say nothing.
    pub min_points: usize,
    /// Share of the information of all pairs that is believed: neighboring points err alike.
    pub believed_share: f64,
    /// The share that guesses are spread by.
    pub spread_share: f64,
    /// Share of a scan's points that must have a partner.
    pub least_overlap: f64,
    /// How well these must agree.
    pub least_agreement: f64,
    /// Turns to each side that the odometer may not have seen, radians.
    pub unseen_turn_rad: f64,
    /// Standard deviation of the odometer along directions that a scan cannot tell, share of the way.
    pub blind_way: f64,
    /// Standard deviations that the answer has at least, meters and radians.
    pub floor: [f64; 2],
}

/// A scan that others are registered on.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// From where it was seen, as seen from the last step.
    pub step_from_base: Pose2,
    pub(crate) surface: Vec<SurfacePoint>,
}

/// The robot's step, and how surely it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// Seen from the step before.
    pub before_from_after: Pose2,
    /// Of x, y, yaw in the axes of the step before.
    pub covariance: Matrix3<f64>,
}

/// The last scans that were taken in.
#[derive(Debug, Clone)]
pub struct Follower {
    settings: FollowSettings,
    pub(super) recent: VecDeque<Kept>,
    table: NearestTable,
}

/// An answer that fits so well is not doubted: overlap times agreement.
const SURE_FIT: f64 = 0.7;
/// Another heading must fit better by this.
const CLEARLY_BETTER: f64 = 0.1;
/// Headings tried to each side.
const N_HEADINGS: i32 = 3;
/// Deviations at which the odometer has half its weight: it may be quite wrong, as when its robot goes backward.
const HALF_AT: f64 = 2.0;
/// Times that it is doubted, and a doubt that makes no difference.
const MOST_DOUBTS: usize = 2;
const LEAST_DOUBT: f64 = 1.5;

/// Factor of the covariance of what was expected, given what was found.
fn doubt(expected: &Pose2, found: &Pose2, covariance: &Matrix3<f64>) -> f64 {
    let off = difference(expected, found);
    let square = covariance.try_inverse().map_or(0.0, |information| off.dot(&(information * off)));
    1.0 + square / (HALF_AT * HALF_AT)
}

impl Follower {
    /// Nothing was seen yet.
    pub fn new(settings: FollowSettings) -> Follower {
        Follower { settings, recent: VecDeque::new(), table: NearestTable::default() }
    }

    /// Its numbers.
    pub fn settings(&self) -> &FollowSettings {
        &self.settings
    }

    /// There is nothing to register scans on.
    pub fn is_empty(&self) -> bool {
        self.recent.is_empty()
    }

    /// Nobody knows where the robot came from.
    pub fn clear(&mut self) {
        self.recent.clear();
        self.fill();
    }

    /// What a scan shows.
    pub(crate) fn surface(&self, scan: &LaserScan, base_from_sensor: &Pose3) -> Surface {
        Surface::of(scan, base_from_sensor, &self.settings.limits)
    }

    /// A step of the filter, from which all is seen from now on; its surface where the scan is in the maps.
    pub(crate) fn step(&mut self, step_from_base: &Pose2, surface: Option<Vec<SurfacePoint>>) {
        let base_from_step = step_from_base.inverse();
        self.recent.iter_mut().for_each(|kept| kept.step_from_base = base_from_step * kept.step_from_base);
        if let Some(surface) = surface {
            self.recent.push_back(Kept { step_from_base: Pose2::identity(), surface });
        }
        while self.recent.len() > self.settings.n_recent {
            self.recent.pop_front();
        }
        self.fill();
    }

    pub(super) fn fill(&mut self) {
        let seen = |kept: &Kept| {
            let turn = Turn::new(&kept.step_from_base);
            kept.surface.iter().map(move |point| point.seen_from(&turn)).collect::<Vec<_>>()
        };
        let points: Vec<SurfacePoint> = self.recent.iter().flat_map(seen).collect();
        self.table.fill(points.into_iter());
    }

    /// Where a scan was seen from, expected here with this covariance; none where that cannot be believed.
    pub(crate) fn place(
        &self,
        surface: &Surface,
        step_from_expected: &Pose2,
        step_from_last: &Pose2,
        covariance: &Matrix3<f64>,
    ) -> Option<Registered> {
        if surface.len() < self.settings.min_points || self.recent.is_empty() {
            return None;
        }
        let expected = self.doubted(surface, step_from_expected, covariance);
        let fit = |found: &Option<Registered>| found.as_ref().map_or(0.0, |f| f.overlap * f.agreement);
        let unseen = self.settings.unseen_turn_rad;
        if fit(&expected) >= SURE_FIT || unseen <= 0.0 {
            return expected.filter(|found| self.is_believed(found));
        }
        // Wheels slip, castors swing around: other headings, and a robot that has not moved.
        let mut wide = *covariance;
        wide[(2, 2)] += (unseen / f64::from(N_HEADINGS)).powi(2);
        let turned = (1..=N_HEADINGS)
            .flat_map(|k| [k, -k])
            .map(|k| step_from_expected * pose2(0.0, 0.0, unseen * f64::from(k) / f64::from(N_HEADINGS)));
        let stayed = surface.start(step_from_expected, step_from_last);
        let others = turned.chain([stayed]).map(|start| self.register(surface, &start, &wide));
        let mut best = (expected, fit(&expected) + CLEARLY_BETTER);
        for found in others {
            if fit(&found) > best.1 {
                best = (found, fit(&found));
            }
        }
        best.0.filter(|found| self.is_believed(found))
    }

    /// A registration whose expectation pulls less the farther the scan lies from it.
    fn doubted(
        &self,
        surface: &Surface,
        step_from_expected: &Pose2,
        covariance: &Matrix3<f64>,
    ) -> Option<Registered> {
        let mut found = self.register(surface, step_from_expected, covariance)?;
        for _ in 0..MOST_DOUBTS {
            let doubt = doubt(step_from_expected, &found.reference_from_scan, covariance);
            if doubt < LEAST_DOUBT {
                break;
            }
            found = self.register(surface, step_from_expected, &(covariance * doubt))?;
        }
        Some(found)
    }

    fn is_believed(&self, found: &Registered) -> bool {
        found.overlap >= self.settings.least_overlap && found.agreement >= self.settings.least_agreement
    }

    fn register(
        &self,
        surface: &Surface,
        step_from_expected: &Pose2,
        covariance: &Matrix3<f64>,
    ) -> Option<Registered> {
        let off_m = covariance[(0, 0)].max(covariance[(1, 1)]).sqrt();
        let off_rad = covariance[(2, 2)].sqrt();
        let expected = Expected {
            reference_from_scan: *step_from_expected,
            information: covariance.try_inverse()? / self.settings.believed_share,
            first_gate_m: (2.0 * off_m + 10.0 * off_rad).clamp(0.3, 0.5),
            half_at: f64::INFINITY,
            shape: surface.shape.as_ref(),
            least_pairs: LEAST_PAIRS,
        };
        register(&self.table, surface, &expected, &self.settings.registration)
    }

    /// The step since the last one that the filter took in: by the registration and the odometer together, or by the
    /// odometer alone.
    pub(crate) fn followed(
        &self,
        step_from_base: &Pose2,
        placed: Option<&Registered>,
        since_step: &Step,
        motion: &MotionNoise,
        blind: Option<&Observability>,
    ) -> Followed {
        let by_odometer = motion.covariance(&Pose2::identity(), since_step);
        let by_odometer = by_odometer * doubt(&since_step.before_from_after, step_from_base, &by_odometer);
        let [off_m, off_rad] = self.settings.floor;
        let floor = Matrix3::from_diagonal(&Vector3::new(off_m * off_m, off_m * off_m, off_rad * off_rad));
        let both = placed.and_then(|placed| {
            let known = by_odometer.try_inverse()?;
            (placed.information * self.settings.spread_share + known).try_inverse()
        });
        let mut covariance = both.map_or(by_odometer, |both| both + floor);
        if let Some(blind) = blind {
            let seen = blind.turned(&step_from_base.rotation);
            let way = &since_step.before_from_after;
            let (way_m, turn_m) = (way.translation.vector.norm(), seen.extent_m * way.rotation.angle().abs());
            let least_m2 = since_step.stray[0] + off_m * off_m;
            covariance = seen.with_blind(&covariance, |blind| {
                let moved_m = blind.xy().norm() * way_m + blind.z.abs() * turn_m;
                (self.settings.blind_way * moved_m).powi(2) + least_m2
            });
        }
        Followed {
            before_from_after: *step_from_base,
            covariance: (covariance + covariance.transpose()) * 0.5,
        }
    }
}

/// The scan does not see one direction: evidence along it is this share of that across it, or less.
const BLIND_SHARE: f64 = 2e-3;

/// The scan does not see one direction, as in a corridor.
pub(crate) fn is_degenerate(placed: &Registered) -> bool {
    let way = placed.information.fixed_view::<2, 2>(0, 0).into_owned();
    let values = way.symmetric_eigenvalues();
    values.min() < BLIND_SHARE * values.max()
}

impl Followed {
    /// The covariance in the map's axes, after a step from here.
    pub fn covariance_in(&self, map_from_before: &Pose2) -> Matrix3<f64> {
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), map_from_before.rotation.angle());
        turn.matrix() * self.covariance * turn.matrix().transpose()
    }
}
