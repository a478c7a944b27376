//! The part of a grid that this is about: the known one.

use rumbo_core::frames::Point2;
use rumbo_core::map::{Cell, CellClass, Grid, GridHeader};
use rumbo_kit::{GridSize, NEIGHBORS_8};
use sha2::{Digest, Sha256};

/// Two rasters lie at the same place when their corners differ by less, cells.
const SAME_PLACE_CELLS: f64 = 1e-3;

/// The smallest rectangle with all known cells of a grid: what a saved map holds, whatever unknown cells lay around it.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    of: GridHeader,
    /// Column and row of the raster's first cell in the grid.
    first: [usize; 2],
    size: GridSize,
    /// Its lower left corner in the map's frame: x and y in meters, turn in radians.
    corner: [f64; 3],
    /// What each of its cells is taken for.
    pub classes: Vec<CellClass>,
}

impl Raster {
    /// The known part; none where no cell is known.
    pub fn of(grid: &Grid) -> Option<Raster> {
        let (cols, rows) = grid.known_extent()?;
        let first = [cols.start as usize, rows.start as usize];
        let size = GridSize::new(cols.len(), rows.len());
        let corner = Point2::new(f64::from(cols.start), f64::from(rows.start)) * grid.resolution_m();
        let corner = grid.map_from_grid() * corner;
        let corner = [corner.x, corner.y, grid.header().origin[2]];
        let classes = rows.flat_map(|row| cols.clone().map(move |col| grid.class(Cell { col, row })));
        let classes = classes.collect();
        Some(Raster { of: *grid.header(), first, size, corner, classes })
    }

    /// Columns and rows.
    pub fn size(&self) -> GridSize {
        self.size
    }

    /// Edge of a cell, meters.
    pub fn resolution_m(&self) -> f64 {
        self.of.resolution_m
    }

    /// Its lower left corner in the map's frame: x and y in meters, turn in radians.
    pub fn corner(&self) -> [f64; 3] {
        self.corner
    }

    /// This grid has the cells that the raster is about.
    pub fn is_of(&self, grid: &Grid) -> bool {
        *grid.header() == self.of
    }

    /// It covers the same cells as one of that size at that corner.
    pub fn is_at(&self, size: GridSize, resolution_m: f64, corner: [f64; 3]) -> bool {
        let near_m = SAME_PLACE_CELLS * self.of.resolution_m;
        let farthest = [size.width, size.height].into_iter().max().unwrap_or(0) as f64;
        let [x, y, yaw] = self.corner;
        size == self.size
            && (resolution_m - self.of.resolution_m).abs() * farthest < near_m
            && (corner[0] - x).abs() < near_m
            && (corner[1] - y).abs() < near_m
            && (corner[2] - yaw).abs() * farthest < SAME_PLACE_CELLS
    }

    /// Where a cell of the raster lies in the grid's buffer.
    pub fn in_grid(&self, index: usize) -> usize {
        let (col, row) = self.size.col_row(index);
        (self.first[1] + row) * self.of.width as usize + self.first[0] + col
    }

    /// From the grid's frame in cells to the raster's.
    pub fn from_grid_cells(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x - self.first[0] as f64, y - self.first[1] as f64]
    }

    /// What a cell is taken for; unknown beside the raster.
    pub fn class(&self, index: usize) -> CellClass {
        self.classes.get(index).copied().unwrap_or(CellClass::Unknown)
    }

    /// The up to eight cells around one.
    pub fn around(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        NEIGHBORS_8.into_iter().filter_map(move |(col, row)| self.size.neighbor(index, col, row))
    }

    /// The cell at a point, cells from the corner.
    pub fn cell_at(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.size.width as f64 && y < self.size.height as f64;
        is_inside.then(|| self.size.index(x as usize, y as usize))
    }

    /// The classes of all cells as one number.
    pub fn fingerprint(&self) -> [u8; 32] {
        let mut hash = Sha256::new();
        for count in [self.size.width, self.size.height] {
            hash.update((count as u64).to_le_bytes());
        }
        let code = |class: &CellClass| match class {
            CellClass::Free => 0u8,
            CellClass::Occupied => 1,
            CellClass::Unknown => 2,
        };
        let codes: Vec<u8> = self.classes.iter().map(code).collect();
        hash.update(codes);
        hash.finalize().into()
    }
}
