//! The moments of the last second.

use std::collections::VecDeque;

use rumbo_core::time::{Span, Time};

use super::model::ImuSample;
use super::moment::{Moment, Tally};
use super::settings::NavSettings;

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
