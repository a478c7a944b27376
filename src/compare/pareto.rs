//! Which alternatives no other one beats (Pareto 1906): at least as good in every objective, and better in one.

use super::summary::Standing;

/// More success, less time on the missions that all completed, more least clearance, less position error.
pub const OBJECTIVES: [&str; 4] = ["success", "common_time_s", "min_clearance_m", "rms_error_m"];
/// The objectives for people.
pub const OBJECTIVES_IN_WORDS: &str = "success rate, mean time on the missions that all completed, mean least clearance, mean RMS position error";

/// Marks the Pareto set. An alternative without such a time counts as the slowest.
pub fn mark(alternatives: &mut [Standing]) {
    let scores: Vec<[f64; 4]> = alternatives.iter().map(score).collect();
    for (idx, alternative) in alternatives.iter_mut().enumerate() {
        let Some(own) = scores.get(idx) else { continue };
        alternative.is_pareto = !scores.iter().any(|other| beats(other, own));
    }
}

/// All objectives, greater is better; what nobody knows is the worst.
fn score(standing: &Standing) -> [f64; 4] {
    let mean = |key: &str| standing.figures.get(key).map(|estimate| estimate.interval.value);
    let least = |key: &str| mean(key).map_or(f64::NEG_INFINITY, |value| -value);
    [
        standing.success.map_or(f64::NEG_INFINITY, |interval| interval.value),
        standing.common_time_s.map_or(f64::NEG_INFINITY, |time_s| -time_s),
        mean("min_clearance_m").unwrap_or(f64::NEG_INFINITY),
        least("rms_error_m"),
    ]
}

fn beats(one: &[f64; 4], other: &[f64; 4]) -> bool {
    let pairs = || one.iter().zip(other);
    pairs().all(|(a, b)| a >= b) && pairs().any(|(a, b)| a > b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_nowhere_worse_and_somewhere_better_beats() {
        let base = [1.0, -10.0, 0.2, -0.01];
        assert!(!beats(&base, &base));
        assert!(beats(&[1.0, -9.0, 0.2, -0.01], &base));
        assert!(!beats(&[1.0, -9.0, 0.1, -0.01], &base) && !beats(&base, &[1.0, -9.0, 0.1, -0.01]));
        assert!(beats(&base, &[1.0, f64::NEG_INFINITY, 0.2, -0.01]));
    }
}
