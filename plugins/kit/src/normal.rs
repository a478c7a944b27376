//! The standard normal distribution: its tails and their inverse.

use std::f64::consts::{FRAC_2_SQRT_PI, PI, SQRT_2};

/// From here on the continued fraction of the error function converges faster than its series.
const SERIES_UP_TO: f64 = 2.0;

/// Probability that a standard normal number is above `z`.
pub fn upper_tail(z: f64) -> f64 {
    let x = z / SQRT_2;
    if x.abs() < SERIES_UP_TO {
        0.5 - 0.5 * error_function(x)
    } else if x > 0.0 {
        0.5 * tail_fraction(x)
    } else {
        1.0 - 0.5 * tail_fraction(-x)
    }
}

/// Probability that a standard normal number is at most `z`.
pub fn cumulative(z: f64) -> f64 {
    upper_tail(-z)
}

/// The number that a standard normal one exceeds with probability `share`; none unless that lies between 0 and 1.
pub fn upper_quantile(share: f64) -> Option<f64> {
    if !(share > 0.0 && share < 1.0) {
        return None;
    }
    // The smallest positive number of double precision is the tail beyond 39 deviations.
    let (mut low, mut high) = (-40.0, 40.0);
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if upper_tail(middle) > share {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some((low + high) / 2.0)
}

/// erf(x) = 2/sqrt(pi) exp(-x²) sum of 2ⁿ x²ⁿ⁺¹ / (2n+1)!!, whose terms all have one sign (Abramowitz and Stegun
/// 1964, equation 7.1.6).
fn error_function(x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (x, x, 0.0);
    while f64::abs(term) > 1e-18 * f64::abs(sum) {
        n += 1.0;
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
    }
    FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

/// erfc(x) for large x by its continued fraction (Abramowitz and Stegun 1964, equation 7.1.14), from the inside out.
fn tail_fraction(x: f64) -> f64 {
    let inner = (1..=60).rev().fold(x, |below, k| x + f64::from(k) / 2.0 / below);
    (-x * x).exp() / (inner * PI.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simpson's rule over the density, from `z` to where nothing is left.
    fn integrated(z: f64) -> f64 {
        let density = |t: f64| (-t * t / 2.0).exp() / (2.0 * PI).sqrt();
        let (n, end) = (20_000, z.max(0.0) + 12.0);
        let step = (end - z) / f64::from(n);
        let inner: f64 =
            (1..n).map(|k| density(z + f64::from(k) * step) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (density(z) + inner + density(end)) * step / 3.0
    }

    #[test]
    fn tails_are_integrals_of_the_density_on_both_sides() {
        for z in [-6.0, -4.3, -1.0, 0.0, 0.3, 2.326, 4.2, 4.3, 6.0] {
            let (found, expected) = (upper_tail(z), integrated(z));
            assert!((found / expected - 1.0).abs() < 1e-11, "{z}: {found} for {expected}");
            assert!((cumulative(z) + found - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn quantiles_undo_tails_and_exist_only_for_probabilities() {
        for share in [1e-12, 0.01, 0.161087, 0.5, 0.9] {
            assert!((upper_tail(upper_quantile(share).unwrap()) / share - 1.0).abs() < 1e-12);
        }
        assert!([0.0, 1.0, -0.1, f64::NAN].into_iter().all(|share| upper_quantile(share).is_none()));
    }
}
