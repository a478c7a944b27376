//! One scan related to the scan before, as the source does: needs no map, and errors add up.

use super::all_pairs::{ByPairs, Solution, by_pairs};
use super::correspondence::relate;
use super::covariance::{in_axes_of, moved_by};
use super::scan::{Found, SeenScan};
use super::sureness::LEAST_RELATED;
use super::tracker::{Anchor, PairRules, TrackerSettings, grow};
use crate::odometry::propagation::Uncertainty;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_kit::landmarks::Landmark;

/// The landmarks of a scan that the robot's way from the last scan is found by: `known` were seen at the anchor.
pub fn look_back(
    scan: &SeenScan<'_>,
    (known, seen): (&[Landmark], &[Landmark]),
    (anchor, odom_from_base, noise): (&Anchor, &Pose2, [f64; 3]),
    (settings, rules): (&TrackerSettings, &PairRules),
) -> Found {
    let base = scan.base_from_sensor;
    let way = anchor.odom_from_base.inverse() * odom_from_base;
    let mut unsure = Uncertainty::new(Matrix3::from_diagonal(&Vector3::repeat(1e-10)));
    grow(&mut unsure, &Pose2::identity(), &way, noise);
    let a_from_b = base.inverse() * way * base;
    let odometry = Solution { a_from_b, covariance: in_axes_of(&base, &unsure.covariance()) };
    let relations = relate(known, seen, &a_from_b, &settings.within);
    let by_landmarks = by_pairs(&relations, &odometry, rules).filter(|_| relations.len() >= LEAST_RELATED);
    let n_estimates = by_landmarks.as_ref().map_or(0, |found| found.n_estimates);
    let solution = by_landmarks.map_or(odometry, |ByPairs { solution, .. }| solution);
    let map_from_a = anchor.map_from_base * base;
    let map_from_sensor = map_from_a * solution.a_from_b;
    let map_from_base = map_from_sensor * base.inverse();
    let way = map_from_sensor.translation.vector - map_from_a.translation.vector;
    let step = in_axes_of(&map_from_a.inverse(), &solution.covariance);
    let back = map_from_base.translation.vector - map_from_sensor.translation.vector;
    let covariance = moved_by(&(moved_by(&anchor.covariance, &way) + step), &back);
    Found { map_from_base, covariance, n_related: relations.len(), n_estimates, explained: None }
}
