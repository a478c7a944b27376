//! Random streams by number: what is drawn depends on the run's seed and on the number, never on what was drawn before or
//! on how many threads draw.

use rand::Rng as _;
use rand::SeedableRng;
use rumbo_core::rng::Rng;

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

    /// The streams that another instance had, from its [`key`](Self::key).
    pub fn of_key(key: u64) -> Streams {
        Streams { key }
    }

    /// What makes these streams differ from those of another instance.
    pub fn key(&self) -> u64 {
        self.key
    }

    /// The stream of this number.
    pub fn numbered(&self, number: u64) -> Rng {
        // The generator's own seeding scrambles neighboring seeds into unrelated states.
        Rng::seed_from_u64(self.key ^ number.rotate_left(20))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_number_and_seed_and_by_nothing_else() {
        let first =
            |seed: u64, number| Streams::new(rumbo_core::rng::stream(seed, "it")).numbered(number).next_u64();
        assert_eq!(first(1, 5), first(1, 5));
        assert_ne!(first(1, 5), first(2, 5));
        assert_ne!(first(1, 5), first(1, 6));
        let streams = Streams::new(rumbo_core::rng::stream(1, "it"));
        assert_eq!(Streams::of_key(streams.key()).numbered(5).next_u64(), first(1, 5));
    }
}
