//! How a way of the odometer moves the belief.
//!
//! The state is x, y, yaw and the errors of the odometer's scales: the robot went `1 + distance_error` times as far and
//! turned by `1 + turn_error` times as much as the odometer says. A way that bends more leaves in a direction that is
//! off by half of what it bends more, as on an arc.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2};
use rumbo_core::frames::{Pose2, pose2};

use crate::odometry::propagation::Way;

/// x, y, yaw, error of the distance scale, error of the turn scale.
pub const N_STATES: usize = 5;
/// A state, or a change of one.
pub type State = SVector<f64, N_STATES>;
/// Covariance or Jacobian of states.
pub type StateMatrix = SMatrix<f64, N_STATES, N_STATES>;

/// Where the robot is in a state.
pub fn pose_of(state: &State) -> Pose2 {
    pose2(state[0], state[1], state[2])
}

/// The way that a step of the odometer is, in the map's axes.
fn way(state: &State, step: &Pose2) -> Way {
    let turn_rad = step.rotation.angle();
    let direction = nalgebra::Rotation2::new(state[2] + state[4] * turn_rad / 2.0);
    let along: Vector2<f64> = direction * step.translation.vector * (1.0 + state[3]);
    Way { along, turn_rad: turn_rad * (1.0 + state[4]) }
}

/// The state after a step of the odometer (the new base seen from the old one). The yaw is not wrapped.
pub fn moved(state: &State, step: &Pose2) -> State {
    let way = way(state, step);
    state + State::new(way.along.x, way.along.y, way.turn_rad, 0.0, 0.0)
}

/// How the state after a step changes with the state before it.
pub fn by_state(state: &State, step: &Pose2) -> StateMatrix {
    let (way, turn_rad) = (way(state, step), step.rotation.angle());
    let unscaled = nalgebra::Rotation2::new(state[2] + state[4] * turn_rad / 2.0) * step.translation.vector;
    let mut through = StateMatrix::identity();
    through.fixed_view_mut::<3, 3>(0, 0).copy_from(&way.by_pose());
    through[(0, 3)] = unscaled.x;
    through[(1, 3)] = unscaled.y;
    through[(0, 4)] = -way.along.y * turn_rad / 2.0;
    through[(1, 4)] = way.along.x * turn_rad / 2.0;
    through[(2, 4)] = turn_rad;
    through
}

/// Covariance of x, y, yaw that a step adds, for an odometer with these standard deviations over one meter or radian:
/// distance (m), direction (rad per m) and turn (rad per rad). Each moment errs anew, so that variances grow with the
/// way, however finely it is told (Chong and Kleeman 1997).
pub fn new_errors(state: &State, step: &Pose2, noise: [f64; 3]) -> Matrix3<f64> {
    let way = way(state, step);
    let length_m = way.along.norm();
    let by_errors = way.by_errors();
    let mut sum = Matrix3::zeros();
    for (idx, amount) in [length_m, length_m, way.turn_rad.abs()].into_iter().enumerate() {
        if amount > 0.0 {
            let effect = by_errors.column(idx) * noise[idx];
            sum += effect * effect.transpose() / amount;
        }
    }
    sum
}
