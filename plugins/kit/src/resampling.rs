//! Resampling: particles with much weight become many, those with little vanish.

/// Why particles cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// There is nothing to draw from.
    #[error("there are no particles")]
    EmptyParticleSet,
    /// Nothing has any weight.
    #[error("all {n} weights are zero")]
    AllWeightsZero {
        /// How many there are.
        n: usize,
    },
    /// A weight that no filter should have made.
    #[error("weight {index} is {weight}, expected at least zero")]
    InvalidWeight {
        /// Which one.
        index: usize,
        /// What it is.
        weight: f64,
    },
}

/// Running sums of weights; a weight that is not a number counts as zero.
///
/// # Errors
/// Without particles, without weight, with a negative weight.
pub fn running_sums(weights: &[f64], sums: &mut Vec<f64>) -> Result<(), ResampleError> {
    sums.clear();
    let mut sum = 0.0;
    for (index, &weight) in weights.iter().enumerate() {
        if weight < 0.0 {
            return Err(ResampleError::InvalidWeight { index, weight });
        }
        if weight.is_finite() {
            sum += weight;
        }
        sums.push(sum);
    }
    match weights.len() {
        0 => Err(ResampleError::EmptyParticleSet),
        n if sum <= 0.0 => Err(ResampleError::AllWeightsZero { n }),
        _ => Ok(()),
    }
}

/// Low-variance (systematic) resampling: `n_out` pointers at equal distances, the first at `share` (0 to 1, without 1)
/// of that distance. Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), table 4.4. Differs from the book: leading
/// particles without weight are skipped also when the first pointer is exactly 0.
///
/// # Errors
/// As [`running_sums`].
pub fn low_variance(weights: &[f64], n_out: usize, share: f64) -> Result<Vec<usize>, ResampleError> {
    let mut sums = Vec::with_capacity(weights.len());
    running_sums(weights, &mut sums)?;
    let step = sums.last().copied().unwrap_or(0.0) / n_out as f64;
    let last = weights.iter().rposition(|weight| *weight > 0.0).unwrap_or(0);
    let mut index = 0;
    let draw = |m: usize| {
        let pointer = (share + m as f64) * step;
        while index < last && (pointer > sums[index] || sums[index] <= 0.0) {
            index += 1;
        }
        index
    };
    Ok((0..n_out).map(draw).collect())
}

/// Independent draws by cumulative search. A table says for equal parts of the total where the search begins, so that a
/// draw takes the same time however many particles there are (Chen and Asau 1974).
#[derive(Debug, Clone, Default)]
pub struct IndependentDraws {
    sums: Vec<f64>,
    guide: Vec<u32>,
}

impl IndependentDraws {
    /// Makes draws by these weights.
    ///
    /// # Errors
    /// As [`running_sums`].
    pub fn prepare(&mut self, weights: &[f64]) -> Result<(), ResampleError> {
        running_sums(weights, &mut self.sums)?;
        let n = self.sums.len();
        let step = self.total() / n as f64;
        self.guide.clear();
        let mut index = 0;
        for part in 0..n {
            while index + 1 < n && self.sums[index] <= part as f64 * step {
                index += 1;
            }
            self.guide.push(index as u32);
        }
        Ok(())
    }

    fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The particle at this share of the total, 0 to 1, without 1. One without weight is never drawn.
    #[inline]
    pub fn at(&self, share: f64) -> usize {
        let n = self.sums.len();
        let part = ((share * n as f64) as usize).min(n - 1);
        let pointer = share * self.total();
        let mut index = self.guide[part] as usize;
        // Rounding of the product above may have put the pointer into the part before.
        while index > 0 && self.sums[index - 1] > pointer {
            index -= 1;
        }
        while index + 1 < n && self.sums[index] <= pointer {
            index += 1;
        }
        index
    }
}

/// How many equal particles would say as much (Liu 1996): 1 / Σ w² of weights that need not sum to 1; 0 without any weight.
pub fn effective_number(weights: &[f64]) -> f64 {
    let (sum, squares) = weights.iter().fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn independent_draws_are_those_of_a_search_from_the_front() {
        let mut rng = rumbo_core::rng::stream(3, "draws");
        for n in [1, 2, 7, 500] {
            let weights: Vec<f64> =
                (0..n).map(|k| if k % 3 == 1 { 0.0 } else { rng.random::<f64>().powi(9) }).collect();
            let mut draws = IndependentDraws::default();
            draws.prepare(&weights).unwrap();
            let mut sums = Vec::new();
            running_sums(&weights, &mut sums).unwrap();
            for _ in 0..2000 {
                let share: f64 = rng.random();
                let expected = sums.iter().position(|sum| *sum > share * sums[n - 1]).unwrap();
                assert_eq!(draws.at(share), expected);
                assert!(weights[draws.at(share)] > 0.0);
            }
        }
    }

    #[test]
    fn shares_at_both_ends_draw_particles_with_weight() {
        let mut draws = IndependentDraws::default();
        draws.prepare(&[0.0, 1.0, 1.0, f64::NAN]).unwrap();
        assert_eq!(draws.at(0.0), 1);
        assert_eq!(draws.at(1.0 - f64::EPSILON / 2.0), 2);
        assert_eq!(low_variance(&[0.0, 1.0, 0.0], 3, 0.0), Ok(vec![1, 1, 1]));
        assert_eq!(low_variance(&[0.0, 1.0, 0.0], 3, 1.0), Ok(vec![1, 1, 1]), "rounding up at the end");
    }
}
