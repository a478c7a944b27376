//! How well a point fits into each cell, and the best that can be had inside squares of 2, 4, 8 ... cells.

use crate::GridSize;
use crate::distance_field::squared_distance_field;

/// Squares of more cells than this along a side bound nothing that a window of real size would need.
pub const MOST_LEVELS: usize = 12;

/// Values of cells, with their maxima over squares.
#[derive(Debug, Clone, PartialEq)]
pub struct FitTable {
    size: GridSize,
    resolution_m: f64,
    levels: Vec<Level>,
}

/// One byte a square of `side` cells, by its lower left cell: what is missing to the best value, 255. Squares that only
/// partly lie on the grid come before its first column and row; around all is a border that is as bad as can be.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Level {
    pub(super) side: i32,
    pub(super) columns: i32,
    pub(super) rows: i32,
    pub(super) costs: Vec<u8>,
}

impl Level {
    fn finest(size: GridSize, values: &[u8]) -> Level {
        let columns = size.width + 2;
        let mut costs = vec![u8::MAX; columns * (size.height + 2)];
        let rows = costs.chunks_exact_mut(columns).skip(1);
        for (row, values) in rows.zip(values.chunks_exact(size.width.max(1))) {
            for (cost, value) in row.iter_mut().skip(1).zip(values) {
                *cost = u8::MAX - value;
            }
        }
        Level { side: 1, columns: columns as i32, rows: (size.height + 2) as i32, costs }
    }

    /// Squares of twice the side: the best of the four that each consists of.
    fn doubled(&self) -> Level {
        let shift = self.side as usize;
        let (columns, rows) = (self.columns as usize, self.rows as usize);
        let (to_columns, to_rows) = (columns + shift, rows + shift);
        let mut costs = vec![u8::MAX; to_columns * to_rows];
        let mut wide = vec![u8::MAX; to_columns];
        for (row, from) in self.costs.chunks_exact(columns).enumerate() {
            wide.fill(u8::MAX);
            wide[..columns].copy_from_slice(from);
            lower(&mut wide[shift..], from);
            // A square begins as many cells before the grid as it is long: places of both levels are the same.
            for to in [row, row + shift] {
                lower(&mut costs[to * to_columns..][..to_columns], &wide);
            }
        }
        Level { side: self.side * 2, columns: to_columns as i32, rows: to_rows as i32, costs }
    }
}

fn lower(costs: &mut [u8], by: &[u8]) {
    for (cost, by) in costs.iter_mut().zip(by) {
        *cost = (*cost).min(*by);
    }
}

impl FitTable {
    /// A table of one value a cell: 255 where a point fits best, 0 where it does not at all. With `n_levels` levels,
    /// squares have up to `2^(n_levels - 1)` cells along a side.
    ///
    /// # Panics
    /// When there is not one value a cell.
    pub fn new(size: GridSize, resolution_m: f64, values: &[u8], n_levels: usize) -> FitTable {
        assert_eq!(values.len(), size.n_cells(), "one value per cell");
        let mut levels = vec![Level::finest(size, values)];
        for _ in 1..n_levels.min(MOST_LEVELS) {
            let next = levels.last().map(Level::doubled);
            levels.extend(next);
        }
        FitTable { size, resolution_m, levels }
    }

    /// A table where cells fit less the farther they are from a marked (nonzero) one: as exp(-d²/2σ²).
    pub fn around_marks(
        size: GridSize,
        resolution_m: f64,
        marks: &[u8],
        sigma_m: f64,
        n_levels: usize,
    ) -> FitTable {
        let per_square = -0.5 * (resolution_m / sigma_m).powi(2);
        let value = |squared: u32| (255.0 * (per_square * f64::from(squared)).exp()).round() as u8;
        // Beyond this no value is left; each exponential is taken once.
        let n_known = ((-6.3 / per_square).min(1e6)) as u32 + 1;
        let by_square: Vec<u8> = (0..n_known).map(value).collect();
        let squares = squared_distance_field(size, marks);
        let values: Vec<u8> =
            squares.iter().map(|squared| by_square.get(*squared as usize).copied().unwrap_or(0)).collect();
        FitTable::new(size, resolution_m, &values, n_levels)
    }

    /// Size of the grid.
    pub fn size(&self) -> GridSize {
        self.size
    }

    /// Edge of a cell, meters.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Value of a cell: 0 beyond the grid.
    pub fn value(&self, col: i32, row: i32) -> u8 {
        let is_inside = col >= 0 && row >= 0 && (col as usize) < self.size.width;
        let finest = self.levels.first().filter(|_| is_inside && (row as usize) < self.size.height);
        let cost = finest.and_then(|level| {
            level.costs.get(((row + 1) as usize) * level.columns as usize + (col + 1) as usize)
        });
        cost.map_or(0, |cost| u8::MAX - cost)
    }

    pub(super) fn levels(&self) -> &[Level] {
        &self.levels
    }
}
