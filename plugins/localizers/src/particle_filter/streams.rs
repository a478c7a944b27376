//! Random streams by key: what is drawn depends on the run's seed, the step and the purpose, never on what was drawn
//! before or on how many threads draw.

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
pub struct Streams(rumbo_kit::streams::Streams);

impl Streams {
    /// Streams that belong to this instance's own stream.
    pub fn new(rng: Rng) -> Streams {
        Streams(rumbo_kit::streams::Streams::new(rng))
    }

    /// The stream of one step and purpose.
    pub fn stream(&self, step: u64, purpose: Purpose) -> Rng {
        self.0.numbered(step.wrapping_mul(4).wrapping_add(purpose as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng as _;

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
