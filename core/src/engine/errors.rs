//! How far off a run was, in room that does not grow with it.

/// Errors of a run of any length: their mean square exactly, their quantiles by samples that are evenly spaced in it, which are
/// all of them in a run that is not very long.
#[derive(Debug, Clone)]
pub struct Errors {
    samples_m: Vec<f32>,
    /// One of so many is a sample.
    every: u64,
    n: u64,
    sum_of_squares_m2: f64,
    last_m: Option<f32>,
}

impl Default for Errors {
    fn default() -> Errors {
        Errors::with_room(Self::ROOM)
    }
}

impl Errors {
    /// Samples at most: ten minutes at 100 steps a second.
    const ROOM: usize = 1 << 16;

    /// Room is taken up front, so that a warm step allocates nothing; and it is written to, since a system counts memory from
    /// the first write on.
    fn with_room(room: usize) -> Errors {
        let mut samples_m = vec![f32::NAN; room];
        samples_m.clear();
        Errors { samples_m, every: 1, n: 0, sum_of_squares_m2: 0.0, last_m: None }
    }

    /// One more.
    pub fn add(&mut self, error_m: f64) {
        // Samples are single: a mean over them and one over all are of the same numbers.
        let error_m = error_m as f32;
        if self.n.is_multiple_of(self.every) {
            if self.samples_m.len() == self.samples_m.capacity() {
                self.thin();
            }
            if self.n.is_multiple_of(self.every) {
                self.samples_m.push(error_m);
            }
        }
        self.n += 1;
        self.sum_of_squares_m2 += f64::from(error_m).powi(2);
        self.last_m = Some(error_m);
    }

    /// Every second sample goes.
    fn thin(&mut self) {
        let mut idx = 0u32;
        self.samples_m.retain(|_| {
            idx += 1;
            idx % 2 == 1
        });
        self.every *= 2;
    }

    /// How many there were.
    pub fn n(&self) -> u64 {
        self.n
    }

    /// The last one, meters.
    pub fn last_m(&self) -> Option<f64> {
        self.last_m.map(f64::from)
    }

    /// Root of the mean square, meters.
    pub fn rms_m(&self) -> Option<f64> {
        (self.n > 0).then(|| (self.sum_of_squares_m2 / self.n as f64).sqrt())
    }

    /// This share of them is not above it, meters.
    pub fn quantile_m(&self, share: f64) -> Option<f64> {
        let mut sorted = self.samples_m.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).map(|error_m| f64::from(*error_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_errors_are_told_exactly() {
        let mut errors = Errors::with_room(100);
        assert_eq!((errors.rms_m(), errors.quantile_m(0.95), errors.last_m()), (None, None, None));
        (1..=100).rev().for_each(|k| errors.add(f64::from(k)));
        assert_eq!((errors.n(), errors.quantile_m(0.95), errors.last_m()), (100, Some(95.0), Some(1.0)));
        assert!((errors.rms_m().unwrap() - 3383.5f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_long_run_needs_no_more_room_and_is_told_by_samples_of_all_of_it() {
        let mut errors = Errors::with_room(100);
        let room = errors.samples_m.capacity();
        let n = 10_000;
        (0..n).for_each(|k| errors.add(f64::from(k)));
        assert_eq!(errors.samples_m.capacity(), room);
        assert_eq!((errors.n(), errors.last_m()), (10_000, Some(9999.0)));
        let evenly = errors.samples_m.iter().enumerate().all(|(k, v)| *v == (k as u64 * errors.every) as f32);
        assert!(evenly && errors.samples_m.len() > 50, "{:?}", errors.samples_m);
        assert!((errors.quantile_m(0.5).unwrap() - 5000.0).abs() < 200.0);
        let mean_square = (0..n).map(|k| f64::from(k).powi(2)).sum::<f64>() / f64::from(n);
        assert!((errors.rms_m().unwrap() - mean_square.sqrt()).abs() < 1e-6);
    }
}
