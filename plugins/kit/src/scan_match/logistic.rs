//! Log-odds to probabilities, without a call into the mathematics library: compilers turn it into wide vectors.

use crate::simd;

/// Beyond these log-odds single precision knows no other probability.
const LARGEST: f32 = 80.0;

/// `1 / (1 + exp(-log_odds))` to two millionths of its value.
#[inline(always)]
pub fn logistic(log_odds: f32) -> f32 {
    1.0 / (1.0 + exp(-log_odds))
}

/// `2^n * 2^f` with a whole `n` and `f` within half of zero: the first by the bits of the exponent, the second by its
/// Taylor series.
#[inline(always)]
fn exp(x: f32) -> f32 {
    let bounded = x.clamp(-LARGEST, LARGEST);
    let power = bounded * std::f32::consts::LOG2_E;
    let whole = (power + 0.5).floor();
    let t = (power - whole) * std::f32::consts::LN_2;
    let series =
        1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + t * (1.0 / 24.0 + t * (1.0 / 120.0 + t / 720.0)))));
    let scale = f32::from_bits(simd::whole(whole + 127.0) << 23);
    series * scale
}

#[cfg(test)]
mod tests {
    use super::logistic;

    #[test]
    fn it_is_the_logistic_function() {
        for k in -4000..=4000 {
            let log_odds = k as f32 * 0.005;
            let exact = 1.0 / (1.0 + (-f64::from(log_odds)).exp());
            let found = f64::from(logistic(log_odds));
            assert!((found - exact).abs() < 2e-6 * exact, "{log_odds}: {found}, expected {exact}");
        }
        assert_eq!(logistic(0.0), 0.5);
        assert!(logistic(f32::INFINITY) == 1.0 && logistic(f32::NEG_INFINITY) < 1e-30);
    }
}
