//! Motion models: where particles may be after the odometer said that the robot moved. An open family by typetag.

use super::particles::Particles;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::rng::Rng;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::fmt::Debug;

/// How the robot's motion differs from what the odometer says.
#[typetag::serde(tag = "model")]
pub trait MotionModel: Debug + Send + Sync {
    /// Moves every particle as the odometer moved from one pose to the other, each with noise of its own.
    fn move_all(
        &self,
        odom_from_before: &Pose2,
        odom_from_after: &Pose2,
        particles: &mut Particles,
        rng: &mut Rng,
    );
    /// What is wrong with the parameters: key and message.
    fn faults(&self) -> Vec<(&'static str, String)>;
    /// A copy.
    fn boxed_clone(&self) -> Box<dyn MotionModel>;
}

impl Clone for Box<dyn MotionModel> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// A shorter way has no direction, meters.
const NO_DIRECTION_M: f64 = 0.01;

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

/// Noise of wheels that roll forwards (`model = "odometry"`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryMotion {
    /// Variances per square: turn by turn, turn by way (rad²/m²), way by way, way by turn (m²/rad²).
    pub alpha: [f64; 4],
}

impl Default for OdometryMotion {
    fn default() -> Self {
        OdometryMotion { alpha: [0.2; 4] }
    }
}

#[typetag::serde(name = "odometry")]
impl MotionModel for OdometryMotion {
    fn move_all(&self, before: &Pose2, after: &Pose2, particles: &mut Particles, rng: &mut Rng) {
        let step = TurnWayTurn::between(before, after, self.alpha);
        let deviation = step.variance.map(f64::sqrt);
        for [x, y, yaw] in particles.iter_mut() {
            let [rot1, trans, rot2] = noisy(step.mean, deviation, rng);
            let (sin, cos) = (*yaw + rot1).sin_cos();
            *x += trans * cos;
            *y += trans * sin;
            *yaw = wrap_angle(*yaw + rot1 + rot2);
        }
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        alpha_faults(&self.alpha)
    }

    fn boxed_clone(&self) -> Box<dyn MotionModel> {
        Box::new(*self)
    }
}

/// Noise of wheels that roll any way (`model = "omni"`): the bearing is taken as it is, and the robot strays to the side
/// with a variance of its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OmniMotion {
    /// As for `odometry`; the fifth is side by way.
    pub alpha: [f64; 5],
}

impl Default for OmniMotion {
    fn default() -> Self {
        OmniMotion { alpha: [0.2; 5] }
    }
}

#[typetag::serde(name = "omni")]
impl MotionModel for OmniMotion {
    fn move_all(&self, before: &Pose2, after: &Pose2, particles: &mut Particles, rng: &mut Rng) {
        let way = before.rotation.inverse() * (after.translation.vector - before.translation.vector);
        let (trans, turn) = (way.norm(), wrap_angle(after.rotation.angle() - before.rotation.angle()));
        let bearing = if trans < NO_DIRECTION_M { 0.0 } else { way.y.atan2(way.x) };
        let [a1, a2, a3, a4, a5] = self.alpha;
        let (way2, turn2) = (trans * trans, turn * turn);
        let variance = [a1 * turn2 + a2 * way2, a3 * way2 + a4 * turn2, a5 * way2 + a4 * turn2];
        let deviation = variance.map(f64::sqrt);
        for [x, y, yaw] in particles.iter_mut() {
            let [turn, along, aside] = noisy([turn, trans, 0.0], deviation, rng);
            let (sin, cos) = (*yaw + bearing).sin_cos();
            *x += along * cos - aside * sin;
            *y += along * sin + aside * cos;
            *yaw = wrap_angle(*yaw + turn);
        }
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        alpha_faults(&self.alpha)
    }

    fn boxed_clone(&self) -> Box<dyn MotionModel> {
        Box::new(*self)
    }
}

#[inline]
fn noisy(mean: [f64; 3], deviation: [f64; 3], rng: &mut Rng) -> [f64; 3] {
    std::array::from_fn(|k| {
        let normal: f64 = StandardNormal.sample(rng);
        mean[k] + deviation[k] * normal
    })
}

fn alpha_faults(alpha: &[f64]) -> Vec<(&'static str, String)> {
    let bad = alpha.iter().find(|value| !(value.is_finite() && **value >= 0.0));
    let message = |value: &f64| format!("holds {value}, expected finite numbers, 0 or more");
    bad.map(|value| ("alpha", message(value))).into_iter().collect()
}
