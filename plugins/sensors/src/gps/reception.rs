//! How a receiver errs, and when it hears nothing.

use rand::RngExt as _;
use rumbo_core::rng::Rng;
use rumbo_core::time::Time;

/// Errors of a receiver: even between bounds, anew each time, as in Valverde Moreno (2015), section 4.2.2; beside that a
/// constant one.
#[derive(Debug, Clone, PartialEq)]
pub struct ReceptionModel {
    /// Bound of the even error along each axis, meters.
    pub error_m: f64,
    /// The same all the time, meters.
    pub bias_m: [f64; 3],
    /// Share of fixes that never come.
    pub dropout: f64,
    /// From the first of these times until before the second there is no fix.
    pub outages: Vec<[Time; 2]>,
}

/// What comes of a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reception {
    /// The receiver says that it is here, meters.
    Fix([f64; 3]),
    /// It says that it does not know where it is.
    NoFix,
    /// It says nothing.
    Nothing,
}

impl ReceptionModel {
    /// What the receiver says when its antenna is here. Takes as many random numbers each time, so that a share that
    /// changes leaves the errors of all other fixes as they are.
    pub fn receive(&self, antenna_m: [f64; 3], now: Time, rng: &mut Rng) -> Reception {
        let errors: [f64; 3] = std::array::from_fn(|_| self.error_m * (2.0 * rng.random::<f64>() - 1.0));
        let is_lost = rng.random::<f64>() < self.dropout;
        if is_lost {
            return Reception::Nothing;
        }
        if self.outages.iter().any(|[from, to]| (*from..*to).contains(&now)) {
            return Reception::NoFix;
        }
        let mut fix_m = antenna_m;
        for ((fix_m, error_m), bias_m) in fix_m.iter_mut().zip(errors).zip(self.bias_m) {
            *fix_m += error_m + bias_m;
        }
        Reception::Fix(fix_m)
    }

    /// Standard deviation along each axis of an even error between these bounds, meters.
    pub fn deviation_m(error_m: f64) -> f64 {
        error_m / 3f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: ReceptionModel =
        ReceptionModel { error_m: 5.0, bias_m: [0.0; 3], dropout: 0.0, outages: Vec::new() };

    fn errors(model: &ReceptionModel, n: usize) -> Vec<[f64; 3]> {
        let mut rng = rumbo_core::rng::stream(3, "gps");
        (0..n)
            .filter_map(|_| match model.receive([0.0; 3], Time::ZERO, &mut rng) {
                Reception::Fix(fix_m) => Some(fix_m),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn errors_are_even_between_their_bounds_and_centered_on_the_bias() {
        let bias_m = [1.0, -2.0, 0.5];
        let read = errors(&ReceptionModel { bias_m, ..MODEL }, 40_000);
        for axis in 0..3 {
            let centered = || read.iter().map(|fix_m| fix_m[axis] - bias_m[axis]);
            let n = read.len() as f64;
            let mean = centered().sum::<f64>() / n;
            let variance = centered().map(|error| error * error).sum::<f64>() / n;
            // A mean of 40,000 deviates by 0.014.
            assert!(mean.abs() < 0.06, "{mean}");
            assert!((variance / (25.0 / 3.0) - 1.0).abs() < 0.02, "{variance}");
            assert!((ReceptionModel::deviation_m(5.0).powi(2) - 25.0 / 3.0).abs() < 1e-12);
            // A quarter of them lies in each quarter of the range, which only an even distribution has.
            for quarter in 0..4 {
                let low = -5.0 + 2.5 * f64::from(quarter);
                let n_there = centered().filter(|error| (low..low + 2.5).contains(error)).count() as f64;
                assert!((n_there / n - 0.25).abs() < 0.01);
            }
        }
    }

    #[test]
    fn fixes_get_lost_as_often_as_asked_for_and_leave_the_others_as_they_are() {
        let all = errors(&MODEL, 20_000);
        let some = errors(&ReceptionModel { dropout: 0.3, ..MODEL }, 20_000);
        assert!((some.len() as f64 / 20_000.0 - 0.7).abs() < 0.012, "{}", some.len());
        assert!(some.iter().all(|fix_m| all.contains(fix_m)));
    }

    #[test]
    fn there_is_no_fix_from_the_beginning_of_an_outage_until_its_end() {
        let outages = vec![[Time::from_secs(1.0), Time::from_secs(2.0)]];
        let model = ReceptionModel { outages, ..MODEL };
        let mut rng = rumbo_core::rng::stream(3, "gps");
        let mut at = |seconds| model.receive([0.0; 3], Time::from_secs(seconds), &mut rng);
        assert!(matches!(at(0.9), Reception::Fix(_)));
        assert_eq!((at(1.0), at(1.9)), (Reception::NoFix, Reception::NoFix));
        assert!(matches!(at(2.0), Reception::Fix(_)));
    }
}
