//! The heading of a robot that has no measured yaw: from the way between fixes.
//!
//! The odometer's way is laid over the fixes by the turn and the shift with the least squares (Arun, Huang and Blostein
//! 1987, in the plane).

use std::collections::VecDeque;

use nalgebra::{Matrix3, Rotation2, Vector2, Vector3};
use rumbo_core::frames::{Pose2, pose2};

use super::seen_fix::SeenFix;

/// More than this is not kept; the oldest go first.
const MOST_FIXES: usize = 600;
/// Fewer say nothing.
const FEWEST_FIXES: usize = 3;

/// Fixes beside where the odometer had the antenna.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Alignment {
    pairs: VecDeque<Pair>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Pair {
    odometer_m: Vector2<f64>,
    fix_m: Vector2<f64>,
    variance_m2: f64,
}

impl Alignment {
    /// A fix while the odometer has the base here.
    pub fn take_fix(&mut self, fix: &SeenFix, odom_from_base: &Pose2) {
        let odometer_m = (odom_from_base * nalgebra::Point2::from(fix.lever_now_m)).coords;
        if self.pairs.len() >= MOST_FIXES {
            self.pairs.pop_front();
        }
        self.pairs.push_back(Pair { odometer_m, fix_m: fix.antenna_m, variance_m2: fix.mean_variance_m2() });
    }

    /// The odometer was restarted.
    pub fn clear(&mut self) {
        self.pairs.clear();
    }

    /// The base in the map while the odometer has it here, and the covariance of x, y, yaw; nothing where the way is too
    /// short to tell.
    pub fn pose(&self, odom_from_base: &Pose2) -> Option<(Pose2, Matrix3<f64>)> {
        if self.pairs.len() < FEWEST_FIXES {
            return None;
        }
        let n = self.pairs.len() as f64;
        let mean = |of: fn(&Pair) -> Vector2<f64>| self.pairs.iter().map(of).sum::<Vector2<f64>>() / n;
        let (odometer_mean_m, fix_mean_m) = (mean(|pair| pair.odometer_m), mean(|pair| pair.fix_m));
        let (mut dot, mut cross, mut spread_m2) = (0.0, 0.0, 0.0);
        for pair in &self.pairs {
            let (from, to) = (pair.odometer_m - odometer_mean_m, pair.fix_m - fix_mean_m);
            dot += from.dot(&to);
            cross += from.perp(&to);
            spread_m2 += from.norm_squared();
        }
        let variance_m2 = self.pairs.iter().map(|pair| pair.variance_m2).sum::<f64>() / n;
        let turn_variance = variance_m2 / spread_m2;
        if !turn_variance.is_finite() || (dot == 0.0 && cross == 0.0) {
            return None;
        }
        let map_from_odom = Rotation2::new(cross.atan2(dot));
        let lever = map_from_odom * (odom_from_base.translation.vector - odometer_mean_m);
        let position_m = fix_mean_m + lever;
        let yaw_rad = map_from_odom.angle() + odom_from_base.rotation.angle();
        let by_turn = Vector3::new(-lever.y, lever.x, 1.0);
        let shift = Vector3::new(variance_m2 / n, variance_m2 / n, 0.0);
        let covariance = by_turn * turn_variance * by_turn.transpose() + Matrix3::from_diagonal(&shift);
        Some((pose2(position_m.x, position_m.y, yaw_rad), covariance))
    }
}
