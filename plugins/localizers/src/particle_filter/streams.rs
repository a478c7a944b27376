//! Random streams by key: what is drawn depends on the run's seed, the step and the purpose, never on what was drawn
//! before or on how many threads draw.

use rand::Rng as _;
use rand::SeedableRng;
use rumbo_core::rng::Rng;

/// What random numbers are drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The first particles.
    Start,
    /// Noise of the motion.
    Motion,
    /// New particles for old.
    Resampling,
}

/// Makes the streams of one filter.
#[derive(Debug, Clone)]
pub struct Streams {
    key: u64,
}

impl Streams {
    /// Streams that belong to this instance's own stream.
    pub fn new(mut rng: Rng) -> Streams {
        Streams { key: rng.next_u64() }
    }

    /// The stream of one step and purpose.
    pub fn stream(&self, step: u64, purpose: Purpose) -> Rng {
        // The generator's own seeding scrambles neighboring seeds into unrelated states.
        Rng::seed_from_u64(self.key ^ (step.wrapping_mul(4).wrapping_add(purpose as u64)).rotate_left(20))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_step_purpose_and_seed_and_by_nothing_else() {
        let first = |seed: u64, step, purpose| {
            Streams::new(rumbo_core::rng::stream(seed, "localizer")).stream(step, purpose).next_u64()
        };
        let drawn = first(1, 5, Purpose::Motion);
        assert_eq!(drawn, first(1, 5, Purpose::Motion));
        for other in
            [first(2, 5, Purpose::Motion), first(1, 6, Purpose::Motion), first(1, 5, Purpose::Resampling)]
        {
            assert_ne!(drawn, other);
        }
    }
}
