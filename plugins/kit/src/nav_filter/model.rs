//! The state, its propagation by one inertial sample, and how errors propagate.
//!
//! Errors are ordered attitude (three angles, body frame), position, velocity (navigation frame), bias of the rates, bias
//! of the forces (body frame): the true attitude is the estimated one times the rotation by the error.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};

/// Length of gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.80665;

/// Covariance of the fifteen errors.
pub type Covariance = SMatrix<f64, 15, 15>;
/// What the errors of x, y, yaw of the anchor have in common with the fifteen.
pub type AnchorCross = SMatrix<f64, 3, 15>;
/// The fifteen errors.
pub type Errors = SVector<f64, 15>;

/// Where each group of errors begins.
pub const ATTITUDE: usize = 0;
/// Position.
pub const POSITION: usize = 3;
/// Velocity.
pub const VELOCITY: usize = 6;
/// Bias of the rates.
pub const GYRO_BIAS: usize = 9;
/// Bias of the forces.
pub const ACCEL_BIAS: usize = 12;

/// What an inertial measurement unit reads, in the body's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImuSample {
    /// Turning rates, rad/s.
    pub rates_rad_s: Vector3<f64>,
    /// Specific forces, m/s²; at rest and level (0, 0, 9.80665).
    pub forces_m_s2: Vector3<f64>,
}

/// Where the body is and how it moves, in a navigation frame whose z points up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NavState {
    /// Attitude.
    pub nav_from_body: UnitQuaternion<f64>,
    /// Position, meters.
    pub position_m: Vector3<f64>,
    /// Velocity in the navigation frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// What the rates are too high by, rad/s.
    pub gyro_bias_rad_s: Vector3<f64>,
    /// What the forces are too great by, m/s².
    pub accel_bias_m_s2: Vector3<f64>,
}

impl Default for NavState {
    /// At the origin, level, at rest.
    fn default() -> Self {
        NavState {
            nav_from_body: UnitQuaternion::identity(),
            position_m: Vector3::zeros(),
            velocity_m_s: Vector3::zeros(),
            gyro_bias_rad_s: Vector3::zeros(),
            accel_bias_m_s2: Vector3::zeros(),
        }
    }
}

impl NavState {
    /// Where the body's x axis points, seen from above, radians.
    pub fn yaw_rad(&self) -> f64 {
        let ahead = self.nav_from_body * Vector3::x();
        ahead.y.atan2(ahead.x)
    }

    /// The state that these errors make of this one.
    pub fn plus(&self, errors: &Errors) -> NavState {
        let part = |at: usize| Vector3::new(errors[at], errors[at + 1], errors[at + 2]);
        let mut nav_from_body = self.nav_from_body * UnitQuaternion::from_scaled_axis(part(ATTITUDE));
        nav_from_body.renormalize();
        NavState {
            nav_from_body,
            position_m: self.position_m + part(POSITION),
            velocity_m_s: self.velocity_m_s + part(VELOCITY),
            gyro_bias_rad_s: self.gyro_bias_rad_s + part(GYRO_BIAS),
            accel_bias_m_s2: self.accel_bias_m_s2 + part(ACCEL_BIAS),
        }
    }

    /// The errors that make `other` of this state.
    pub fn minus(&self, other: &NavState) -> Errors {
        let mut errors = Errors::zeros();
        let turn = (self.nav_from_body.inverse() * other.nav_from_body).scaled_axis();
        for (at, part) in [
            (ATTITUDE, turn),
            (POSITION, other.position_m - self.position_m),
            (VELOCITY, other.velocity_m_s - self.velocity_m_s),
            (GYRO_BIAS, other.gyro_bias_rad_s - self.gyro_bias_rad_s),
            (ACCEL_BIAS, other.accel_bias_m_s2 - self.accel_bias_m_s2),
        ] {
            errors.fixed_rows_mut::<3>(at).copy_from(&part);
        }
        errors
    }

    /// Every number is finite.
    pub fn is_finite(&self) -> bool {
        let rows = [self.position_m, self.velocity_m_s, self.gyro_bias_rad_s, self.accel_bias_m_s2];
        self.nav_from_body.coords.iter().chain(rows.iter().flatten()).all(|v| v.is_finite())
    }

    fn rates(&self, sample: &ImuSample) -> Vector3<f64> {
        sample.rates_rad_s - self.gyro_bias_rad_s
    }

    fn acceleration(&self, sample: &ImuSample) -> Vector3<f64> {
        self.nav_from_body * (sample.forces_m_s2 - self.accel_bias_m_s2) - GRAVITY_M_S2 * Vector3::z()
    }
}

