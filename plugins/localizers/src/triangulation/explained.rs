//! How much of a scan the map explains.

/// A reading this near to what the map lets expect agrees with it: meters, and per meter of range (beams that graze walls
/// and a heading that is slightly off move far readings by more).
const NEAR: (f64, f64) = (0.15, 0.03);
/// Fewer beams say nothing.
const LEAST_BEAMS: usize = 20;

/// Of the beams that get as far as what the map lets expect, the share that meet it; the others went through a wall. Beams
/// that end before it met somebody or a shut door, which speaks for no other place. None where too few beams say anything:
/// `expected` is not-a-number where nobody knows and infinite where nothing is met.
pub fn explained_share(
    expected_m: &[f64],
    seen_m: &[f32],
    min_range_m: f64,
    max_range_m: f64,
) -> Option<f64> {
    let (mut n, mut n_explained) = (0_usize, 0_usize);
    for (expected, seen) in expected_m.iter().zip(seen_m) {
        let seen = f64::from(*seen);
        let near_m = NEAR.0 + NEAR.1 * expected;
        if !expected.is_finite() || seen.is_nan() || seen < min_range_m || seen < expected - near_m {
            continue;
        }
        n += 1;
        n_explained += usize::from(seen < max_range_m && seen <= expected + near_m);
    }
    (n >= LEAST_BEAMS).then(|| n_explained as f64 / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_beams_that_meet_what_they_get_as_far_as() {
        let expected = vec![2.0; 40];
        let mut seen = vec![2.1_f32; 40];
        let share = |expected: &[f64], seen: &[f32]| explained_share(expected, seen, 0.05, 8.0);
        assert_eq!(share(&expected, &seen), Some(1.0));
        seen[..10].fill(1.0);
        seen[10..20].fill(f32::INFINITY);
        assert_eq!(
            share(&expected, &seen),
            Some(2.0 / 3.0),
            "somebody before a wall, and a wall that is gone"
        );
        seen[20..30].fill(f32::NAN);
        assert_eq!(share(&expected, &seen), Some(0.5), "beams without an answer say nothing");
        seen[10..].fill(1.0);
        assert_eq!(share(&expected, &seen), None, "a shut door hides all of it");
        assert_eq!(share(&[f64::NAN; 40], &seen), None, "nor does an unknown map");
        assert_eq!(share(&[f64::INFINITY; 40], &[f32::INFINITY; 40]), None, "nor an empty place");
        assert_eq!(share(&[f64::INFINITY; 40], &[3.0; 40]), None);
    }
}
