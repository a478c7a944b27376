//! A step of the odometer as a turn, a straight way and another turn, and how unsure each of them is.

use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::rng::Rng;
use std::f64::consts::PI;

/// A shorter way has no direction, meters.
pub const NO_DIRECTION_M: f64 = 0.01;

/// A step of the odometer as a turn, a straight way, and another turn, with the variance of each: Thrun, Burgard, Fox,
/// *Probabilistic Robotics* (2005), table 5.6. Differs from the book: turns are folded, so that driving backwards is
/// not noisier than forwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnWayTurn {
    /// First turn, way, second turn; radians and meters.
    pub mean: [f64; 3],
    /// Variances of the three.
    pub variance: [f64; 3],
    /// The turns as the noise sees them, 0 to a quarter turn, radians.
    pub folded_rad: [f64; 2],
}

impl TurnWayTurn {
    /// The step between two poses of the odometer, with noise by `alpha`: turn by turn, turn by way, way by way, way by
    /// turn.
    pub fn between(before: &Pose2, after: &Pose2, alpha: [f64; 4]) -> TurnWayTurn {
        let way = after.translation.vector - before.translation.vector;
        let trans = way.norm();
        let rot1 = match trans < NO_DIRECTION_M {
            true => 0.0,
            false => wrap_angle(way.y.atan2(way.x) - before.rotation.angle()),
        };
        let rot2 = wrap_angle(after.rotation.angle() - before.rotation.angle() - rot1);
        let fold = |angle: f64| angle.abs().min(PI - angle.abs());
        let (f1, f2) = (fold(rot1), fold(rot2));
        let [a1, a2, a3, a4] = alpha;
        let way2 = trans * trans;
        let turn_variance = |folded: f64| a1 * folded * folded + a2 * way2;
        TurnWayTurn {
            mean: [rot1, trans, rot2],
            variance: [turn_variance(f1), a3 * way2 + a4 * (f1 * f1 + f2 * f2), turn_variance(f2)],
            folded_rad: [f1, f2],
        }
    }
}

/// Numbers with normal noise of these standard deviations.
#[inline]
pub fn noisy(mean: [f64; 3], deviation: [f64; 3], rng: &mut Rng) -> [f64; 3] {
    std::array::from_fn(|k| {
        let normal: f64 = StandardNormal.sample(rng);
        mean[k] + deviation[k] * normal
    })
}
