//! How wheels move the state, and what measurements it should give.
//!
//! The state is x, y and yaw of the base in the map and the bias of the measured yaw: an inertial measurement unit says
//! yaw plus bias. A compass among steel and a gyroscope that was switched on somewhere are both off by some angle that
//! changes slowly; only motion between fixes shows it.

use nalgebra::{Matrix2x4, Matrix4, Rotation2, RowVector4, Vector2, Vector4};
use rumbo_core::frames::Pose2;

use crate::odometry::propagation::Way;

/// x, y (m), yaw, bias of the measured yaw (rad).
pub type State = Vector4<f64>;

/// The way that a step of the odometer is, in the map's axes.
fn way(state: &State, step: &Pose2) -> Way {
    Way { along: Rotation2::new(state[2]) * step.translation.vector, turn_rad: step.rotation.angle() }
}

/// The state after a step of the odometer (the new base seen from the old one). The yaw is not wrapped.
pub fn moved(state: &State, step: &Pose2) -> State {
    let way = way(state, step);
    state + State::new(way.along.x, way.along.y, way.turn_rad, 0.0)
}

/// How the state after a step changes with the state before it.
pub fn moved_by_state(state: &State, step: &Pose2) -> Matrix4<f64> {
    let mut through = Matrix4::identity();
    through.fixed_view_mut::<3, 3>(0, 0).copy_from(&way(state, step).by_pose());
    through
}

/// Covariance that a step adds, for an odometer with these standard deviations over one meter or radian: distance (m),
/// direction (rad per m) and turn (rad per rad). Each moment errs anew, so that variances grow with the way, however
/// finely it is told (Chong and Kleeman 1997).
pub fn new_errors(state: &State, step: &Pose2, noise: [f64; 3]) -> Matrix4<f64> {
    let way = way(state, step);
    let length_m = way.along.norm();
    let by_errors = way.by_errors();
    let mut sum = Matrix4::zeros();
    for ((effect, amount), deviation) in
        by_errors.column_iter().zip([length_m, length_m, way.turn_rad.abs()]).zip(noise)
    {
        if amount > 0.0 {
            let effect = State::new(effect[0], effect[1], effect[2], 0.0) * deviation;
            sum += effect * effect.transpose() / amount;
        }
    }
    sum
}

/// Where the antenna should be that sits at `lever_m` of the base.
pub fn antenna_m(state: &State, lever_m: &Vector2<f64>) -> Vector2<f64> {
    state.xy() + Rotation2::new(state[2]) * lever_m
}

/// How that changes with the state.
pub fn antenna_by_state(state: &State, lever_m: &Vector2<f64>) -> Matrix2x4<f64> {
    let turned = Rotation2::new(state[2]) * lever_m;
    Matrix2x4::new(1.0, 0.0, -turned.y, 0.0, 0.0, 1.0, turned.x, 0.0)
}

/// The yaw that the unit should say.
pub fn measured_yaw_rad(state: &State) -> f64 {
    state[2] + state[3]
}

/// How that changes with the state.
pub fn measured_yaw_by_state() -> RowVector4<f64> {
    RowVector4::new(0.0, 0.0, 1.0, 1.0)
}