/// The state after `seconds` with a sample (equations 2 and 3; the quaternion form of equation 1).
pub fn propagate(state: &NavState, sample: &ImuSample, seconds: f64) -> NavState {
    let acceleration = state.acceleration(sample);
    let turn = UnitQuaternion::from_scaled_axis(state.rates(sample) * seconds);
    let mut nav_from_body = state.nav_from_body * turn;
    nav_from_body.renormalize();
    NavState {
        nav_from_body,
        position_m: state.position_m
            + state.velocity_m_s * seconds
            + acceleration * (0.5 * seconds * seconds),
        velocity_m_s: state.velocity_m_s + acceleration * seconds,
        ..*state
    }
}

/// How errors of the state before become errors of the state after [`propagate`].
pub fn jacobian(state: &NavState, sample: &ImuSample, seconds: f64) -> Covariance {
    let (dt, half) = (seconds, 0.5 * seconds * seconds);
    let turn = state.rates(sample) * dt;
    let nav_from_body = *state.nav_from_body.to_rotation_matrix().matrix();
    let by_attitude = -nav_from_body * (sample.forces_m_s2 - state.accel_bias_m_s2).cross_matrix();
    let mut f = Covariance::identity();
    let mut set = |row: usize, col: usize, block: &Matrix3<f64>| {
        f.fixed_view_mut::<3, 3>(row, col).copy_from(block);
    };
    set(ATTITUDE, ATTITUDE, Rotation3::from_scaled_axis(-turn).matrix());
    set(ATTITUDE, GYRO_BIAS, &(-dt * right_jacobian(&turn)));
    set(POSITION, VELOCITY, &(Matrix3::identity() * dt));
    set(POSITION, ATTITUDE, &(by_attitude * half));
    set(VELOCITY, ATTITUDE, &(by_attitude * dt));
    set(POSITION, ACCEL_BIAS, &(nav_from_body * -half));
    set(VELOCITY, ACCEL_BIAS, &(nav_from_body * -dt));
    f
}

/// How a small change of a rotation vector turns the rotation, on its right side.
fn right_jacobian(turn: &Vector3<f64>) -> Matrix3<f64> {
    let (angle2, cross) = (turn.norm_squared(), turn.cross_matrix());
    // Both quotients by their series where they lose digits.
    let (first, second) = if angle2 < 1e-8 {
        (0.5 - angle2 / 24.0, 1.0 / 6.0 - angle2 / 120.0)
    } else {
        let angle = angle2.sqrt();
        ((1.0 - angle.cos()) / angle2, (angle - angle.sin()) / (angle2 * angle))
    };
    Matrix3::identity() - cross * first + cross * cross * second
}

/// Covariance that one step adds: `G diag(gyro², accel²) Gᵀ`, and the walk of the biases (variances per second).
pub fn noise(
    seconds: f64,
    [gyro_rad_s, accel_m_s2]: [f64; 2],
    [gyro_walk2, accel_walk2]: [f64; 2],
) -> Covariance {
    let dt = seconds;
    // The noise is the same along all axes, and so it is in the navigation frame.
    let (attitude2, accel2) = ((gyro_rad_s * dt).powi(2), accel_m_s2.powi(2));
    let mut q = Covariance::zeros();
    for k in 0..3 {
        q[(ATTITUDE + k, ATTITUDE + k)] = attitude2;
        q[(POSITION + k, POSITION + k)] = accel2 * 0.25 * dt.powi(4);
        q[(POSITION + k, VELOCITY + k)] = accel2 * 0.5 * dt.powi(3);
        q[(VELOCITY + k, POSITION + k)] = accel2 * 0.5 * dt.powi(3);
        q[(VELOCITY + k, VELOCITY + k)] = accel2 * dt.powi(2);
        q[(GYRO_BIAS + k, GYRO_BIAS + k)] = gyro_walk2 * dt;
        q[(ACCEL_BIAS + k, ACCEL_BIAS + k)] = accel_walk2 * dt;
    }
    q
}

/// `F P Fᵀ`, with what the blocks of the Jacobian spare: only attitude, position and velocity change.
pub fn carried(f: &Covariance, p: &Covariance) -> Covariance {
    let moving = f.fixed_view::<9, 15>(0, 0);
    let above = moving * p;
    let mut carried = *p;
    let corner = above * moving.transpose();
    carried.fixed_view_mut::<9, 9>(0, 0).copy_from(&((corner + corner.transpose()) * 0.5));
    let side = above.fixed_view::<9, 6>(0, 9);
    carried.fixed_view_mut::<9, 6>(0, 9).copy_from(&side);
    carried.fixed_view_mut::<6, 9>(9, 0).copy_from(&side.transpose());
    carried
}
