//! What a simulated range finder suffers beyond noise: a time without scans, and scans that are rubbish.

use rand::RngExt as _;
use rumbo_core::messages::LaserScan;
use rumbo_core::rng::Rng;
use rumbo_core::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Faults of whole scans, to see what a pipeline makes of them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScanFaultParams {
    /// No scan comes from this time on, seconds.
    pub silent_from_s: f64,
    /// For so long, seconds; 0 never.
    pub silent_for_s: f64,
    /// Share of scans whose ranges are random numbers within the device's reach.
    pub corrupt: f64,
}

impl ScanFaultParams {
    /// Every impossible value: its key, and what is wrong.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let mut faults = Vec::new();
        for (key, seconds) in [("silent_from_s", self.silent_from_s), ("silent_for_s", self.silent_for_s)] {
            if !(seconds.is_finite() && seconds >= 0.0) {
                faults.push((key, format!("is {seconds}, expected a finite time, 0 or more")));
            }
        }
        if !(0.0..=1.0).contains(&self.corrupt) {
            faults.push(("corrupt", format!("is {}, expected a share from 0 to 1", self.corrupt)));
        }
        faults
    }

    /// Whether the device is silent.
    pub fn is_silent(&self, now: Time) -> bool {
        let silent_s = now.as_secs() - self.silent_from_s;
        (0.0..self.silent_for_s).contains(&silent_s)
    }

    /// Spoils a scan, or not. Draws nothing where no scan is ever spoiled.
    pub fn befall(&self, scan: &mut LaserScan, rng: &mut Rng) {
        if self.corrupt == 0.0 || rng.random::<f64>() >= self.corrupt {
            return;
        }
        let (min_m, max_m) = (scan.min_range_m, scan.max_range_m);
        for range_m in scan.ranges_m.make_mut() {
            *range_m = min_m + (max_m - min_m) * rng.random::<f32>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_device_is_silent_for_its_time_and_never_by_default() {
        let faults = ScanFaultParams { silent_from_s: 10.0, silent_for_s: 30.0, corrupt: 0.0 };
        let silent: Vec<i32> =
            (0..50).filter(|second| faults.is_silent(Time::from_secs(f64::from(*second)))).collect();
        assert_eq!(silent, (10..40).collect::<Vec<_>>());
        assert!(!ScanFaultParams::default().is_silent(Time::ZERO));
    }

    #[test]
    fn the_share_of_spoiled_scans_is_the_one_asked_for() {
        let spoiled = |corrupt: f64| {
            let faults = ScanFaultParams { corrupt, ..ScanFaultParams::default() };
            let mut rng = rumbo_core::rng::stream(1, "laser");
            let n_spoiled = (0..5_000)
                .filter(|_| {
                    let ranges_m = vec![2.0f32; 30].into();
                    let mut scan =
                        LaserScan { ranges_m, min_range_m: 0.1, max_range_m: 8.0, ..LaserScan::default() };
                    faults.befall(&mut scan, &mut rng);
                    assert!(scan.ranges_m.iter().all(|range_m| (0.1..=8.0).contains(range_m)));
                    scan.ranges_m.iter().any(|range_m| *range_m != 2.0)
                })
                .count();
            n_spoiled as f64 / 5_000.0
        };
        assert_eq!(spoiled(0.0), 0.0);
        assert!((spoiled(0.1) - 0.1).abs() < 5.0 * (0.09f64 / 5_000.0).sqrt());
    }

    #[test]
    fn impossible_faults_are_all_told() {
        let bad = ScanFaultParams { silent_from_s: f64::NAN, silent_for_s: -1.0, corrupt: 1.5 };
        let keys: Vec<_> = bad.faults().into_iter().map(|(key, _)| key).collect();
        assert_eq!(keys, ["silent_from_s", "silent_for_s", "corrupt"]);
        assert!(ScanFaultParams::default().faults().is_empty());
    }
}
