//! The order in which a model keeps the cells of a map: neighbors, which see the same, are near each other.
//!
//! Square tiles from row to row, and within a tile the order of Morton (1966): the bits of column and row by turns.

use crate::GridSize;

/// Tells where a cell is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellOrder {
    size: GridSize,
    n_tiles_x: usize,
}

/// Bits of a column or row within a tile.
const BITS: usize = 5;
/// Edge of a tile, cells.
const EDGE: usize = 1 << BITS;
/// Cells of a tile.
const TILE: usize = EDGE * EDGE;

impl CellOrder {
    /// The order of a map of this size.
    pub fn new(size: GridSize) -> CellOrder {
        CellOrder { size, n_tiles_x: size.width.div_ceil(EDGE) }
    }

    /// Places, with those of no cell at the right and upper rim.
    pub fn n_places(&self) -> usize {
        self.n_tiles_x * self.size.height.div_ceil(EDGE) * TILE
    }

    /// The cell that is kept at a place.
    pub fn cell_at(&self, place: usize) -> Option<usize> {
        let (tile, within) = (place / TILE, place % TILE);
        let n_tiles_x = self.n_tiles_x.max(1);
        let (mut col, mut row) = (tile % n_tiles_x * EDGE, tile / n_tiles_x * EDGE);
        for bit in 0..BITS {
            col |= (within >> (2 * bit) & 1) << bit;
            row |= (within >> (2 * bit + 1) & 1) << bit;
        }
        (col < self.size.width && row < self.size.height).then(|| self.size.index(col, row))
    }

    /// Where a cell is kept.
    pub fn place_of(&self, cell: usize) -> usize {
        let (col, row) = self.size.col_row(cell);
        let tile = row / EDGE * self.n_tiles_x + col / EDGE;
        let within = (0..BITS)
            .fold(0, |place, bit| place | (col >> bit & 1) << (2 * bit) | (row >> bit & 1) << (2 * bit + 1));
        tile * TILE + within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_one_place_and_neighbors_are_near() {
        for size in [GridSize::new(1, 1), GridSize::new(70, 33), GridSize::new(32, 64)] {
            let order = CellOrder::new(size);
            let mut cells: Vec<usize> =
                (0..order.n_places()).filter_map(|place| order.cell_at(place)).collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..size.n_cells()));
            assert!((0..size.n_cells()).all(|cell| order.cell_at(order.place_of(cell)) == Some(cell)));
        }
        let order = CellOrder::new(GridSize::new(70, 70));
        let apart = |a: usize, b: usize| order.place_of(a).abs_diff(order.place_of(b));
        assert_eq!((apart(0, 1), apart(0, 70), apart(0, 71)), (1, 2, 3));
    }
}
