//! What scans are matched against.

use super::logistic::logistic;
use crate::GridSize;
use rumbo_core::frames::Pose2;
use rumbo_core::map::{Grid, Map};

/// One level of what a scan is matched against: numbers at the middles of square cells.
///
/// Everything here is called for every point: implement it with `#[inline(always)]`, or the loop around it is not
/// compiled for wide vectors.
pub trait MatchLevel {
    /// Edge of a cell, meters.
    fn resolution_m(&self) -> f64;

    /// The level's own frame, with its origin at the lower left corner of cell (0, 0), from the map's frame.
    fn level_from_map(&self) -> Pose2;

    /// Cells along both axes.
    fn size(&self) -> GridSize;

    /// What is stored in the cells (col, row), (col + 1, row), (col, row + 1) and (col + 1, row + 1); all of them lie
    /// within [`size`](Self::size).
    fn corners(&self, col: usize, row: usize) -> [f32; 4];

    /// What a stored number says: 0 that nothing is there, 1 that something is. Log-odds, unless a level says otherwise.
    #[inline(always)]
    fn value(stored: f32) -> f32 {
        logistic(stored)
    }

    /// A cell with this number has been seen by some scan: no sum of evidence is exactly zero again, so zero is what no beam
    /// has reached.
    #[inline(always)]
    fn is_touched(stored: f32) -> bool {
        stored != 0.0
    }
}

/// A level of log-odds in contiguous rows.
#[derive(Debug, Clone, Copy)]
pub struct GridLevel<'a> {
    cells: &'a [f32],
    size: GridSize,
    resolution_m: f64,
    level_from_map: Pose2,
}

impl<'a> GridLevel<'a> {
    /// Log-odds in rows from the lower left corner; none where sizes disagree.
    pub fn new(
        cells: &'a [f32],
        size: GridSize,
        resolution_m: f64,
        level_from_map: Pose2,
    ) -> Option<GridLevel<'a>> {
        (cells.len() == size.n_cells()).then_some(GridLevel { cells, size, resolution_m, level_from_map })
    }
}

impl<'a> From<&'a Grid> for GridLevel<'a> {
    fn from(grid: &'a Grid) -> GridLevel<'a> {
        GridLevel {
            cells: &grid.cells,
            size: GridSize::new(grid.width() as usize, grid.height() as usize),
            resolution_m: grid.resolution_m(),
            level_from_map: grid.grid_from_map(),
        }
    }
}

/// The grids of a map, finest first.
pub fn levels_of(map: &Map) -> Vec<GridLevel<'_>> {
    map.grid.iter().chain(&map.coarse_grids).map(GridLevel::from).collect()
}

/// The finest of the levels, up to the first with cells as large as what a start may be off by: coarser ones cost time, and
/// know less than the start does.
pub fn levels_within<L: MatchLevel>(levels: &[L], reach_m: f64) -> &[L] {
    let n = levels.iter().take_while(|level| level.resolution_m() < reach_m).count() + 1;
    levels.get(..n).unwrap_or(levels)
}

impl MatchLevel for GridLevel<'_> {
    #[inline(always)]
    fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    #[inline(always)]
    fn level_from_map(&self) -> Pose2 {
        self.level_from_map
    }

    #[inline(always)]
    fn size(&self) -> GridSize {
        self.size
    }

    #[inline(always)]
    fn corners(&self, col: usize, row: usize) -> [f32; 4] {
        let lower = row * self.size.width + col;
        let upper = lower + self.size.width;
        match (self.cells.get(lower..lower + 2), self.cells.get(upper..upper + 2)) {
            (Some(&[p00, p10]), Some(&[p01, p11])) => [p00, p10, p01, p11],
            _ => [0.0; 4],
        }
    }
}
