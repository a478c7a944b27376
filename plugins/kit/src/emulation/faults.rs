//! What goes wrong on a line: bytes get lost, bits flip, somebody pulls the plug.

use rumbo_core::rng::{self, Rng, RngExt as _};
use rumbo_core::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Faults of a line, in both directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LineFaultParams {
    /// Share of bytes that get lost.
    pub loss: f64,
    /// Share of bytes in which one bit is its opposite.
    pub flips: f64,
    /// The plug is pulled once in so many seconds; 0 never.
    pub unplug_every_s: f64,
    /// It stays pulled so long, seconds.
    pub unplug_for_s: f64,
}

impl Default for LineFaultParams {
    fn default() -> Self {
        Self { loss: 0.0, flips: 0.0, unplug_every_s: 0.0, unplug_for_s: 1.0 }
    }
}

impl LineFaultParams {
    /// Every impossible value: its key, and what is wrong.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let mut faults = Vec::new();
        for (key, share) in [("loss", self.loss), ("flips", self.flips)] {
            if !(0.0..=1.0).contains(&share) {
                faults.push((key, format!("is {share}, expected a share from 0 to 1")));
            }
        }
        let every_s = self.unplug_every_s;
        if !(every_s.is_finite() && every_s >= 0.0) {
            faults.push(("unplug_every_s", format!("is {every_s}, expected a finite time, 0 for never")));
        }
        let for_s = self.unplug_for_s;
        if !(for_s.is_finite() && for_s > 0.0) {
            faults.push(("unplug_for_s", format!("is {for_s}, expected a finite time above 0")));
        } else if every_s > 0.0 && for_s >= every_s {
            let message = format!("is {for_s}, expected less than unplug_every_s, which is {every_s}");
            faults.push(("unplug_for_s", message));
        }
        faults
    }
}

/// A line with faults that come by chance.
#[derive(Debug, Clone)]
pub struct LineFaults {
    params: LineFaultParams,
    rng: Rng,
}

impl LineFaults {
    /// Faults of the line called `name`: the same seed and name give the same faults.
    pub fn new(params: LineFaultParams, seed: u64, name: &str) -> Self {
        Self { params, rng: rng::stream(seed, name) }
    }

    /// The plug is pulled: at the end of each period.
    pub fn is_unplugged(&self, now: Time) -> bool {
        let LineFaultParams { unplug_every_s, unplug_for_s, .. } = self.params;
        unplug_every_s > 0.0 && now.as_secs().rem_euclid(unplug_every_s) >= unplug_every_s - unplug_for_s
    }

    /// What arrives of bytes that were sent.
    pub fn befall(&mut self, bytes: &mut Vec<u8>) {
        let LineFaultParams { loss, flips, .. } = self.params;
        if loss == 0.0 && flips == 0.0 {
            return;
        }
        bytes.retain_mut(|byte| {
            if self.rng.random::<f64>() < flips {
                *byte ^= 1 << self.rng.random_range(0..8);
            }
            self.rng.random::<f64>() >= loss
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_that_were_asked_for_and_the_seed_repeats_them() {
        let params = LineFaultParams { loss: 0.1, flips: 0.2, ..LineFaultParams::default() };
        let passed = |seed| {
            let mut bytes = vec![0u8; 100_000];
            LineFaults::new(params, seed, "line").befall(&mut bytes);
            bytes
        };
        let bytes = passed(1);
        assert!((bytes.len() as f64 / 100_000.0 - 0.9).abs() < 0.005, "{}", bytes.len());
        let n_flipped = bytes.iter().filter(|byte| byte.count_ones() == 1).count();
        assert!((n_flipped as f64 / bytes.len() as f64 - 0.2).abs() < 0.006, "{n_flipped}");
        assert!(bytes.iter().all(|byte| byte.count_ones() <= 1));
        assert_eq!(bytes, passed(1));
        assert_ne!(bytes, passed(2));
    }

    #[test]
    fn the_plug_is_out_at_the_end_of_each_period() {
        let params = LineFaultParams { unplug_every_s: 10.0, unplug_for_s: 2.0, ..Default::default() };
        let line = LineFaults::new(params, 1, "line");
        let out: Vec<usize> = (0..25).filter(|k| line.is_unplugged(Time::from_secs(*k as f64))).collect();
        assert_eq!(out, [8, 9, 18, 19]);
        let never = LineFaults::new(LineFaultParams::default(), 1, "line");
        assert!(!never.is_unplugged(Time::from_secs(1e6)));
    }

    #[test]
    fn impossible_faults_are_all_told() {
        let params =
            LineFaultParams { loss: 1.5, flips: f64::NAN, unplug_every_s: -1.0, unplug_for_s: f64::INFINITY };
        let keys: Vec<&str> = params.faults().into_iter().map(|(key, _)| key).collect();
        assert_eq!(keys, ["loss", "flips", "unplug_every_s", "unplug_for_s"]);
        let long = LineFaultParams { unplug_every_s: 1.0, ..LineFaultParams::default() };
        assert_eq!(long.faults()[0].0, "unplug_for_s");
        assert!(LineFaultParams::default().faults().is_empty());
    }
}
