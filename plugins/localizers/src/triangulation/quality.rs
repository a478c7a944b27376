//! How much an estimate by two landmarks is worth. Hernández Alamilla (2005), section 5.3.3 to 5.3.5.

use super::pairs::PairEstimate;

/// Landmarks farther than this are worth nothing, meters (equation 5.23).
const REACH_M: f64 = 8.0;
/// Worth of landmarks on both sides of the heading, and on one (equation 5.24, learned in table 5.3).
const SIDES: [f64; 2] = [0.61, 0.39];

/// How the three qualities are put together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Weighting {
    /// Their mean (equation 5.27).
    Mean,
    /// The product, with the dilution of precision squared; pairs whose sine of separation is below the number are dropped.
    /// Differs from the source, whose mean leaves weight to pairs that fix the position in one direction only.
    Product {
        /// Least sine of the separation.
        least_sine: f64,
    },
}

/// The weight of an estimate; zero drops it.
pub fn weight(pair: &PairEstimate, weighting: Weighting) -> f64 {
    // Dilution of precision (equation 5.22): rings around two landmarks cross sharply when these are at a right angle.
    let crossing = pair.separation_rad.sin().abs();
    let nearness = (1.0 - pair.farthest_m / REACH_M).clamp(0.0, 1.0);
    let sides = if pair.on_both_sides { SIDES[0] } else { SIDES[1] };
    match weighting {
        Weighting::Mean => (crossing + nearness + sides) / 3.0,
        Weighting::Product { least_sine } if crossing < least_sine => 0.0,
        Weighting::Product { .. } => crossing * crossing * nearness * sides,
    }
}
