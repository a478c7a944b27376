//! How much of a scan the map explains.

/// A reading this near to what the map lets expect agrees with it: meters, and per meter of range (beams that graze walls
/// and a heading that is slightly off move far readings by more).
const NEAR: (f64, f64) = (0.15, 0.03);
/// Fewer beams say nothing.
const LEAST_BEAMS: usize = 20;

/// Share of the beams with a reading that meet what the map lets expect, or meet something where the map has a wall. None
/// if the map says nothing on most: `expected` is not-a-number where nobody knows and infinite where nothing is met.
pub fn explained_share(
    expected_m: &[f64],
    seen_m: &[f32],
    min_range_m: f64,
    max_range_m: f64,
) -> Option<f64> {
    let (mut n, mut n_explained) = (0_usize, 0_usize);
    for (expected, seen) in expected_m.iter().zip(seen_m) {
        let seen = f64::from(*seen);
        let is_reading = seen >= min_range_m && seen < max_range_m;
        if expected.is_nan() || seen.is_nan() || !(is_reading || expected.is_finite()) {
            continue;
        }
        n += 1;
        let is_near = expected.is_finite() && (seen - expected).abs() <= NEAR.0 + NEAR.1 * expected;
        n_explained += usize::from(is_reading && is_near);
    }
    (n >= LEAST_BEAMS).then(|| n_explained as f64 / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_beams_that_meet_what_is_expected() {
        let expected = vec![2.0; 40];
        let mut seen = vec![2.1_f32; 40];
        let share = |expected: &[f64], seen: &[f32]| explained_share(expected, seen, 0.05, 8.0);
        assert_eq!(share(&expected, &seen), Some(1.0));
        seen[..10].fill(1.0);
        seen[10..20].fill(f32::INFINITY);
        assert_eq!(share(&expected, &seen), Some(0.5), "somebody before a wall, and a wall that is gone");
        seen[20..30].fill(f32::NAN);
        assert_eq!(share(&expected, &seen), Some(1.0 / 3.0), "beams without an answer say nothing");
        assert_eq!(share(&[f64::NAN; 40], &seen), None, "nor does an unknown map");
        assert_eq!(share(&[f64::INFINITY; 40], &[f32::INFINITY; 40]), None, "nor an empty place");
        assert_eq!(share(&[f64::INFINITY; 40], &[3.0; 40]), Some(0.0));
    }
}
