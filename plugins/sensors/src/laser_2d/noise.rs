//! Noise of a range finder. An open family: other crates add models.

use std::fmt::Debug;

use rand::RngExt as _;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::rng::Rng;
use serde::{Deserialize, Serialize};

/// How readings differ from exact ranges.
#[typetag::serde(tag = "model")]
pub trait ScanNoise: Debug + Send + Sync {
    /// The reading of a beam whose exact range (finite, meters) is given; not-a-number for a beam that is lost.
    fn read(&self, exact_m: f64, rng: &mut Rng) -> f64;
    /// How far a beam points from where it is said to point, radians.
    fn bearing_error_rad(&self, rng: &mut Rng) -> f64;
    /// Whether [`bearing_error_rad`](Self::bearing_error_rad) is ever anything but zero; exact bearings are much faster.
    fn bends_beams(&self) -> bool;
    /// What is wrong with the parameters: key and message.
    fn faults(&self) -> Vec<(&'static str, String)>;
    /// A copy.
    fn boxed_clone(&self) -> Box<dyn ScanNoise>;
}

impl Clone for Box<dyn ScanNoise> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// Independent normal errors of range and bearing, and beams lost at random (`model = "gaussian"`).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GaussianNoise {
    /// Standard deviation of the range, meters.
    pub range_m: f64,
    /// Part of the standard deviation that grows with the range, meters per meter.
    pub range_share: f64,
    /// Standard deviation of each beam's bearing, degrees.
    pub bearing_deg: f64,
    /// Share of beams that give no reading.
    pub dropout: f64,
}

#[typetag::serde(name = "gaussian")]
impl ScanNoise for GaussianNoise {
    fn read(&self, exact_m: f64, rng: &mut Rng) -> f64 {
        if self.dropout > 0.0 && rng.random::<f64>() < self.dropout {
            return f64::NAN;
        }
        let normal: f64 = StandardNormal.sample(rng);
        exact_m + normal * (self.range_m + self.range_share * exact_m)
    }

    fn bearing_error_rad(&self, rng: &mut Rng) -> f64 {
        let normal: f64 = StandardNormal.sample(rng);
        normal * self.bearing_deg.to_radians()
    }

    fn bends_beams(&self) -> bool {
        self.bearing_deg > 0.0
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        let Self { range_m, range_share, bearing_deg, dropout } = *self;
        let at_least_0 = [("range_m", range_m), ("range_share", range_share), ("bearing_deg", bearing_deg)];
        let mut faults: Vec<_> = at_least_0
            .into_iter()
            .filter(|(_, value)| !(value.is_finite() && *value >= 0.0))
            .map(|(key, value)| (key, format!("is {value}, expected a finite number, 0 or more")))
            .collect();
        if !(0.0..=1.0).contains(&dropout) {
            faults.push(("dropout", format!("is {dropout}, expected a share from 0 to 1")));
        }
        faults
    }

    fn boxed_clone(&self) -> Box<dyn ScanNoise> {
        Box::new(*self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_have_the_mean_deviation_and_losses_asked_for() {
        let noise = GaussianNoise { range_m: 0.01, range_share: 0.002, bearing_deg: 0.3, dropout: 0.1 };
        let mut rng = rumbo_core::rng::stream(1, "laser");
        let n = 40_000;
        let readings: Vec<f64> = (0..n).map(|_| noise.read(5.0, &mut rng)).collect();
        let kept: Vec<f64> = readings.into_iter().filter(|reading| !reading.is_nan()).collect();
        let lost = 1.0 - kept.len() as f64 / f64::from(n);
        assert!((lost - 0.1).abs() < 5.0 * (0.09 / f64::from(n)).sqrt(), "{lost}");
        check_normal(&kept, 5.0, 0.02);
        let bearings: Vec<f64> = (0..n).map(|_| noise.bearing_error_rad(&mut rng)).collect();
        check_normal(&bearings, 0.0, 0.3f64.to_radians());
    }

    /// Mean and deviation within five standard errors; 4.55 percent beyond two deviations.
    fn check_normal(values: &[f64], mean: f64, deviation: f64) {
        let n = values.len() as f64;
        let found = values.iter().sum::<f64>() / n;
        assert!((found - mean).abs() < 5.0 * deviation / n.sqrt(), "mean {found}");
        let spread = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((spread / deviation - 1.0).abs() < 5.0 / (2.0 * n).sqrt(), "deviation {spread}");
        let far = values.iter().filter(|value| (*value - mean).abs() > 2.0 * deviation).count() as f64 / n;
        assert!((far - 0.0455).abs() < 5.0 * (0.0455 / n).sqrt(), "{far} beyond two deviations");
    }

    #[test]
    fn impossible_noise_is_named() {
        let bad =
            GaussianNoise { range_m: -1.0, range_share: f64::NAN, bearing_deg: f64::INFINITY, dropout: 1.5 };
        let keys: Vec<_> = bad.faults().into_iter().map(|(key, _)| key).collect();
        assert_eq!(keys, ["range_m", "range_share", "bearing_deg", "dropout"]);
        assert!(GaussianNoise::default().faults().is_empty());
    }
}
