//! The Kalman update in Joseph form.

use nalgebra::{Const, DimMin, SMatrix, SVector, ToTypenum};

/// 95 % of the squares of one, two and three normal numbers add up to less than these.
pub const CHI2_95: [f64; 3] = [3.841_458_820_694_124, 5.991_464_547_107_979, 7.814_727_903_251_179];

/// An update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Updated<const N: usize> {
    /// What is added to the state.
    pub change: SVector<f64, N>,
    /// The covariance afterwards, symmetric.
    pub covariance: SMatrix<f64, N, N>,
    /// Square of how far the measurement is from what is expected, in standard deviations.
    pub mahalanobis2: f64,
}

/// Takes in a measurement that differs from what is expected by `innovation`, depends on the state by `h`, and has the
/// covariance `r`. None where the covariances are not positive definite, or a number is not finite.
pub fn joseph<const N: usize, const M: usize>(
    covariance: &SMatrix<f64, N, N>,
    h: &SMatrix<f64, M, N>,
    r: &SMatrix<f64, M, M>,
    innovation: &SVector<f64, M>,
) -> Option<Updated<N>>
where
    Const<M>: DimMin<Const<M>, Output = Const<M>> + ToTypenum,
{
    let by_state = covariance * h.transpose();
    let expected = h * by_state + r;
    let cholesky = ((expected + expected.transpose()) * 0.5).cholesky()?;
    let gain_t = cholesky.solve(&by_state.transpose());
    let gain = gain_t.transpose();
    let mahalanobis2 = innovation.dot(&cholesky.solve(innovation));
    // (I - K H) P (I - K H)ᵀ + K R Kᵀ, without products of large matrices: it is P - A - Aᵀ + K S Kᵀ with A = K (P Hᵀ)ᵀ.
    let both = gain * by_state.transpose();
    let middle = gain * expected * gain_t;
    let updated = covariance - both - both.transpose() + middle;
    let change = gain * innovation;
    let is_finite = change.iter().chain(updated.iter()).all(|v| v.is_finite()) && mahalanobis2.is_finite();
    let covariance = (updated + updated.transpose()) * 0.5;
    is_finite.then_some(Updated { change, covariance, mahalanobis2 })
}
