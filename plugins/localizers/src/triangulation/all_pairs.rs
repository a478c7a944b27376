//! The pose by all pairs of landmarks and the odometry. Hernández Alamilla (2005), sections 5.3.5 and 5.4.

use super::correspondence::Relation;
use super::fusion::{ODOMETRY_WEIGHT, circular_mean, drop_far, median, turns, weighted_mean};
use super::pairs::pair_estimate;
use super::quality::weight;
use super::tracker::PairRules;
use nalgebra::{Matrix2, Matrix3, Vector2};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};

/// Error of positions by pairs that their agreement does not show, meters: all share the errors of the same scan.
const COMMON_ERROR_M: f64 = 0.01;

/// A pose with its covariance of x, y, yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution {
    /// The later place seen from the earlier.
    pub a_from_b: Pose2,
    /// In the axes of the earlier place.
    pub covariance: Matrix3<f64>,
}

/// A pose by pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ByPairs {
    /// The pose.
    pub solution: Solution,
    /// Pairs that it was made from.
    pub n_estimates: usize,
}

/// The source's estimate: all pairs and the odometry. Its covariance is the scatter of the pairs; they share landmarks, so
/// that many of them know little more than one. None where neither odometry nor landmarks say anything of the heading.
pub fn by_pairs(
    relations: &[Relation],
    odometry: &Solution,
    &PairRules { weighting, within_m }: &PairRules,
) -> Option<ByPairs> {
    let by_odometry = [odometry.a_from_b.translation.x, odometry.a_from_b.translation.y];
    let mut estimates = Vec::new();
    for (idx, a) in relations.iter().enumerate() {
        let pairs = relations.iter().skip(idx + 1).filter_map(|b| pair_estimate(a, b, by_odometry));
        estimates
            .extend(pairs.map(|pair| (pair.position, weight(&pair, weighting))).filter(|(_, w)| *w > 0.0));
    }
    let n_estimates = estimates.len();
    estimates.push((by_odometry, ODOMETRY_WEIGHT));
    if let Some(within_m) = within_m {
        drop_far(&mut estimates, within_m);
    }
    let [x, y] = weighted_mean(&estimates).unwrap_or(by_odometry);
    let turns = turns(relations, [x, y]);
    let by_odometry_rad = odometry.a_from_b.rotation.angle();
    let offs: Vec<f64> = turns.iter().map(|turn| wrap_angle(turn - by_odometry_rad)).collect();
    let yaw = match within_m {
        Some(_) => by_odometry_rad + median(offs),
        None => circular_mean(&turns)?,
    };
    let mut covariance = odometry.covariance;
    if n_estimates > 0 {
        let total: f64 = estimates.iter().map(|(_, weight)| weight).sum();
        let mut scatter = Matrix2::identity() * COMMON_ERROR_M.powi(2);
        for (place, weight) in &estimates {
            let off = Vector2::new(place[0] - x, place[1] - y);
            scatter += off * off.transpose() * (weight / total);
        }
        covariance.fill(0.0);
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&scatter);
        covariance[(2, 2)] = odometry.covariance[(2, 2)];
    }
    if turns.len() > 1 {
        let square: f64 = turns.iter().map(|turn| wrap_angle(turn - yaw).powi(2)).sum();
        covariance.fill_row(2, 0.0);
        covariance.fill_column(2, 0.0);
        covariance[(2, 2)] = square / turns.len() as f64 + 1e-6;
    }
    let solution = Solution { a_from_b: pose2(x, y, wrap_angle(yaw)), covariance };
    Some(ByPairs { solution, n_estimates })
}
