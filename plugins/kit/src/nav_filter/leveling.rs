//! The attitude part alone: rates turn the attitude, gravity levels it. For devices without an attitude of their own.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix6, SMatrix, UnitQuaternion, Vector3};
use rumbo_core::time::Time;

use super::aids::{is_gravity, leveled_angles, leveled_from, leveling, leveling_std_rad};
use super::model::{ImuSample, NavState};
use super::settings::NavSettings;
use super::update::{CHI2_95, joseph};

/// An attitude by rates and gravity, with the bias of the rates. Its yaw is that of the rates: it drifts.
#[derive(Debug, Clone)]
pub struct Leveler {
    settings: NavSettings,
    nav_from_body: UnitQuaternion<f64>,
    gyro_bias_rad_s: Vector3<f64>,
    covariance: Matrix6<f64>,
    last: Option<(Time, ImuSample)>,
    last_aid: Option<Time>,
    n_rejected: u32,
    /// Since when gravity has said all the time that the attitude is wrong.
    wrong_since: Option<Time>,
}

impl Leveler {
    /// With these settings; what does not have to do with the attitude is not used.
    pub fn new(settings: NavSettings) -> Leveler {
        Leveler {
            settings,
            nav_from_body: UnitQuaternion::identity(),
            gyro_bias_rad_s: Vector3::zeros(),
            covariance: Matrix6::identity(),
            last: None,
            last_aid: None,
            n_rejected: 0,
            wrong_since: None,
        }
    }

    /// Takes in a sample of the body. False where it is no reading, or not newer than the last one.
    pub fn take(&mut self, stamp: Time, sample: &ImuSample) -> bool {
        if !is_reading(sample, &self.settings) {
            return false;
        }
        match self.last {
            None => self.begin(sample),
            Some((before, _)) if before >= stamp => return false,
            Some((before, earlier)) => {
                let gap = stamp - before;
                let rates = if gap > self.settings.max_gap {
                    Vector3::zeros()
                } else {
                    (earlier.rates_rad_s + sample.rates_rad_s) * 0.5 - self.gyro_bias_rad_s
                };
                self.turn(&rates, gap.as_secs(), gap > self.settings.max_gap);
            }
        }
        self.last = Some((stamp, *sample));
        let is_due = self.last_aid.is_none_or(|last| stamp - last >= self.settings.aid_period);
        if is_due && is_gravity(&sample.forces_m_s2, &self.settings) {
            self.last_aid = Some(stamp);
            self.level(stamp, sample);
        }
        true
    }

    /// Roll and pitch as the forces say, whatever they are: nothing else is known.
    fn begin(&mut self, sample: &ImuSample) {
        let [roll_rad, pitch_rad] = leveled_angles(&sample.forces_m_s2);
        self.nav_from_body = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, 0.0);
        let std_rad = if is_gravity(&sample.forces_m_s2, &self.settings) {
            self.settings.leveling_std_rad
        } else {
            0.5
        };
        self.covariance = Matrix6::zeros();
        let bias2 = self.settings.gyro_bias_rad_s.powi(2);
        for k in 0..3 {
            self.covariance[(k, k)] = std_rad.powi(2);
            self.covariance[(k + 3, k + 3)] = bias2.max(1e-12);
        }
    }

    fn turn(&mut self, rates_rad_s: &Vector3<f64>, seconds: f64, is_gap: bool) {
        let turn = UnitQuaternion::from_scaled_axis(rates_rad_s * seconds);
        let mut f = Matrix6::identity();
        f.fixed_view_mut::<3, 3>(0, 0).copy_from(turn.inverse().to_rotation_matrix().matrix());
        f.fixed_view_mut::<3, 3>(0, 3).copy_from(&(Matrix3::identity() * -seconds));
        self.covariance = f * self.covariance * f.transpose();
        let noise_rad = if is_gap {
            self.settings.stale_rad_s * seconds
        } else {
            self.settings.gyro_noise_rad_s * seconds
        };
        for k in 0..3 {
            self.covariance[(k, k)] += noise_rad.powi(2);
            self.covariance[(k + 3, k + 3)] += self.settings.gyro_bias_walk.powi(2) * seconds;
        }
        self.nav_from_body *= turn;
        self.nav_from_body.renormalize();
    }

    fn level(&mut self, stamp: Time, sample: &ImuSample) {
        let state = NavState { nav_from_body: self.nav_from_body, ..NavState::default() };
        let std_rad = leveling_std_rad(&sample.rates_rad_s, &self.settings);
        let Some(aid) = leveling(&state, &sample.forces_m_s2, std_rad) else { return };
        let mut h = SMatrix::<f64, 2, 6>::zeros();
        let across: Matrix2x3<f64> = aid.h.fixed_view::<2, 3>(0, 0).into_owned();
        h.fixed_view_mut::<2, 3>(0, 0).copy_from(&across);
        let r: Matrix2<f64> = aid.r;
        let Some(updated) = joseph(&self.covariance, &h, &r, &aid.innovation) else { return };
        if updated.mahalanobis2 > CHI2_95[1] {
            let since = *self.wrong_since.get_or_insert(stamp);
            if stamp - since >= self.settings.level_anew_after {
                self.level_anew(&state, sample);
                return;
            }
            self.n_rejected += 1;
            if self.n_rejected > self.settings.max_rejects {
                self.covariance *= 4.0;
                self.n_rejected = 0;
            }
            return;
        }
        (self.n_rejected, self.wrong_since) = (0, None);
        self.covariance = updated.covariance;
        let part = |at: usize| updated.change.fixed_rows::<3>(at).into_owned();
        self.nav_from_body *= UnitQuaternion::from_scaled_axis(part(0));
        self.gyro_bias_rad_s += part(3);
    }

    /// Somebody turned the robot over: roll and pitch are what gravity says, yaw stays.
    fn level_anew(&mut self, state: &NavState, sample: &ImuSample) {
        let nav_from_body = leveled_from(state, &sample.forces_m_s2);
        self.begin(sample);
        (self.nav_from_body, self.wrong_since, self.n_rejected) = (nav_from_body, None, 0);
    }

    /// The attitude; none before the first sample.
    pub fn nav_from_body(&self) -> Option<UnitQuaternion<f64>> {
        self.last.map(|_| self.nav_from_body)
    }

    /// What the rates are too high by, rad/s.
    pub fn gyro_bias_rad_s(&self) -> Vector3<f64> {
        self.gyro_bias_rad_s
    }

    /// Standard deviation of roll and pitch together, radians.
    pub fn tilt_std_rad(&self) -> f64 {
        let up = self.nav_from_body.inverse() * Vector3::z();
        let attitude = self.covariance.fixed_view::<3, 3>(0, 0).into_owned();
        // What lies along the vertical is yaw.
        (attitude.trace() - (up.transpose() * attitude * up).x).max(0.0).sqrt()
    }
}

/// The numbers are finite and none that a device can give.
pub fn is_reading(sample: &ImuSample, settings: &NavSettings) -> bool {
    let is_finite = sample.rates_rad_s.iter().chain(sample.forces_m_s2.iter()).all(|v| v.is_finite());
    // A device at free fall reads nothing at all; so does one that has no accelerometer.
    is_finite
        && sample.forces_m_s2 != Vector3::zeros()
        && sample.forces_m_s2.norm() <= settings.accel_limit_m_s2
        && sample.rates_rad_s.norm() <= settings.rate_limit_rad_s
}
