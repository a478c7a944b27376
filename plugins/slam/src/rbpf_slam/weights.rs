//! Weights of particles from their logarithms.

/// Weights that sum to 1, from logarithms that are multiplied by `gain`: below 1 it flattens them, so that one scan does not
/// decide (the beams of a scan are not independent). A logarithm that is not a number has no weight. None where nothing
/// has any.
pub fn normalized(ln_weights: &[f64], gain: f64) -> Option<Vec<f64>> {
    let usable = |ln: &f64| if ln.is_nan() { f64::NEG_INFINITY } else { *ln };
    let most = ln_weights.iter().map(usable).fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return None;
    }
    let weights: Vec<f64> = ln_weights.iter().map(|ln| (gain * (usable(ln) - most)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    Some(weights.iter().map(|weight| weight / sum).collect())
}

/// How much logarithms of weights are flattened.
pub fn gain(ogain: f64, n_particles: usize) -> f64 {
    if ogain > 0.0 { 1.0 / (ogain * n_particles as f64) } else { 1.0 }
}

/// The greatest of these numbers, the first of equals.
pub fn best(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (idx, value) in values.enumerate() {
        if value > best.1 {
            best = (idx, value);
        }
    }
    best.0
}
