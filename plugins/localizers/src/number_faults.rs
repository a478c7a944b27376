//! What is wrong with the numbers of a section.

use rumbo_core::stages::BuildError;

/// A fault for each number, by its key, that is not finite, or below zero; then for each that is not above zero.
pub fn number_faults<'a>(
    at_least_0: impl IntoIterator<Item = (&'a str, f64)>,
    above_0: impl IntoIterator<Item = (&'a str, f64)>,
) -> Vec<BuildError> {
    let fault = |key: &str, value: f64, expected: &str| {
        BuildError::at(key, format!("is {value}, expected a finite number {expected}"))
    };
    let not_least = at_least_0.into_iter().filter(|(_, value)| !(*value >= 0.0 && value.is_finite()));
    let not_above = above_0.into_iter().filter(|(_, value)| !(*value > 0.0 && value.is_finite()));
    let least = not_least.map(|(key, value)| fault(key, value, "of at least zero"));
    least.chain(not_above.map(|(key, value)| fault(key, value, "above zero"))).collect()
}
