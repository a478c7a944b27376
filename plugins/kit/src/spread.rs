//! A set of errors as a few numbers.

use serde::Serialize;

/// What people ask of a set of errors; the unit is that of the errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// How many errors there are.
    pub n: usize,
    /// Root of the mean square.
    pub rmse: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// The middle one, of an even number the mean of the middle two.
    pub median: f64,
    /// Standard deviation of the whole set (divided by n, not n - 1).
    pub std: f64,
    /// The least.
    pub min: f64,
    /// The greatest.
    pub max: f64,
}

impl Spread {
    /// The numbers of a set; none of an empty one.
    pub fn of(mut errors: Vec<f64>) -> Option<Spread> {
        errors.sort_by(f64::total_cmp);
        let (&min, &max) = errors.first().zip(errors.last())?;
        let n = errors.len();
        let mean = errors.iter().sum::<f64>() / n as f64;
        let mean_of = |value: fn(f64) -> f64, offset: f64| {
            errors.iter().map(|error| value(error - offset)).sum::<f64>() / n as f64
        };
        let rmse = mean_of(|error| error * error, 0.0).sqrt();
        let std = mean_of(|error| error * error, mean).sqrt();
        let middle = errors.get((n - 1) / 2..=n / 2)?;
        let median = middle.iter().sum::<f64>() / middle.len() as f64;
        Some(Spread { n, rmse, mean, median, std, min, max })
    }
}

/// The value that `share` (0 to 1) of a sorted set does not exceed; none of an empty one.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_a_set_are_those_by_hand() {
        let odd = Spread::of(vec![3.0, 1.0, 2.0]).unwrap();
        assert_eq!((odd.n, odd.mean, odd.median, odd.min, odd.max), (3, 2.0, 2.0, 1.0, 3.0));
        assert!((odd.rmse - (14.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert!((odd.std - (2.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(Spread::of(vec![4.0, 1.0, 2.0, 9.0]).unwrap().median, 3.0);
        let one = Spread::of(vec![5.0]).unwrap();
        assert_eq!((one.rmse, one.median, one.std), (5.0, 5.0, 0.0));
        assert_eq!(Spread::of(Vec::new()), None);
    }

    #[test]
    fn a_quantile_is_the_least_value_that_enough_others_do_not_exceed() {
        let set: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(quantile(&set, 0.95), Some(19.0));
        assert_eq!((quantile(&set, 0.0), quantile(&set, 1.0)), (Some(1.0), Some(20.0)));
        assert_eq!(quantile(&[], 0.5), None);
    }
}
