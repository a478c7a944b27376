//! How a simulated device errs.

use rand_distr::{Distribution as _, StandardNormal};
use rumbo_core::frames::wrap_angle;
use rumbo_core::messages::Imu;
use rumbo_core::rng::Rng;
use rumbo_core::time::Time;

/// Errors of roll, pitch and yaw.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AttitudeErrors {
    /// The same all the time, radians.
    pub yaw_bias_rad: f64,
    /// What grows with time, rad/s.
    pub yaw_drift_rad_s: f64,
    /// Standard deviation of each yaw, radians.
    pub yaw_rad: f64,
    /// Standard deviation of each roll and pitch, radians.
    pub tilt_rad: f64,
}

/// Errors of a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImuNoise {
    /// Those of the attitude.
    pub attitude: AttitudeErrors,
    /// The same for all rates and all the time, rad/s.
    pub rate_bias_rad_s: f64,
    /// Standard deviation of each rate, rad/s.
    pub rate_rad_s: f64,
    /// Standard deviation of each acceleration, m/s².
    pub acceleration_m_s2: f64,
}

impl ImuNoise {
    /// What the device makes of what is true. Takes as many random numbers each time.
    pub fn read(&self, exact: &Imu, now: Time, rng: &mut Rng) -> Imu {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let AttitudeErrors { yaw_bias_rad, yaw_drift_rad_s, yaw_rad, tilt_rad } = self.attitude;
        let errors = [
            tilt_rad * normal(),
            tilt_rad * normal(),
            yaw_bias_rad + yaw_drift_rad_s * now.as_secs() + yaw_rad * normal(),
        ];
        let mut read = *exact;
        if let Some(attitude_rad) = &mut read.attitude_rad {
            for (angle_rad, error_rad) in attitude_rad.iter_mut().zip(errors) {
                *angle_rad = wrap_angle(*angle_rad + error_rad);
            }
        }
        for rate_rad_s in &mut read.rates_rad_s {
            *rate_rad_s += self.rate_bias_rad_s + self.rate_rad_s * normal();
        }
        for acceleration_m_s2 in &mut read.accelerations_m_s2 {
            *acceleration_m_s2 += self.acceleration_m_s2 * normal();
        }
        read
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_have_the_bias_the_drift_and_the_deviations_asked_for() {
        let attitude =
            AttitudeErrors { yaw_bias_rad: 0.1, yaw_drift_rad_s: 0.001, yaw_rad: 0.02, tilt_rad: 0.03 };
        let noise = ImuNoise { attitude, rate_bias_rad_s: 0.05, rate_rad_s: 0.04, acceleration_m_s2: 0.06 };
        let exact = Imu {
            attitude_rad: Some([0.1, -0.1, 3.1]),
            rates_rad_s: [0.0, 0.0, 0.5],
            accelerations_m_s2: [0.0, 0.0, 9.81],
        };
        let (mut rng, n) = (rumbo_core::rng::stream(1, "imu"), 40_000);
        let now = Time::from_secs(100.0);
        let read: Vec<Imu> = (0..n).map(|_| noise.read(&exact, now, &mut rng)).collect();
        let about = |of: &dyn Fn(&Imu) -> f64, mean: f64, deviation: f64| {
            let found = read.iter().map(of).sum::<f64>() / f64::from(n);
            let spread =
                (read.iter().map(|imu| (of(imu) - found).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
            assert!((found - mean).abs() < 5.0 * deviation / f64::from(n).sqrt(), "{found} for {mean}");
            assert!((spread / deviation - 1.0).abs() < 0.02, "{spread} for {deviation}");
        };
        // The yaw is beyond half a turn, and wrapped: 3.1 + 0.1 + 100 * 0.001 less what is true.
        about(&|imu| wrap_angle(imu.attitude_rad.unwrap()[2] - 3.1), 0.2, 0.02);
        assert!(read.iter().all(|imu| imu.attitude_rad.unwrap()[2].abs() <= std::f64::consts::PI));
        about(&|imu| imu.attitude_rad.unwrap()[0], 0.1, 0.03);
        about(&|imu| imu.attitude_rad.unwrap()[1], -0.1, 0.03);
        about(&|imu| imu.rates_rad_s[2], 0.55, 0.04);
        about(&|imu| imu.rates_rad_s[0], 0.05, 0.04);
        about(&|imu| imu.accelerations_m_s2[2], 9.81, 0.06);
    }
}
