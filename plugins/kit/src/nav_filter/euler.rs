//! The same motion in roll, pitch and yaw: for comparison with the source, and for covariances as people read them.

use nalgebra::{Matrix3, Rotation3, SMatrix, UnitQuaternion, Vector3};
use rumbo_core::frames::wrap_angle;

use super::model::{GRAVITY_M_S2, ImuSample};

/// Beyond this pitch the rates of Euler angles are of no use, radians.
pub const STEEPEST_RAD: f64 = 80.0 * std::f64::consts::PI / 180.0;

/// Pitch so near to straight up or down that roll and yaw are the same.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a pitch of {pitch_rad} rad has no rates of Euler angles; use quaternions")]
pub struct Degenerate {
    /// The pitch.
    pub pitch_rad: f64,
}

/// Roll, pitch, yaw, position, velocity (equations 1 to 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EulerState {
    /// Roll, pitch, yaw, radians.
    pub angles_rad: Vector3<f64>,
    /// Position, meters.
    pub position_m: Vector3<f64>,
    /// Velocity in the navigation frame, m/s.
    pub velocity_m_s: Vector3<f64>,
}

impl EulerState {
    /// The rotation of these angles.
    pub fn nav_from_body(&self) -> Matrix3<f64> {
        let [roll, pitch, yaw] = self.angles_rad.into();
        *Rotation3::from_euler_angles(roll, pitch, yaw).matrix()
    }

    /// Rates of the angles from the body's turning rates.
    ///
    /// # Errors
    /// Beyond 80 degrees of pitch.
    pub fn angle_rates(&self) -> Result<Matrix3<f64>, Degenerate> {
        angle_rates(self.angles_rad[0], self.angles_rad[1])
    }

    /// The state after `seconds`.
    ///
    /// # Errors
    /// Beyond 80 degrees of pitch.
    pub fn propagate(&self, sample: &ImuSample, seconds: f64) -> Result<EulerState, Degenerate> {
        let acceleration = self.nav_from_body() * sample.forces_m_s2 - GRAVITY_M_S2 * Vector3::z();
        let angles = self.angles_rad + self.angle_rates()? * sample.rates_rad_s * seconds;
        Ok(EulerState {
            angles_rad: angles.map(wrap_angle),
            position_m: self.position_m
                + self.velocity_m_s * seconds
                + acceleration * (0.5 * seconds * seconds),
            velocity_m_s: self.velocity_m_s + acceleration * seconds,
        })
    }

    /// How noise of rates and forces enters in one step.
    ///
    /// # Errors
    /// Beyond 80 degrees of pitch.
    pub fn noise_gain(&self, seconds: f64) -> Result<SMatrix<f64, 9, 6>, Degenerate> {
        let mut gain = SMatrix::<f64, 9, 6>::zeros();
        let rotation = self.nav_from_body();
        gain.fixed_view_mut::<3, 3>(0, 0).copy_from(&(self.angle_rates()? * seconds));
        gain.fixed_view_mut::<3, 3>(3, 3).copy_from(&(rotation * (0.5 * seconds * seconds)));
        gain.fixed_view_mut::<3, 3>(6, 3).copy_from(&(rotation * seconds));
        Ok(gain)
    }
}

/// Rates of roll, pitch and yaw from the body's turning rates.
///
/// # Errors
/// Beyond 80 degrees of pitch.
pub fn angle_rates(roll_rad: f64, pitch_rad: f64) -> Result<Matrix3<f64>, Degenerate> {
    // Not-a-number is no pitch either.
    if pitch_rad.is_nan() || pitch_rad.abs() > STEEPEST_RAD {
        return Err(Degenerate { pitch_rad });
    }
    let ((s, c), (tangent, cosine)) = (roll_rad.sin_cos(), (pitch_rad.tan(), pitch_rad.cos()));
    Ok(Matrix3::new(1.0, s * tangent, c * tangent, 0.0, c, -s, 0.0, s / cosine, c / cosine))
}

/// How errors in the body's frame change roll, pitch and yaw. Near straight up or down, where two of them have no meaning, as
/// at 80 degrees: what leaves a filter stays finite.
pub fn angles_by_errors(nav_from_body: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let (roll, pitch, _) = nav_from_body.euler_angles();
    angle_rates(roll, pitch.clamp(-STEEPEST_RAD, STEEPEST_RAD)).unwrap_or_else(|_| Matrix3::identity())
}
