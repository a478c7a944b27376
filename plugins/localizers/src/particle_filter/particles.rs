//! The particles: columns of numbers, one row a guess of where the robot is.

use rumbo_core::frames::{Pose2, pose2};
use rumbo_kit::resampling::effective_number;

/// Guesses of `map_from_base`, equal in number to their weights.
///
/// Double precision, unlike what the kernels read: a step of a tenth of a millimeter must not get lost far from the
/// map's origin.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Particles {
    /// Along the map's x axis, meters.
    pub x_m: Vec<f64>,
    /// Along the map's y axis, meters.
    pub y_m: Vec<f64>,
    /// Heading, radians; not wrapped.
    pub yaw_rad: Vec<f64>,
    /// Weights; they sum to 1.
    pub weights: Vec<f64>,
}

impl Particles {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.x_m.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.x_m.is_empty()
    }

    /// Takes all of them out.
    pub fn clear(&mut self) {
        [&mut self.x_m, &mut self.y_m, &mut self.yaw_rad, &mut self.weights].into_iter().for_each(Vec::clear);
    }

    /// Adds one whose weight is set later.
    pub fn push(&mut self, [x_m, y_m, yaw_rad]: [f64; 3]) {
        self.x_m.push(x_m);
        self.y_m.push(y_m);
        self.yaw_rad.push(yaw_rad);
    }

    /// x, y, yaw of each.
    pub fn iter(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.x_m.iter().zip(&self.y_m).zip(&self.yaw_rad).map(|((x, y), yaw)| [*x, *y, *yaw])
    }

    /// x, y, yaw of each, to be moved.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = [&mut f64; 3]> + '_ {
        let places = self.x_m.iter_mut().zip(&mut self.y_m);
        places.zip(&mut self.yaw_rad).map(|((x, y), yaw)| [x, y, yaw])
    }

    /// Moves one particle.
    pub fn put(&mut self, idx: usize, [x_m, y_m, yaw_rad]: [f64; 3]) {
        let places = (self.x_m.get_mut(idx), self.y_m.get_mut(idx), self.yaw_rad.get_mut(idx));
        if let (Some(x), Some(y), Some(yaw)) = places {
            (*x, *y, *yaw) = (x_m, y_m, yaw_rad);
        }
    }

    /// One of them as a pose.
    pub fn pose(&self, idx: usize) -> Option<Pose2> {
        Some(pose2(*self.x_m.get(idx)?, *self.y_m.get(idx)?, *self.yaw_rad.get(idx)?))
    }

    /// Gives every particle the same weight.
    pub fn equalize(&mut self) {
        let n = self.len();
        self.weights.clear();
        self.weights.resize(n, 1.0 / n.max(1) as f64);
    }

    /// Multiplies the weights by exp of these numbers and makes them sum to 1. The largest logarithm is taken off
    /// first, so that nothing underflows. A weight that is not a number becomes zero. False, and equal weights, when
    /// nothing is left.
    pub fn reweigh(&mut self, ln_factors: &[f64]) -> bool {
        let usable = |ln: f64| if ln.is_nan() { f64::NEG_INFINITY } else { ln };
        let most = ln_factors.iter().copied().map(usable).fold(f64::NEG_INFINITY, f64::max);
        for (weight, ln) in self.weights.iter_mut().zip(ln_factors) {
            *weight *= (usable(*ln) - most).exp();
            if !weight.is_finite() {
                *weight = 0.0;
            }
        }
        let total: f64 = self.weights.iter().sum();
        if !(most.is_finite() && total > 0.0) {
            self.equalize();
            return false;
        }
        self.weights.iter_mut().for_each(|weight| *weight /= total);
        true
    }

    /// How many equal particles would say as much: 1 / Σ w² (Liu 1996).
    pub fn effective_number(&self) -> f64 {
        effective_number(&self.weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weighed(ln_factors: &[f64]) -> (Particles, bool) {
        let mut particles = Particles::default();
        ln_factors.iter().for_each(|_| particles.push([0.0; 3]));
        particles.equalize();
        let is_weighed = particles.reweigh(ln_factors);
        (particles, is_weighed)
    }

    #[test]
    fn weights_far_below_the_least_number_still_compare() {
        let (particles, is_weighed) = weighed(&[-1e5, -1e5 + 2f64.ln(), f64::NEG_INFINITY]);
        assert!(is_weighed);
        let expected = [1.0 / 3.0, 2.0 / 3.0, 0.0];
        particles.weights.iter().zip(expected).for_each(|(w, e)| assert!((w - e).abs() < 1e-9));
    }

    #[test]
    fn one_weight_that_is_no_number_becomes_zero() {
        let (particles, is_weighed) = weighed(&[0.0, f64::NAN, 0.0]);
        assert_eq!((particles.weights, is_weighed), (vec![0.5, 0.0, 0.5], true));
    }

    #[test]
    fn without_any_usable_weight_all_become_equal_and_this_is_said() {
        for bad in [f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
            assert_eq!(weighed(&[bad; 4]).0.weights, [0.25; 4]);
            assert!(!weighed(&[bad; 4]).1);
        }
        assert!(!weighed(&[]).1);
    }
}
