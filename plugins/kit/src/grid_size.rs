//! The size of a row-major grid.

/// Width and height of a grid, in cells. Row 0 is at the bottom, `index = row * width + col`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GridSize {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

impl GridSize {
    /// A grid of `width` columns and `height` rows.
    pub const fn new(width: usize, height: usize) -> Self {
        Self { width, height }
    }

    /// Number of cells.
    pub const fn n_cells(self) -> usize {
        self.width * self.height
    }

    /// Index of a cell that lies inside.
    pub const fn index(self, col: usize, row: usize) -> usize {
        row * self.width + col
    }

    /// Column and row of an index.
    pub const fn col_row(self, index: usize) -> (usize, usize) {
        (index % self.width, index / self.width)
    }

    /// The index `d_col` columns and `d_row` rows away, if it lies inside.
    pub fn neighbor(self, index: usize, d_col: i32, d_row: i32) -> Option<usize> {
        let (col, row) = self.col_row(index);
        let col = col.checked_add_signed(d_col as isize)?;
        let row = row.checked_add_signed(d_row as isize)?;
        (col < self.width && row < self.height).then(|| self.index(col, row))
    }
}

/// The eight neighbor offsets as (column, row), counter-clockwise from +x: even entries are straight, odd ones diagonal.
pub const NEIGHBORS_8: [(i32, i32); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
