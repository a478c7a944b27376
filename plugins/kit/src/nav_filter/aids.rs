//! What else is known of the motion: which way is up, that the robot stands, that it does not slide (section 10.3).

use nalgebra::{Matrix2, Matrix2x3, Matrix3, SMatrix, SVector, Unit, UnitQuaternion, Vector2, Vector3};

use super::model::{ATTITUDE, GRAVITY_M_S2, GYRO_BIAS, ImuSample, NavState, VELOCITY};
use super::settings::NavSettings;

/// Which measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AidKind {
    /// Which way is up.
    Leveling,
    /// The robot stands.
    Standing,
    /// And does not turn.
    Rates,
    /// It neither slides nor flies.
    Sliding,
    /// Somebody measured its velocity.
    Velocity,
}

impl AidKind {
    /// How many there are.
    pub const COUNT: usize = 5;
}

/// A measurement of the state: what it differs from the expected by, how it depends on the errors, its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aid<const M: usize> {
    /// Measured less expected.
    pub innovation: SVector<f64, M>,
    /// How it depends on the errors.
    pub h: SMatrix<f64, M, 15>,
    /// Its covariance.
    pub r: SMatrix<f64, M, M>,
}

/// Roll and pitch of a body at rest by its specific forces.
pub fn leveled_angles(forces_m_s2: &Vector3<f64>) -> [f64; 2] {
    let [x, y, z] = (*forces_m_s2).into();
    [y.atan2(z), (-x).atan2(y.hypot(z))]
}

/// These forces are those of gravity.
pub fn is_gravity(forces_m_s2: &Vector3<f64>, settings: &NavSettings) -> bool {
    (forces_m_s2.norm() - GRAVITY_M_S2).abs() <= settings.gravity_gate_m_s2
}

/// Standard deviation of a leveling, radians: beyond the gate of the rates it grows with the square of the rate, as what a
/// device beside the axis of the turn feels.
pub fn leveling_std_rad(rates_rad_s: &Vector3<f64>, settings: &NavSettings) -> f64 {
    settings.leveling_std_rad * (rates_rad_s.norm() / settings.leveling_rate_rad_s).max(1.0).powi(2)
}

/// What is left of the forces of a body without those by which it is held on its curve, m/s². Only the turn about the vertical
/// counts: as a body sways, what it is on goes straight on. `known` is how much the velocity counts, from 0 to 1.
pub fn without_curve(state: &NavState, sample: &ImuSample, known: f64) -> Vector3<f64> {
    let body_from_nav = state.nav_from_body.inverse();
    let (velocity, up) = (body_from_nav * state.velocity_m_s, body_from_nav * Vector3::z());
    let turn_rad_s = up.dot(&(sample.rates_rad_s - state.gyro_bias_rad_s));
    sample.forces_m_s2 - state.accel_bias_m_s2 - up.cross(&velocity) * (turn_rad_s * known)
}

/// The attitude with the roll and pitch of these forces, and the yaw that it has.
pub fn leveled_from(state: &NavState, forces_m_s2: &Vector3<f64>) -> UnitQuaternion<f64> {
    let [roll_rad, pitch_rad] = leveled_angles(forces_m_s2);
    UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, state.yaw_rad())
}

/// Up as the forces say, against up as the attitude says: two angles about axes that are level in the body.
pub fn leveling(state: &NavState, forces_m_s2: &Vector3<f64>, std_rad: f64) -> Option<Aid<2>> {
    let up = state.nav_from_body.inverse() * Vector3::z();
    let measured = Unit::try_new(*forces_m_s2, 1e-6)?;
    // The turn of the body that makes the expected direction the measured one.
    let (axis, cosine) = (measured.cross(&up), measured.dot(&up));
    let (sine, angle) = (axis.norm(), axis.norm().atan2(cosine));
    let turn = if sine > 1e-12 { axis * (angle / sine) } else { axis };
    let across = Matrix2x3::from_rows(&level_axes(&up).map(|axis| axis.transpose()));
    let mut h = SMatrix::<f64, 2, 15>::zeros();
    h.fixed_view_mut::<2, 3>(0, ATTITUDE).copy_from(&across);
    Some(Aid { innovation: across * turn, h, r: Matrix2::identity() * std_rad.powi(2) })
}

/// Two axes across a direction and each other.
fn level_axes(up: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let helper = if up.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let first = up.cross(&helper).normalize();
    [first, up.cross(&first)]
}

