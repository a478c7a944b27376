//! Occupancy grids whose clones share what they have in common: square tiles behind reference counts, copied only when they
//! are written while somebody else has them too. A filter with a map in each particle keeps one map and the differences
//! (Grisetti, Stachniss, Burgard, *Improved Techniques for Grid Mapping with Rao-Blackwellized Particle Filters*, IEEE
//! T-RO 2007, section V).
//!
//! Maps grow wherever scans reach, without moving a cell. Cells are log-odds as in [`occupancy`](crate::occupancy), in a
//! byte each, on several levels with cells of 1, 2, 4, ... times the edge, each made from the scans themselves.

mod code;
mod export;
mod level;
mod painter;
mod tile;

pub use code::TileCode;
pub use export::{ExportFault, GridExport};
pub use level::{LevelView, TileLevel};
pub use painter::TilePainter;
pub use tile::{TILE_CELLS, Tile};

use crate::occupancy::Evidence;
use rumbo_core::frames::Point2;

/// Levels of tiles over the same area, finest first. A clone copies references only.
#[derive(Debug, Clone)]
pub struct TileMap {
    levels: Vec<TileLevel>,
}

impl TileMap {
    /// An empty map whose finest cells have this edge, with so many levels, at least one. Its cells hold 127 steps from
    /// unknown to the farther bound of certainty.
    pub fn new(resolution_m: f64, n_levels: u32, evidence: &Evidence) -> TileMap {
        TileMap::of_unit(resolution_m, n_levels, tile::unit_of(evidence))
    }

    fn of_unit(resolution_m: f64, n_levels: u32, unit: f32) -> TileMap {
        let level = |k: u32| TileLevel::new(resolution_m * f64::from(1u32 << k.min(30)), unit);
        TileMap { levels: (0..n_levels.max(1)).map(level).collect() }
    }

    /// What a beam says in the whole units that cells of this map hold.
    pub fn rounded(&self, evidence: &Evidence) -> Evidence {
        let unit = self.finest().map_or_else(|| tile::unit_of(evidence), TileLevel::unit);
        tile::UnitEvidence::new(evidence, unit).log_odds(unit)
    }

    /// Its levels, finest first.
    pub fn levels(&self) -> &[TileLevel] {
        &self.levels
    }

    pub(crate) fn levels_mut(&mut self) -> &mut [TileLevel] {
        &mut self.levels
    }

    /// What scans are matched against, finest first.
    pub fn views(&self) -> Vec<LevelView<'_>> {
        self.levels.iter().map(LevelView::new).collect()
    }

    /// The finest level.
    pub fn finest(&self) -> Option<&TileLevel> {
        self.levels.first()
    }

    /// Log-odds of the finest cell that a point of the map lies in; 0 where no scan has been.
    pub fn log_odds_at(&self, point: Point2) -> f32 {
        self.finest().map_or(0.0, |level| {
            let cell = [point.x, point.y].map(|v| (v / level.resolution_m()).floor() as i64);
            level.cell(cell)
        })
    }

    /// Tiles of all levels.
    pub fn n_tiles(&self) -> usize {
        self.levels.iter().map(|level| level.tiles().count()).sum()
    }
}
