//! Motion models: where particles may be after the odometer said that the robot moved. An open family by typetag.

use super::particles::Particles;
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::rng::Rng;
use rumbo_kit::turn_way_turn::{NO_DIRECTION_M, TurnWayTurn, noisy};
use serde::{Deserialize, Serialize};
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

fn alpha_faults(alpha: &[f64]) -> Vec<(&'static str, String)> {
    let bad = alpha.iter().find(|value| !(value.is_finite() && **value >= 0.0));
    let message = |value: &f64| format!("holds {value}, expected finite numbers, 0 or more");
    bad.map(|value| ("alpha", message(value))).into_iter().collect()
}
