//! The filter at one moment, and how it goes on to the next.

use nalgebra::{Const, DimMin, SMatrix, ToTypenum};
use rumbo_core::time::{Span, Time};

use super::aids::{Aid, AidKind};
use super::model::{
    ATTITUDE, AnchorCross, Covariance, ImuSample, NavState, POSITION, VELOCITY, carried, jacobian, noise,
    propagate,
};
use super::settings::NavSettings;
use super::update::{CHI2_95, Updated, joseph};

/// What happened on the way from one moment to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Updates that are too far from what is expected.
    pub n_rejected: u64,
    /// Updates after which the covariance was none.
    pub n_not_positive: u64,
}

/// The filter at one moment.
#[derive(Debug, Clone)]
pub struct Moment {
    /// When.
    pub stamp: Time,
    /// What the device read then.
    pub sample: ImuSample,
    /// The state.
    pub state: NavState,
    /// Its covariance.
    pub covariance: Covariance,
    /// What its errors have in common with those of the anchor: a bias turns one step as it turned those before.
    pub by_anchor: AnchorCross,
    /// The robot stands, as somebody knows.
    pub is_standing: bool,
    /// When an aid was last used.
    pub last_aid: Option<Time>,
    /// Updates refused in a row, of each kind: that others fit is no comfort.
    pub n_refused: [u32; AidKind::COUNT],
    /// Since when gravity has said all the time that the attitude is wrong.
    pub wrong_since: Option<Time>,
    /// Mean square of how the body leans on its wheels as it sways, by how fast it rolls and pitches, rad².
    pub lean2: f64,
}

impl Moment {
    /// The moment of the next sample. Over a gap nothing is integrated, and all is less sure.
    pub fn next(&self, stamp: Time, sample: &ImuSample, settings: &NavSettings, tally: &mut Tally) -> Moment {
        let gap = stamp - self.stamp;
        let mut next = Moment { stamp, sample: *sample, ..self.clone() };
        if gap > settings.max_gap {
            next.sit_out(gap, settings);
        } else {
            let seconds = gap.as_secs();
            let mean = ImuSample {
                rates_rad_s: (self.sample.rates_rad_s + sample.rates_rad_s) * 0.5,
                forces_m_s2: (self.sample.forces_m_s2 + sample.forces_m_s2) * 0.5,
            };
            let f = jacobian(&self.state, &mean, seconds);
            let walks = [settings.gyro_bias_walk.powi(2), settings.accel_bias_walk.powi(2)];
            let devices = [settings.gyro_noise_rad_s, settings.accel_noise_m_s2];
            next.covariance = carried(&f, &self.covariance) + noise(seconds, devices, walks);
            next.by_anchor = self.by_anchor * f.transpose();
            next.state = propagate(&self.state, &mean, seconds);
            next.sway(&mean, seconds);
        }
        next.aid(settings, tally);
        next
    }

    /// Nobody knows what happened in a gap.
    fn sit_out(&mut self, gap: Span, settings: &NavSettings) {
        let seconds = gap.as_secs();
        let change_m_s = settings.max_acceleration_m_s2 * seconds;
        let way_m = self.state.velocity_m_s.norm() * seconds + 0.5 * change_m_s * seconds;
        for k in 0..3 {
            self.covariance[(VELOCITY + k, VELOCITY + k)] += change_m_s.powi(2);
            self.covariance[(POSITION + k, POSITION + k)] += way_m.powi(2);
            self.covariance[(ATTITUDE + k, ATTITUDE + k)] += (settings.stale_rad_s * seconds).powi(2);
        }
    }

    /// An update by a measurement whose errors have nothing to do with those of the state. Returns whether it was used.
    pub fn update<const M: usize>(
        &mut self,
        kind: AidKind,
        aid: &Aid<M>,
        settings: &NavSettings,
        tally: &mut Tally,
    ) -> bool
    where
        Const<M>: DimMin<Const<M>, Output = Const<M>> + ToTypenum,
    {
        let updated = joseph(&self.covariance, &aid.h, &aid.r, &aid.innovation);
        let gate = CHI2_95.get(M - 1).copied().unwrap_or(f64::INFINITY);
        if updated.as_ref().is_some_and(|updated| updated.mahalanobis2 > gate) {
            self.refuse(kind, settings, tally);
            return false;
        }
        self.n_refused[kind as usize] = 0;
        self.take(updated.as_ref(), &aid.h, &aid.r, tally)
    }

    /// Takes a Kalman update over. The anchor stays where it is; what it has in common with the state gets less.
    pub fn take<const M: usize>(
        &mut self,
        updated: Option<&Updated<15>>,
        h: &SMatrix<f64, M, 15>,
        r: &SMatrix<f64, M, M>,
        tally: &mut Tally,
    ) -> bool {
        // The gain is P⁺ Hᵀ R⁻¹.
        let Some(weighted) = r.cholesky().map(|r| r.solve(h)) else { return self.adopt(None, tally) };
        let is_used = self.adopt(updated, tally);
        if is_used {
            self.by_anchor -= self.by_anchor * h.transpose() * weighted * self.covariance;
        }
        is_used
    }

    /// An update was refused: after too many in a row the filter was too sure of itself.
    fn refuse(&mut self, kind: AidKind, settings: &NavSettings, tally: &mut Tally) {
        tally.n_rejected += 1;
        let n_refused = &mut self.n_refused[kind as usize];
        *n_refused += 1;
        if *n_refused > settings.max_rejects {
            self.covariance *= 4.0;
            *n_refused = 0;
        }
    }

    /// Takes an update over; one that leaves no covariance is as if it had not been, and the filter is less sure.
    pub fn adopt(&mut self, updated: Option<&Updated<15>>, tally: &mut Tally) -> bool {
        let state = updated.map(|updated| self.state.plus(&updated.change));
        let good = updated
            .zip(state)
            .filter(|(updated, state)| state.is_finite() && updated.covariance.cholesky().is_some());
        match good {
            Some((updated, state)) => {
                (self.state, self.covariance) = (state, updated.covariance);
                true
            }
            None => {
                self.covariance *= 2.0;
                tally.n_not_positive += 1;
                false
            }
        }
    }
}
