//! KLD-sampling: as many particles as the spread of the belief asks for.
//!
//! D. Fox, *KLD-Sampling: Adaptive Particle Filters* (NIPS 2001): with this many particles the distance between the
//! belief and its histogram over `k` occupied bins stays below epsilon with probability 1 - delta. The chi-square
//! quantile is approximated as in equation (7) there (Wilson and Hilferty 1931).

use rumbo_kit::normal::upper_quantile;

/// Particles that `bins` occupied bins ask for, `z` being the upper 1 - delta quantile of the standard normal; 0 for one
/// bin or none.
pub fn sample_size(bins: usize, epsilon: f64, z: f64) -> f64 {
    if bins < 2 {
        return 0.0;
    }
    let k = (bins - 1) as f64;
    let a = 2.0 / (9.0 * k);
    k / (2.0 * epsilon) * (1.0 - a + a.sqrt() * z).powi(3)
}

/// The rule with its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KldBound {
    /// Largest distance between the belief and its histogram, in nats.
    pub epsilon: f64,
    /// Quantile of the standard normal.
    pub z: f64,
    /// At least so many particles.
    pub min_particles: usize,
    /// At most so many.
    pub max_particles: usize,
}

impl KldBound {
    /// The rule for a distance that is exceeded with probability `delta`; none unless that is a probability.
    pub fn new(epsilon: f64, delta: f64, min_particles: usize, max_particles: usize) -> Option<KldBound> {
        Some(KldBound { epsilon, z: upper_quantile(delta)?, min_particles, max_particles })
    }

    /// Particles for so many occupied bins.
    pub fn particles(&self, bins: usize) -> usize {
        let n = sample_size(bins, self.epsilon, self.z).ceil() as usize;
        n.clamp(self.min_particles, self.max_particles)
    }
}
