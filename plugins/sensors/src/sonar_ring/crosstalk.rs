//! Crosstalk: a transducer takes the ping of its neighbor for its own (Borenstein and Koren 1995, *Error eliminating rapid
//! ultrasonic firing for mobile robot obstacle avoidance*, on why rings that fire at once read too short).
//!
//! The model is ours and simple: both pings leave at once, the neighbor's goes out its own way and comes back the way of
//! the one that hears it.

use rand::RngExt as _;
use rumbo_core::rng::Rng;

/// What a transducer reads that hears its neighbor's ping: half of both ways together. Where nothing answers in its own
/// cone, it hears the echo that the neighbor hears; where nothing answers the neighbor, there is nothing to hear.
pub fn mixed_m(own_m: f32, neighbor_m: f32) -> f32 {
    match (own_m.is_finite(), neighbor_m.is_finite()) {
        (true, true) => (own_m + neighbor_m) / 2.0,
        (false, true) => neighbor_m,
        (_, false) => own_m,
    }
}

/// Lets this share of the transducers hear one of their neighbors; `exact_m` has what all would read alone.
pub fn mix(exact_m: &[f32], share: f64, rng: &mut Rng, heard_m: &mut [f32]) {
    if share <= 0.0 || exact_m.len() < 2 {
        return;
    }
    for (idx, heard) in heard_m.iter_mut().enumerate() {
        if rng.random::<f64>() >= share {
            continue;
        }
        let step = if rng.random::<bool>() { 1 } else { exact_m.len() - 1 };
        if let Some(neighbor) = exact_m.get((idx + step) % exact_m.len()) {
            *heard = mixed_m(*heard, *neighbor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::rng;

    const NONE: f32 = f32::INFINITY;

    #[test]
    fn half_of_both_ways_is_heard_and_silence_adds_nothing() {
        assert_eq!(mixed_m(3.0, 1.0), 2.0);
        assert_eq!(mixed_m(1.0, 3.0), 2.0);
        assert_eq!(mixed_m(NONE, 1.5), 1.5);
        assert_eq!((mixed_m(1.5, NONE), mixed_m(NONE, NONE)), (1.5, NONE));
    }

    #[test]
    fn the_share_is_kept_and_both_neighbors_are_heard_by_all_around_the_ring() {
        let exact = [2.0, 4.0, 8.0, 16.0];
        let (mut rng, mut n_mixed) = (rng::stream(3, "crosstalk"), 0);
        let mut found = [[false; 2]; 4];
        for _ in 0..10_000 {
            let mut heard = exact;
            mix(&exact, 0.1, &mut rng, &mut heard);
            for k in 0..4 {
                for (side, neighbor) in [exact[(k + 1) % 4], exact[(k + 3) % 4]].into_iter().enumerate() {
                    found[k][side] |= heard[k] == (exact[k] + neighbor) / 2.0;
                }
                n_mixed += u32::from(heard[k] != exact[k]);
            }
        }
        assert_eq!(found, [[true; 2]; 4]);
        // Four standard deviations of 40,000 draws.
        assert!((f64::from(n_mixed) - 4000.0).abs() < 240.0, "{n_mixed}");
    }

    #[test]
    fn without_crosstalk_nothing_is_drawn() {
        let (mut rng, mut untouched) = (rng::stream(3, "crosstalk"), rng::stream(3, "crosstalk"));
        let mut heard = [1.0, 2.0];
        mix(&[1.0, 2.0], 0.0, &mut rng, &mut heard);
        mix(&[1.0], 1.0, &mut rng, &mut heard[..1]);
        assert_eq!(heard, [1.0, 2.0]);
        assert_eq!(rng.random::<u64>(), untouched.random::<u64>());
    }
}
