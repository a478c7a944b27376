//! A square matrix that grows and shrinks at its end, with room to spare.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

/// Covariance of the whole state, both triangles.
#[derive(Debug, Clone)]
pub struct Covariance {
    store: DMatrix<f64>,
    size: usize,
}

/// Two covariances are equal when their numbers are, whatever room they have to spare.
impl PartialEq for Covariance {
    fn eq(&self, other: &Covariance) -> bool {
        self.view() == other.view()
    }
}

/// Edge of the blocks in which triangles are mirrored: two of them stay in the first cache.
const BLOCK: usize = 32;

impl Covariance {
    /// All zero.
    pub fn zeros(size: usize) -> Covariance {
        Covariance { store: DMatrix::zeros(size, size), size }
    }

    /// Rows, and columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The matrix.
    pub fn view(&self) -> DMatrixView<'_, f64> {
        self.store.view((0, 0), (self.size, self.size))
    }

    /// The matrix, to be changed; it must stay symmetric.
    pub fn view_mut(&mut self) -> DMatrixViewMut<'_, f64> {
        let size = self.size;
        self.store.view_mut((0, 0), (size, size))
    }

    /// Adds rows and columns of zeros.
    pub fn grow(&mut self, more: usize) {
        let size = self.size + more;
        if size > self.store.nrows() {
            let room = size.max(2 * self.store.nrows());
            let mut store = DMatrix::zeros(room, room);
            store.view_mut((0, 0), (self.size, self.size)).copy_from(&self.view());
            self.store = store;
        } else {
            self.store.view_mut((0, self.size), (size, more)).fill(0.0);
            self.store.view_mut((self.size, 0), (more, size)).fill(0.0);
        }
        self.size = size;
    }

    /// Puts the last two rows and columns in the place of these two, and forgets them there.
    pub fn swap_remove_pair(&mut self, at: usize) {
        let last = self.size - 2;
        if at < last {
            for k in 0..2 {
                self.store.swap_columns(at + k, last + k);
                self.store.swap_rows(at + k, last + k);
            }
        }
        self.size = last;
    }

    /// Copies the lower triangle of the first `size` rows and columns onto the upper one.
    pub fn mirror_lower(&mut self, size: usize) {
        let stride = self.store.nrows();
        let cells = self.store.as_mut_slice();
        for first_col in (0..size).step_by(BLOCK) {
            for first_row in (first_col..size).step_by(BLOCK) {
                for col in first_col..(first_col + BLOCK).min(size) {
                    for row in first_row.max(col + 1)..(first_row + BLOCK).min(size) {
                        cells[row * stride + col] = cells[col * stride + row];
                    }
                }
            }
        }
    }
}
