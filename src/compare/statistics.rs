//! Intervals and means of small samples. The formulas are three lines each and need nothing but the framework's own
//! seeded stream; a statistics crate would add its distributions and a second kind of random numbers for them.

use rand_xoshiro::rand_core::Rng as _;
use rumbo_core::rng::stream;
use serde::Serialize;

/// Resamples of one interval: enough for two figures of a 95 % bound (Efron and Tibshirani 1993, section 13.3).
pub const N_RESAMPLES: usize = 1000;
/// The standard normal quantile of 0.975.
const Z_95: f64 = 1.959_963_984_540_054;

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// A share of trials with its score interval (Wilson, *Journal of the American Statistical Association* 22, 1927), which
/// keeps its promise for small samples and near 0 and 1; none without trials.
pub fn wilson(n_successes: usize, n_trials: usize) -> Option<Interval> {
    if n_trials == 0 {
        return None;
    }
    let (n, share) = (n_trials as f64, n_successes as f64 / n_trials as f64);
    let z2 = Z_95 * Z_95;
    let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    let (low, high) = ((middle - half).max(0.0), (middle + half).min(1.0));
    // Rounding must not push the bounds of "none" and "all" off their ends.
    let low = if n_successes == 0 { 0.0 } else { low };
    let high = if n_successes == n_trials { 1.0 } else { high };
    Some(Interval { value: share, low, high })
}

/// The change of a share from the first to the second of paired trials, with the interval of Newcombe (*Statistics in
/// Medicine* 17, 1998, pages 2635 to 2650, method 10): Wilson's intervals of both shares, put together with their
/// correlation. It has width also where every pair agrees, since a few pairs that agree prove little. None without pairs.
pub fn paired_change(pairs: &[(bool, bool)]) -> Option<Interval> {
    let count = |first: bool, second: bool| pairs.iter().filter(|pair| **pair == (first, second)).count();
    let (both, only_second, only_first) = (count(true, true), count(false, true), count(true, false));
    let neither = count(false, false);
    let (second, first) = (wilson(both + only_second, pairs.len())?, wilson(both + only_first, pairs.len())?);
    let value = second.value - first.value;
    let correlation = correlation([both, only_second, only_first, neither].map(|n| n as f64));
    let joined = |a: f64, b: f64| (a * a - 2.0 * correlation * a * b + b * b).max(0.0).sqrt();
    Some(Interval {
        value,
        low: value - joined(second.value - second.low, first.high - first.value),
        high: value + joined(second.high - second.value, first.value - first.low),
    })
}

/// Correlation of the cells of a two by two table, with the continuity correction of Newcombe's method 10.
fn correlation([both, only_second, only_first, neither]: [f64; 4]) -> f64 {
    let n = both + only_second + only_first + neither;
    let product =
        (both + only_second) * (only_first + neither) * (both + only_first) * (only_second + neither);
    if product <= 0.0 {
        return 0.0;
    }
    let cross = both * neither - only_second * only_first;
    let corrected = if cross > 0.0 { (cross - n / 2.0).max(0.0) } else { cross };
    corrected / product.sqrt()
}

/// The mean; none of nothing.
pub fn mean(sample: &[f64]) -> Option<f64> {
    (!sample.is_empty()).then(|| sample.iter().sum::<f64>() / sample.len() as f64)
}

/// The value below which a share `p` of the sample lies, between neighbors by a straight line (definition 7 of Hyndman
/// and Fan, *The American Statistician* 50, 1996). `sorted` goes up.
pub fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let place = p.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (sorted.get(place.floor() as usize)?, sorted.get(place.ceil() as usize)?);
    Some(below + (above - below) * place.fract())
}

/// The mean with its percentile bootstrap interval (Efron 1979; Efron and Tibshirani 1993, chapter 13); none of nothing.
/// Samples of the same size and `name` are drawn alike, whatever else is compared.
pub fn bootstrap_mean(sample: &[f64], name: &str) -> Option<Interval> {
    let value = mean(sample)?;
    let n = sample.len() as u64;
    let mut rng = stream(0, name);
    let mut means: Vec<f64> = (0..N_RESAMPLES)
        .map(|_| {
            // The high part of a product draws without the bias of a remainder.
            let drawn = (0..n).map(|_| ((u128::from(rng.next_u64()) * u128::from(n)) >> 64) as usize);
            let sum: f64 = drawn.filter_map(|idx| sample.get(idx)).sum();
            sum / n as f64
        })
        .collect();
    means.sort_unstable_by(f64::total_cmp);
    Some(Interval { value, low: quantile(&means, 0.025)?, high: quantile(&means, 0.975)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64, within: f64) {
        assert!((found - expected).abs() <= within, "{found}, expected {expected}");
    }

    #[test]
    fn score_intervals_are_those_of_newcombe() {
        // Newcombe, *Statistics in Medicine* 17 (1998), table I, method 3.
        for (r, n, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson(r, n).unwrap();
            near(found.low, low, 5e-5);
            near(found.high, high, 5e-5);
        }
        let all = wilson(20, 20).unwrap();
        near(all.low, 1.0 - 0.1611, 5e-5);
        assert_eq!((all.high, wilson(0, 0)), (1.0, None));
    }

    #[test]
    fn paired_changes_are_those_of_newcombe() {
        // Newcombe (1998, pages 2635 to 2650), method 10: 36 pairs with both, 12 with the second, 2 with the first only.
        let kinds = [((true, true), 36), ((false, true), 12), ((true, false), 2)];
        let pairs: Vec<_> = kinds.into_iter().flat_map(|(kind, n)| vec![kind; n]).collect();
        let found = paired_change(&pairs).unwrap();
        near(found.value, 0.2, 1e-12);
        near(found.low, 0.0569, 5e-5);
        near(found.high, 0.3404, 5e-5);
    }

    #[test]
    fn pairs_that_all_agree_leave_room_for_a_difference() {
        let all = paired_change(&[(true, true); 20]).unwrap();
        assert_eq!(all.value, 0.0);
        // Wilson's bound of 20 of 20 on either side, and nothing is known of a correlation.
        near(all.high, 0.1611, 5e-5);
        near(all.low, -0.1611, 5e-5);
        assert_eq!(paired_change(&[]), None);
    }

    #[test]
    fn quantiles_lie_between_neighbors() {
        let sample = [1.0, 2.0, 3.0, 4.0];
        assert_eq!((quantile(&sample, 0.5), quantile(&sample, 0.25)), (Some(2.5), Some(1.75)));
        assert_eq!((quantile(&sample, 0.0), quantile(&sample, 1.0)), (Some(1.0), Some(4.0)));
        assert_eq!((quantile(&[], 0.5), quantile(&[7.0], 0.9)), (None, Some(7.0)));
    }

    #[test]
    fn a_bootstrap_of_zeros_and_ones_is_the_binomial_one() {
        // Resampled means of 50 zeros and 50 ones are Binomial(100, 1/2) / 100, with quantiles 0.40 and 0.60.
        let sample: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
        let found = bootstrap_mean(&sample, "coin").unwrap();
        assert_eq!(found.value, 0.5);
        near(found.low, 0.40, 0.011);
        near(found.high, 0.60, 0.011);
        assert_eq!(bootstrap_mean(&sample, "coin"), Some(found));
    }

    #[test]
    fn a_bootstrap_of_a_constant_has_no_width_and_of_nothing_no_value() {
        let flat = bootstrap_mean(&[2.5; 8], "flat").unwrap();
        assert_eq!((flat.value, flat.low, flat.high), (2.5, 2.5, 2.5));
        assert_eq!(bootstrap_mean(&[], "empty"), None);
    }
}
