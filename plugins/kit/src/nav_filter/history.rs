//! The filter at one moment, how it goes on to the next, and the moments of the last second.

use std::collections::VecDeque;

use nalgebra::{Const, DimMin, SMatrix, ToTypenum, Vector3};
use rumbo_core::time::{Span, Time};

use super::aids::{
    Aid, AidKind, is_gravity, leveled_from, leveling, leveling_std_rad, no_flying, no_sliding, without_curve,
    zero_rate, zero_velocity,
};
use super::filter::{LEAST, START_M_S};
use super::model::{
    ACCEL_BIAS, ATTITUDE, AnchorCross, Covariance, GRAVITY_M_S2, GYRO_BIAS, ImuSample, NavState, POSITION,
    VELOCITY, carried, jacobian, noise, propagate,
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

    fn sway(&mut self, mean: &ImuSample, seconds: f64) {
        let up = self.state.nav_from_body.inverse() * Vector3::z();
        // Not less the bias: where that is wrong, a body must not seem to sway.
        let lean_rad = (mean.rates_rad_s - up * up.dot(&mean.rates_rad_s)).norm() * LEAN_S;
        let lean2 = (lean_rad - QUIET_RAD).max(0.0).powi(2);
        self.lean2 += (lean2 - self.lean2) * (seconds / SWAY_S).min(1.0);
    }

    /// Uses what is known without a measurement from outside, where it is time for that.
    fn aid(&mut self, settings: &NavSettings, tally: &mut Tally) {
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

/// The moments of the last second, oldest first; the last one is now.
#[derive(Debug, Clone, Default)]
pub struct History {
    moments: VecDeque<Moment>,
}

impl History {
    /// A second of 1000 samples, and as many measurements in between.
    const MOST: usize = 2048;

    /// Now; none before the first sample.
    pub fn now(&self) -> Option<&Moment> {
        self.moments.back()
    }

    /// The same, to change.
    pub fn now_mut(&mut self) -> Option<&mut Moment> {
        self.moments.back_mut()
    }

    /// Goes on, and forgets what is older than `kept`.
    pub fn push(&mut self, moment: Moment, kept: Span) {
        let oldest = moment.stamp - kept;
        self.moments.push_back(moment);
        while self.moments.len() > 2 && self.moments.get(1).is_some_and(|next| next.stamp <= oldest)
            || self.moments.len() > Self::MOST
        {
            self.moments.pop_front();
        }
    }

    /// Only this moment.
    pub fn begin(&mut self, moment: Moment) {
        self.moments.clear();
        self.moments.push_back(moment);
    }

    /// The moment of any stamp: between two samples by the samples in between, beyond the last one by that one, and none
    /// before all that is known. With its place among the moments.
    pub fn at(&self, stamp: Time, settings: &NavSettings) -> Option<(usize, Moment)> {
        let after = self.moments.partition_point(|moment| moment.stamp <= stamp);
        let before = self.moments.get(after.checked_sub(1)?)?;
        if before.stamp == stamp {
            return Some((after - 1, before.clone()));
        }
        if stamp - before.stamp > settings.max_gap && after == self.moments.len() {
            return None;
        }
        let sample = self.moments.get(after).map_or(before.sample, |next| {
            let share = (stamp - before.stamp).as_secs() / (next.stamp - before.stamp).as_secs();
            ImuSample {
                rates_rad_s: before.sample.rates_rad_s.lerp(&next.sample.rates_rad_s, share),
                forces_m_s2: before.sample.forces_m_s2.lerp(&next.sample.forces_m_s2, share),
            }
        });
        Some((after, before.next(stamp, &sample, settings, &mut Tally::default())))
    }

    /// Puts a changed moment in its place, as [`at`](Self::at) told it, and goes once more through all that came later.
    pub fn revise(&mut self, place: usize, moment: Moment, settings: &NavSettings) {
        let is_known = self.moments.get(place).is_some_and(|known| known.stamp == moment.stamp);
        match self.moments.get_mut(place).filter(|_| is_known) {
            Some(known) => *known = moment,
            None => self.moments.insert(place.min(self.moments.len()), moment),
        }
        for idx in place + 1..self.moments.len() {
            let (Some(before), Some(later)) = (self.moments.get(idx - 1), self.moments.get(idx)) else {
                return;
            };
            // What was refused was counted the first time.
            let mut again = Moment { is_standing: later.is_standing, ..before.clone() };
            again = again.next(later.stamp, &later.sample, settings, &mut Tally::default());
            if let Some(later) = self.moments.get_mut(idx) {
                *later = again;
            }
        }
    }

    /// Forgets all that is older than this place.
    pub fn forget_before(&mut self, place: usize) {
        self.moments.drain(..place.min(self.moments.len().saturating_sub(1)));
    }

    /// How many moments are kept.
    pub fn len(&self) -> usize {
        self.moments.len()
    }
}
