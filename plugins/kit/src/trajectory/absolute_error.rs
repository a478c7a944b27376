//! Absolute trajectory error.

use super::{PosePair, Similarity};

/// The distance of each aligned position from the true one, meters (Sturm et al. 2012, section IV C).
#[doc(alias = "ATE")]
#[doc(alias = "APE")]
pub fn absolute_errors(pairs: &[PosePair], alignment: &Similarity) -> Vec<f64> {
    let error = |pair: &PosePair| {
        let aligned = alignment.apply(&pair.estimate);
        (pair.truth.translation.vector - aligned.translation.vector).norm()
    };
    pairs.iter().map(error).collect()
}
