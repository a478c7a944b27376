//! The update of the Kalman filter for measurements that depend on a few numbers of the state.

use super::covariance::Covariance;
use super::state::State;
use nalgebra::{Cholesky, DMatrix, DVector};

/// One measured number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Columns of the state that it depends on, and how (a row of H); unused ones have the weight zero.
    columns: [usize; 6],
    weights: [f64; 6],
    /// What was measured less what was expected.
    pub innovation: f64,
    /// Variance of the measurement (diagonal of R).
    pub variance: f64,
    /// Covariance with the next measured number (beside the diagonal of R).
    pub covariance_with_next: f64,
}

impl Row {
    /// A number that depends on at most six columns.
    pub fn new(weights: &[(usize, f64)], innovation: f64, variance: f64) -> Row {
        let mut row =
            Row { columns: [0; 6], weights: [0.0; 6], innovation, variance, covariance_with_next: 0.0 };
        let places = row.columns.iter_mut().zip(&mut row.weights);
        for ((at, by), (column, weight)) in places.zip(weights) {
            (*at, *by) = (*column, *weight);
        }
        row
    }

    /// The same with this covariance with the next measured number.
    pub fn correlated(mut self, covariance_with_next: f64) -> Row {
        self.covariance_with_next = covariance_with_next;
        self
    }

    /// Columns with their weights.
    pub fn entries(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.columns.iter().copied().zip(self.weights).filter(|(_, weight)| *weight != 0.0)
    }
}

/// The covariance of the innovations is none: nothing was changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the covariance of the innovations is not positive definite")]
pub struct NotPositiveDefinite;

/// All that is measured at one moment, against a state that has not changed since its innovations were computed.
#[derive(Debug, Clone)]
pub struct Update {
    /// P H^T, one column a measured number.
    seen: DMatrix<f64>,
    /// Inverse of S = H P H^T + R.
    inverse: DMatrix<f64>,
    innovation: DVector<f64>,
}

impl Update {
    /// Looks at measurements without taking them in.
    ///
    /// # Errors
    /// Their covariance is none.
    pub fn new(state: &State, rows: &[Row]) -> Result<Update, NotPositiveDefinite> {
        let seen = observed(&state.covariance, state.covariance.size(), rows);
        let mut innovations = innovation_covariance(rows, &seen);
        add_noise(&mut innovations, rows);
        let is_finite = rows.iter().all(|row| row.innovation.is_finite());
        let factor = Cholesky::new(innovations).filter(|_| is_finite).ok_or(NotPositiveDefinite)?;
        let innovation = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.innovation));
        Ok(Update { seen, inverse: factor.inverse(), innovation })
    }

    /// Squared Mahalanobis distance of the innovations, z^T S⁻¹ z.
    pub fn distance2(&self) -> f64 {
        (&self.inverse * &self.innovation).dot(&self.innovation)
    }

    /// The gain K = P H^T S⁻¹ of the first rows of the state.
    pub fn gain(&self, n_rows: usize) -> DMatrix<f64> {
        self.seen.rows(0, n_rows) * &self.inverse
    }

    /// Takes the measurements in, with the gain of the robot only where the walls are known (then the walls' errors are
    /// considered and not corrected: Schmidt 1966). `rows` are those that this was made from.
    ///
    /// The covariance becomes `(I - K H) P (I - K H)^T + K R K^T`, Joseph's form, which holds for any gain: first
    /// `P <- (I - K H) P`, then `P <- P - (P H^T - K R) K^T`.
    pub fn fuse(&self, state: &mut State, rows: &[Row], is_map_known: bool) {
        let n_columns = state.covariance.size();
        let n_moving = state.n_moving();
        let n_gained = if is_map_known { n_moving } else { n_columns };
        let gain = self.gain(n_gained);
        let step = &gain * &self.innovation;
        let numbers = state.robot.iter_mut().chain(&mut state.odometer);
        for (number, step) in numbers.chain(state.walls.iter_mut().flatten()).zip(step.iter()) {
            *number += step;
        }
        state.wrap();
        let mut covariance = state.covariance.view_mut();
        covariance.view_mut((0, 0), (n_gained, n_columns)).gemm(-1.0, &gain, &self.seen.transpose(), 1.0);
        let mut rest = observed(&state.covariance, n_gained, rows);
        subtract_noise(&mut rest, &gain, rows);
        subtract_lower(&mut state.covariance, &rest, &gain.transpose());
        state.covariance.mirror_lower(n_gained);
        if is_map_known {
            let mut covariance = state.covariance.view_mut();
            let cross = covariance.view((0, n_moving), (n_moving, n_columns - n_moving)).transpose();
            covariance.view_mut((n_moving, 0), (n_columns - n_moving, n_moving)).copy_from(&cross);
        }
    }
}

/// P H^T for the first rows of P: only the columns that are measured are read.
fn observed(covariance: &Covariance, n_rows: usize, rows: &[Row]) -> DMatrix<f64> {
    let covariance = covariance.view();
    let mut seen = DMatrix::zeros(n_rows, rows.len());
    for (row, mut column) in rows.iter().zip(seen.column_iter_mut()) {
        for (at, weight) in row.entries() {
            column.axpy(weight, &covariance.view((0, at), (n_rows, 1)).column(0), 1.0);
        }
    }
    seen
}

/// H (P H^T), made symmetric.
fn innovation_covariance(rows: &[Row], seen: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(rows.len(), rows.len());
    for (col, row) in rows.iter().enumerate() {
        for (other, value) in product.column_mut(col).iter_mut().enumerate() {
            *value = row.entries().map(|(at, weight)| weight * seen[(at, other)]).sum();
        }
    }
    let transposed = product.transpose();
    (product + transposed) * 0.5
}

fn add_noise(innovations: &mut DMatrix<f64>, rows: &[Row]) {
    for (k, row) in rows.iter().enumerate() {
        innovations[(k, k)] += row.variance;
        if row.covariance_with_next != 0.0 && k + 1 < rows.len() {
            innovations[(k, k + 1)] += row.covariance_with_next;
            innovations[(k + 1, k)] += row.covariance_with_next;
        }
    }
}

/// Subtracts K R.
fn subtract_noise(rest: &mut DMatrix<f64>, gain: &DMatrix<f64>, rows: &[Row]) {
    for (k, row) in rows.iter().enumerate() {
        rest.column_mut(k).axpy(-row.variance, &gain.column(k), 1.0);
        if row.covariance_with_next != 0.0 && k + 1 < rows.len() {
            rest.column_mut(k).axpy(-row.covariance_with_next, &gain.column(k + 1), 1.0);
            rest.column_mut(k + 1).axpy(-row.covariance_with_next, &gain.column(k), 1.0);
        }
    }
}

/// Columns that are worked on at once.
const BLOCK: usize = 64;

/// Subtracts a product from the lower triangle of the first rows and columns.
fn subtract_lower(covariance: &mut Covariance, left: &DMatrix<f64>, right: &DMatrix<f64>) {
    let size = left.nrows();
    let mut covariance = covariance.view_mut();
    for first in (0..size).step_by(BLOCK) {
        let (n_rows, n_columns) = (size - first, BLOCK.min(size - first));
        covariance.view_mut((first, first), (n_rows, n_columns)).gemm(
            -1.0,
            &left.rows(first, n_rows),
            &right.columns(first, n_columns),
            1.0,
        );
    }
}