/// The robot stands.
pub fn zero_velocity(state: &NavState, std_m_s: f64) -> Aid<3> {
    let mut h = SMatrix::<f64, 3, 15>::zeros();
    h.fixed_view_mut::<3, 3>(0, VELOCITY).copy_from(&Matrix3::identity());
    Aid { innovation: -state.velocity_m_s, h, r: Matrix3::identity() * std_m_s.powi(2) }
}

/// The robot stands: all that the rates say is their bias and noise.
pub fn zero_rate(state: &NavState, rates_rad_s: &Vector3<f64>, std_rad_s: f64) -> Aid<3> {
    let mut h = SMatrix::<f64, 3, 15>::zeros();
    h.fixed_view_mut::<3, 3>(0, GYRO_BIAS).copy_from(&Matrix3::identity());
    Aid { innovation: rates_rad_s - state.gyro_bias_rad_s, h, r: Matrix3::identity() * std_rad_s.powi(2) }
}

/// The robot neither slides sideways nor flies. Sideways is level here: however a body leans on its wheels or rolls on a
/// slope, these take it to where it looks.
pub fn no_sliding(state: &NavState, lateral_m_s: f64, vertical_m_s: f64) -> Aid<2> {
    let (floor, vertical) =
        (floor_velocity(state, &Vector2::zeros(), &Matrix2::zeros()), no_flying(state, vertical_m_s));
    let mut aid = Aid { innovation: SVector::zeros(), h: SMatrix::zeros(), r: SMatrix::zeros() };
    aid.innovation = Vector2::new(floor.innovation.y, vertical.innovation.x);
    aid.h.set_row(0, &floor.h.row(1));
    aid.h.set_row(1, &vertical.h.row(0));
    aid.r = Matrix2::from_diagonal(&Vector2::new(lateral_m_s.powi(2), vertical_m_s.powi(2)));
    aid
}

/// The robot does not fly: the body has no velocity along its own vertical.
pub fn no_flying(state: &NavState, vertical_m_s: f64) -> Aid<1> {
    let body_from_nav = state.nav_from_body.inverse().to_rotation_matrix();
    let velocity = body_from_nav * state.velocity_m_s;
    let mut h = SMatrix::<f64, 1, 15>::zeros();
    h.fixed_view_mut::<1, 3>(0, ATTITUDE).copy_from(&velocity.cross_matrix().row(2));
    h.fixed_view_mut::<1, 3>(0, VELOCITY).copy_from(&body_from_nav.matrix().row(2));
    Aid { innovation: SVector::from([-velocity.z]), h, r: SMatrix::from([[vertical_m_s.powi(2)]]) }
}

/// Velocity over the floor, forward and to the left, in the level frame that looks where the body looks.
pub fn floor_velocity(state: &NavState, measured_m_s: &Vector2<f64>, r: &Matrix2<f64>) -> Aid<2> {
    let yaw_rad = state.yaw_rad();
    let (sine, cosine) = yaw_rad.sin_cos();
    let level_from_nav = Matrix2::new(cosine, sine, -sine, cosine);
    let velocity = level_from_nav * state.velocity_m_s.xy();
    let mut h = SMatrix::<f64, 2, 15>::zeros();
    h.fixed_view_mut::<2, 2>(0, VELOCITY).copy_from(&level_from_nav);
    // A turn to the left makes what was ahead be to the right.
    let by_yaw = Vector2::new(velocity.y, -velocity.x);
    let yaw = yaw_by_errors(state);
    h.fixed_view_mut::<2, 3>(0, ATTITUDE).copy_from(&(by_yaw * yaw.transpose()));
    Aid { innovation: measured_m_s - velocity, h, r: *r }
}

/// How errors of the attitude change where the body's x axis points from above.
pub fn yaw_by_errors(state: &NavState) -> Vector3<f64> {
    let rotation = state.nav_from_body.to_rotation_matrix();
    let ahead = rotation * Vector3::x();
    let level2 = (ahead.x.powi(2) + ahead.y.powi(2)).max(1e-4);
    // d ahead = R (error x e_x) = R (0, error_z, -error_y); yaw = atan2(y, x).
    let by = |axis: &Vector3<f64>| (ahead.x * axis.y - ahead.y * axis.x) / level2;
    let (left, up) = (rotation * Vector3::y(), rotation * Vector3::z());
    Vector3::new(0.0, -by(&up), by(&left))
}
