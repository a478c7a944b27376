//! One seeded random stream for each stage instance: xoshiro256++ (Blackman and Vigna, 2019), which gives the same
//! numbers on every platform and in every version of this framework.

/// Draws numbers from a stream (`rng.random_range(-1.0..1.0)`): a plugin names it from here, and so in the version that
/// fits.
pub use rand::RngExt;

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// The random stream a plugin gets.
pub type Rng = Xoshiro256PlusPlus;

/// The stream of the instance `name` in a run with `seed`: streams of different names are unrelated, and adding a
/// stage to a pipeline leaves the others' numbers as they were.
pub fn stream(seed: u64, name: &str) -> Rng {
    // FNV-1a (Fowler, Noll, Vo): a fixed, published hash; the standard library's may change between releases.
    let hash =
        name.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    Rng::seed_from_u64(seed ^ hash.rotate_left(17))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng as _;

    #[test]
    fn the_first_numbers_of_a_stream_never_change() {
        let mut rng = stream(7, "front_laser");
        let first: Vec<u64> = (0..2).map(|_| rng.next_u64()).collect();
        let mut again = stream(7, "front_laser");
        assert_eq!(first, (0..2).map(|_| again.next_u64()).collect::<Vec<_>>());
        assert_ne!(first[0], stream(8, "front_laser").next_u64());
        assert_ne!(first[0], stream(7, "rear_laser").next_u64());
    }
}
