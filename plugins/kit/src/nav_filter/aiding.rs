//! What a moment knows without a measurement from outside: which way is up, that the robot stands, that it does not slide.

use nalgebra::Vector3;

use super::aids::{
    AidKind, is_gravity, leveled_from, leveling, leveling_std_rad, no_flying, no_sliding, without_curve,
    zero_rate, zero_velocity,
};
use super::filter::{LEAST, START_M_S};
use super::model::{ACCEL_BIAS, ATTITUDE, GRAVITY_M_S2, GYRO_BIAS, ImuSample, VELOCITY};
use super::moment::{Moment, Tally};
use super::settings::NavSettings;

/// What a body that sways leans by, for each rad/s: that of half a period a second, as bodies on springs and tires do.
const LEAN_S: f64 = 1.0 / std::f64::consts::PI;
/// How long a body is said to sway after it did, seconds.
const SWAY_S: f64 = 1.0;
/// A robot slower than this cannot have sped up for long, m/s.
const SLOW_M_S: f64 = 0.2;
/// A velocity less sure than this is not measured by anybody, m/s.
const UNSURE_M_S: f64 = 0.3;
/// A body that rolls and pitches less than this is quiet, as leans: rad.
const QUIET_RAD: f64 = 0.02;

/// So often is an aid used while what makes it wrong stays the same.
fn n_alike(settings: &NavSettings) -> f64 {
    (SWAY_S / settings.aid_period.as_secs()).max(1.0)
}

impl Moment {
    /// How the body leans, by how fast it rolls and pitches.
    pub(super) fn sway(&mut self, mean: &ImuSample, seconds: f64) {
        let up = self.state.nav_from_body.inverse() * Vector3::z();
        // Not less the bias: where that is wrong, a body must not seem to sway.
        let lean_rad = (mean.rates_rad_s - up * up.dot(&mean.rates_rad_s)).norm() * LEAN_S;
        let lean2 = (lean_rad - QUIET_RAD).max(0.0).powi(2);
        self.lean2 += (lean2 - self.lean2) * (seconds / SWAY_S).min(1.0);
    }

    /// Uses what is known without a measurement from outside, where it is time for that.
    pub(super) fn aid(&mut self, settings: &NavSettings, tally: &mut Tally) {
        if self.last_aid.is_some_and(|last| self.stamp - last < settings.aid_period) {
            return;
        }
        self.last_aid = Some(self.stamp);
        let sample = self.sample;
        self.level(&sample, settings, tally);
        if self.is_standing {
            let aid = zero_velocity(&self.state, settings.standing_m_s);
            self.update(AidKind::Standing, &aid, settings, tally);
            if self.lean2 < 0.01 * QUIET_RAD.powi(2) {
                let std_rad_s = settings.gyro_noise_rad_s.hypot(settings.standing_rad_s);
                let aid = zero_rate(&self.state, &sample.rates_rad_s, std_rad_s);
                self.update(AidKind::Rates, &aid, settings, tally);
            }
            return;
        }
        // A body that leans on its wheels moves along the floor, not along itself. It leans alike for as long as it is said to
        // sway: that is one measurement, not one for each time it is used.
        let leaning_m_s = self.state.velocity_m_s.norm() * (self.lean2 * n_alike(settings)).sqrt();
        let vertical_m_s = settings.body_vertical_m_s.hypot(leaning_m_s);
        // And says nothing about its own attitude by that.
        match settings.body_lateral_m_s {
            Some(lateral_m_s) => {
                let mut aid = no_sliding(&self.state, lateral_m_s, vertical_m_s);
                aid.h.fixed_view_mut::<1, 3>(1, ATTITUDE).fill(0.0);
                self.update(AidKind::Sliding, &aid, settings, tally)
            }
            None => {
                let mut aid = no_flying(&self.state, vertical_m_s);
                aid.h.fixed_view_mut::<1, 3>(0, ATTITUDE).fill(0.0);
                self.update(AidKind::Sliding, &aid, settings, tally)
            }
        };
    }

    /// Gravity says which way is up. Where it says for long that this is wrong, somebody turned the robot over.
    fn level(&mut self, sample: &ImuSample, settings: &NavSettings, tally: &mut Tally) {
        // How sure the velocity is, is how sure what holds the body on its curve is. Whose velocity nobody measures, has nothing
        // but gravity.
        let velocity_m_s = self.covariance.fixed_view::<3, 3>(VELOCITY, VELOCITY).trace().sqrt();
        let known = (1.0 - velocity_m_s / UNSURE_M_S).max(0.0);
        let forces = without_curve(&self.state, sample, known);
        if !is_gravity(&forces, settings) {
            self.wrong_since = None;
            return;
        }
        let curve_rad = sample.rates_rad_s.norm() * velocity_m_s.min(START_M_S) / GRAVITY_M_S2;
        let mut std_rad = leveling_std_rad(&sample.rates_rad_s, settings).hypot(curve_rad);
        // A robot that moves may speed up or brake, and that lasts; one that is still slow cannot have done so for long.
        if !self.is_standing {
            let moves = (self.state.velocity_m_s.norm() / SLOW_M_S).min(1.0);
            std_rad *= (1.0 + (n_alike(settings) - 1.0) * (moves * known).powi(2)).sqrt();
        }
        let Some(aid) = leveling(&self.state, &forces, std_rad) else { return };
        if self.update(AidKind::Leveling, &aid, settings, tally) {
            self.wrong_since = None;
            return;
        }
        let since = *self.wrong_since.get_or_insert(self.stamp);
        if self.is_standing || self.stamp - since >= settings.level_anew_after {
            self.level_anew(sample, settings);
        }
    }

    /// The attitude as gravity says it, with the yaw that it had; what was known of the velocity was known by the attitude.
    fn level_anew(&mut self, sample: &ImuSample, settings: &NavSettings) {
        self.state.nav_from_body = leveled_from(&self.state, &sample.forces_m_s2);
        self.wrong_since = None;
        self.n_refused = [0; AidKind::COUNT];
        for (at, variance) in [
            (ATTITUDE, settings.leveling_std_rad.powi(2)),
            (VELOCITY, if self.is_standing { settings.standing_m_s } else { START_M_S }.powi(2)),
            (GYRO_BIAS, settings.gyro_bias_rad_s.powi(2).max(LEAST)),
            (ACCEL_BIAS, settings.accel_bias_m_s2.powi(2).max(LEAST)),
        ] {
            self.covariance.fixed_rows_mut::<3>(at).fill(0.0);
            self.covariance.fixed_columns_mut::<3>(at).fill(0.0);
            self.by_anchor.fixed_columns_mut::<3>(at).fill(0.0);
            (at..at + 3).for_each(|k| self.covariance[(k, k)] = variance);
        }
        self.state.velocity_m_s = Vector3::zeros();
        self.state.accel_bias_m_s2 = Vector3::zeros();
    }
}
