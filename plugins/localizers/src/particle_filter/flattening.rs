//! How far one update's likelihood is flattened, so that a few lucky guesses do not rule out all others.

/// The power, at most 1, of the factors exp(ln) that leaves an effective number of at least `least` particles.
///
/// With few guesses for a large building the nearest one is still off by more than the sensor's noise, and the
/// likelihood of a lucky wrong place would rule out the true one: annealing (Deutscher, Blake, Reid 2000) with the power
/// chosen by the effective number, as samplers do (Jasra, Stephens, Doucet, Tsagaris 2011).
pub fn flattening(weights: &[f64], ln_factors: &[f64], least: f64) -> f64 {
    let most = ln_factors.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let effective = |power: f64| {
        let factored = weights.iter().zip(ln_factors).map(|(w, ln)| w * ((ln - most) * power).exp());
        let finite = factored.filter(|w| w.is_finite());
        let (sum, squares) = finite.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
        sum * sum / squares
    };
    let effective_now = effective(1.0);
    // Weights that are no numbers are left to others.
    if least <= 0.0 || !most.is_finite() || effective_now.is_nan() || effective_now >= least {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..FLATTENING_ROUNDS {
        let middle = (low + high) / 2.0;
        if effective(middle) < least { high = middle } else { low = middle }
    }
    low
}

/// The power is good to a part in so many powers of 2.
const FLATTENING_ROUNDS: u32 = 6;
