//! A square of cells, and what a byte in it means.

use crate::occupancy::Evidence;

/// Cells along the edge of a tile.
pub const TILE_CELLS: usize = 64;
/// Cells of a tile.
pub(super) const N_CELLS: usize = TILE_CELLS * TILE_CELLS;

/// Log-odds in rows from the lower left corner, in whole units of the map: a byte a cell, since there is a map for each
/// particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// Changes with every change of a cell: two tiles of the same place with the same number have the same cells.
    pub version: u64,
    /// The cells.
    pub cells: [i8; N_CELLS],
}

impl Tile {
    /// Cells that nobody has seen.
    pub(super) fn unknown() -> Tile {
        Tile { version: 0, cells: [0; N_CELLS] }
    }

    /// The cell in this column and row, in units.
    #[inline(always)]
    pub(super) fn at(&self, col: usize, row: usize) -> f32 {
        f32::from(self.cells[(row % TILE_CELLS) * TILE_CELLS + col % TILE_CELLS])
    }
}

/// Units on either side of unknown.
const MOST_UNITS: f32 = 127.0;

/// Log-odds of one unit: as small as it can be, so that the bounds of certainty fit into a byte.
pub(super) fn unit_of(evidence: &Evidence) -> f32 {
    evidence.most.max(-evidence.least) / MOST_UNITS
}

/// What one beam says, in units. A cell that was touched is never zero again, since zero is unknown.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitEvidence {
    free: i16,
    occupied: i16,
    least: i16,
    most: i16,
}

impl UnitEvidence {
    pub fn new(evidence: &Evidence, unit: f32) -> UnitEvidence {
        let units = |log_odds: f32| (log_odds.abs() / unit).round().clamp(1.0, MOST_UNITS) as i16;
        let Evidence { free, occupied, least, most } = *evidence;
        UnitEvidence { free: units(free), occupied: units(occupied), least: -units(least), most: units(most) }
    }

    /// The same in log-odds.
    pub fn log_odds(&self, unit: f32) -> Evidence {
        let log_odds = |units: i16| f32::from(units) * unit;
        Evidence {
            free: -log_odds(self.free),
            occupied: log_odds(self.occupied),
            least: log_odds(self.least),
            most: log_odds(self.most),
        }
    }

    /// A cell after a beam passed it.
    #[inline(always)]
    pub fn passed(&self, cell: i8) -> i8 {
        let freer = (i16::from(cell) - self.free).max(self.least);
        if freer == 0 { -1 } else { freer as i8 }
    }

    /// A cell after a beam ended in it.
    #[inline(always)]
    pub fn hit(&self, cell: i8) -> i8 {
        let surer = (i16::from(cell) + self.occupied).min(self.most);
        if surer == 0 { 1 } else { surer as i8 }
    }
}
