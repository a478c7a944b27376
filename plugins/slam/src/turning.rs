//! How fast the robot turns as seen from above, by an inertial unit.

use nalgebra::{UnitQuaternion, Vector3};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::Imu;

/// Steeper than this, nobody knows where the robot looks, as the cosine of the pitch.
const LEAST_COSINE: f64 = 0.1;

/// Rate of the base's yaw, rad/s. On a base that leans the rates about all its axes turn it, where the device knows how it leans:
/// `(ω_y sin roll + ω_z cos roll) / cos pitch`. A device without an attitude counts as level.
pub fn yaw_rate_rad_s(imu: &Imu, base_from_imu: &Pose3) -> f64 {
    let rates = base_from_imu.rotation * Vector3::from(imu.rates_rad_s);
    let Some([roll_rad, pitch_rad, yaw_rad]) = imu.attitude_rad else { return rates.z };
    let world_from_imu = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, yaw_rad);
    let (roll_rad, pitch_rad, _) = (world_from_imu * base_from_imu.rotation.inverse()).euler_angles();
    let (sine, cosine) = roll_rad.sin_cos();
    (rates.y * sine + rates.z * cosine) / pitch_rad.cos().max(LEAST_COSINE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attitude(seconds: f64) -> UnitQuaternion<f64> {
        let sway = std::f64::consts::PI * seconds;
        UnitQuaternion::from_euler_angles(0.35 * sway.sin(), 0.35 * sway.cos(), 0.4 * seconds)
    }

    /// The rates of a swaying body by differences of its attitude, however the device sits on it.
    #[test]
    fn a_body_that_sways_turns_as_its_yaw_does() {
        let step_s = 1e-6;
        for seat in [[0.0, 0.0, 0.0], [0.0, 0.2, 1.5], [3.1, 0.0, 0.4]] {
            let base_from_imu = UnitQuaternion::from_euler_angles(seat[0], seat[1], seat[2]);
            for tenth in 0..20 {
                let seconds = 0.1 * f64::from(tenth);
                let world_from_imu = attitude(seconds) * base_from_imu;
                let later = attitude(seconds + step_s) * base_from_imu;
                let rates = (world_from_imu.inverse() * later).scaled_axis() / step_s;
                let (roll, pitch, yaw) = world_from_imu.euler_angles();
                let imu = Imu {
                    attitude_rad: Some([roll, pitch, yaw]),
                    rates_rad_s: rates.into(),
                    ..Imu::default()
                };
                let mount = Pose3::from_parts(nalgebra::Translation3::identity(), base_from_imu);
                let found = yaw_rate_rad_s(&imu, &mount);
                assert!((found - 0.4).abs() < 1e-4, "{seat:?}, {seconds} s: {found}");
            }
        }
    }

    #[test]
    fn without_an_attitude_the_base_is_level() {
        let imu = Imu { rates_rad_s: [0.3, 0.2, 0.1], ..Imu::default() };
        assert_eq!(yaw_rate_rad_s(&imu, &Pose3::identity()), 0.1);
    }
}
