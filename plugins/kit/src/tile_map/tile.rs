//! A square of cells.

/// Cells along the edge of a tile.
pub const TILE_CELLS: usize = 64;
/// Cells of a tile.
pub(super) const N_CELLS: usize = TILE_CELLS * TILE_CELLS;

/// Log-odds in rows from the lower left corner.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// Changes with every change of a cell: two tiles of the same place with the same number have the same cells.
    pub version: u64,
    /// The cells.
    pub cells: [f32; N_CELLS],
}

impl Tile {
    /// Cells that nobody has seen.
    pub(super) fn unknown() -> Tile {
        Tile { version: 0, cells: [0.0; N_CELLS] }
    }

    /// The cell in this column and row.
    #[inline(always)]
    pub(super) fn at(&self, col: usize, row: usize) -> f32 {
        self.cells[(row % TILE_CELLS) * TILE_CELLS + col % TILE_CELLS]
    }
}
