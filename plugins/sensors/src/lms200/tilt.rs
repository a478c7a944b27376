//! Scans of a robot that rocks: its small rear wheel drops into the grooves of a tiled floor, and half of the plane of light
//! rises. Hernández Alamilla (2005), section 8.1; the model is ours.

use rumbo_core::rng::{Rng, RngExt as _};

/// What the tilted half reads too long, as a share of the range.
const TOO_LONG: f32 = 0.03;

/// Tilts a share of the scans: the right or the left half of each. Nothing is drawn where none are.
pub fn tilt(ranges_m: &mut [f32], share: f64, rng: &mut Rng) {
    if share <= 0.0 || rng.random::<f64>() >= share {
        return;
    }
    let middle = ranges_m.len() / 2;
    let half = if rng.random::<bool>() { ranges_m.get_mut(..middle) } else { ranges_m.get_mut(middle..) };
    half.into_iter().flatten().for_each(|range_m| *range_m *= 1.0 + TOO_LONG);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::rng::stream;

    #[test]
    fn one_half_of_a_share_of_the_scans_reads_too_long() {
        let mut rng = stream(1, "tilt");
        let mut n_tilted = [0, 0];
        for _ in 0..2_000 {
            let mut ranges_m = [2.0f32, 2.0, f32::INFINITY, 2.0];
            tilt(&mut ranges_m, 0.1, &mut rng);
            assert_eq!(ranges_m[2], f32::INFINITY);
            assert!(ranges_m[0] == 2.0 || ranges_m[3] == 2.0, "only one half");
            n_tilted[0] += usize::from(ranges_m[0] == 2.06 && ranges_m[1] == 2.06);
            n_tilted[1] += usize::from(ranges_m[3] == 2.06);
        }
        assert!(n_tilted.iter().all(|n| (60..140).contains(n)), "{n_tilted:?}");
        let before = rng.clone();
        tilt(&mut [1.0], 0.0, &mut rng);
        assert_eq!(before, rng, "nothing is drawn");
    }
}
