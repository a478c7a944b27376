//! The occupancy grid: log-odds in rows, row 0 at the bottom (y up), as in ROS.

use crate::boundary::Buffer;
use crate::frames::{Point2, Pose2, pose2};
use std::ops::Range;

/// A cell of a grid, counted from the lower left corner.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// Along x.
    pub col: u32,
    /// Along y, upwards.
    pub row: u32,
}

/// What a cell is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CellClass {
    /// Nothing there.
    Free,
    /// Something there.
    Occupied,
    /// Nobody knows.
    Unknown,
}

/// Size, place and thresholds of a grid.
#[doc(alias = "nav_msgs/MapMetaData")]
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridHeader {
    /// Cells along x.
    pub width: u32,
    /// Cells along y.
    pub height: u32,
    /// Edge of a cell, meters.
    pub resolution_m: f64,
    /// The lower left corner of cell (0, 0) in the map's frame: x and y in meters, turn in radians.
    pub origin: [f64; 3],
    /// A cell with more log-odds than this is occupied.
    pub occupied_above: f32,
    /// A cell with less log-odds than this is free; between the two it is unknown.
    pub free_below: f32,
}

/// Why a grid cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridFault {
    /// No cells at all.
    #[error("the grid has {width} x {height} cells, expected at least 1 x 1")]
    Empty {
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
    },
    /// Header and cells disagree.
    #[error("the grid has {found} cells where its header says {expected}")]
    Length {
        /// Cells in the buffer.
        found: usize,
        /// Cells by the header.
        expected: usize,
    },
    /// A number in the header is impossible.
    #[error("the grid's {field} is {found}, expected a finite number{more}")]
    Number {
        /// Field of the header.
        field: &'static str,
        /// What it holds.
        found: f64,
        /// A further condition.
        more: &'static str,
    },
}

/// Occupancy as log-odds: `ln(p / (1 - p))`, zero where nobody knows.
#[doc(alias = "nav_msgs/OccupancyGrid")]
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    header: GridHeader,
    grid_from_map: Pose2,
    /// One log-odds a cell, row by row from the bottom.
    pub cells: Buffer<f32>,
}

impl Grid {
    /// Log-odds of the probabilities 0.65 and 0.196 that ROS map files use.
    pub const OCCUPIED_ABOVE: f32 = 0.619_039_2;
    /// See [`OCCUPIED_ABOVE`](Self::OCCUPIED_ABOVE).
    pub const FREE_BELOW: f32 = -1.411_484_6;
    /// Log-odds of a cell that is surely occupied (probability 0.999), or with a minus sign surely free.
    pub const CERTAIN: f32 = 6.906_755;

    /// A grid of the cells given.
    pub fn new(header: GridHeader, cells: Buffer<f32>) -> Result<Grid, GridFault> {
        let expected = header.width as usize * header.height as usize;
        if expected == 0 {
            return Err(GridFault::Empty { width: header.width, height: header.height });
        }
        if cells.len() != expected {
            return Err(GridFault::Length { found: cells.len(), expected });
        }
        if !(header.resolution_m > 0.0 && header.resolution_m.is_finite()) {
            let found = header.resolution_m;
            return Err(GridFault::Number { field: "resolution_m", found, more: " above zero" });
        }
        if let Some(&found) = header.origin.iter().find(|v| !v.is_finite()) {
            return Err(GridFault::Number { field: "origin", found, more: "" });
        }
        let [x, y, yaw] = header.origin;
        Ok(Grid { header, grid_from_map: pose2(x, y, yaw).inverse(), cells })
    }

    /// A grid of unknown cells with its lower left corner at the map's origin.
    pub fn unknown(width: u32, height: u32, resolution_m: f64) -> Result<Grid, GridFault> {
        let header = GridHeader {
            width,
            height,
            resolution_m,
            origin: [0.0; 3],
            occupied_above: Self::OCCUPIED_ABOVE,
            free_below: Self::FREE_BELOW,
        };
        Grid::new(header, Buffer::zeroed(width as usize * height as usize))
    }

    /// Size, place and thresholds.
    pub fn header(&self) -> &GridHeader {
        &self.header
    }

    /// Cells along x.
    pub fn width(&self) -> u32 {
        self.header.width
    }

    /// Cells along y.
    pub fn height(&self) -> u32 {
        self.header.height
    }

    /// Edge of a cell, meters.
    pub fn resolution_m(&self) -> f64 {
        self.header.resolution_m
    }

    /// The grid's own frame in the map: origin at the lower left corner, axes along rows and columns, meters.
    pub fn map_from_grid(&self) -> Pose2 {
        self.grid_from_map.inverse()
    }

    /// The inverse of [`map_from_grid`](Self::map_from_grid).
    pub fn grid_from_map(&self) -> Pose2 {
        self.grid_from_map
    }

    /// The cell that a point of the map lies in.
    pub fn cell_at(&self, position: Point2) -> Option<Cell> {
        let in_grid = self.grid_from_map * position / self.header.resolution_m;
        let (col, row) = (in_grid.x.floor(), in_grid.y.floor());
        let inside =
            col >= 0.0 && row >= 0.0 && col < self.header.width.into() && row < self.header.height.into();
        inside.then_some(Cell { col: col as u32, row: row as u32 })
    }

    /// Middle of a cell in the map's frame.
    pub fn center_of(&self, cell: Cell) -> Point2 {
        let (col, row) = (f64::from(cell.col) + 0.5, f64::from(cell.row) + 0.5);
        self.map_from_grid() * (Point2::new(col, row) * self.header.resolution_m)
    }

    /// Where a cell lies in the buffer.
    pub fn index_of(&self, cell: Cell) -> usize {
        cell.row as usize * self.header.width as usize + cell.col as usize
    }

    /// The cell that lies there in the buffer.
    pub fn cell_of(&self, index: usize) -> Cell {
        let width = self.header.width as usize;
        Cell { col: (index % width) as u32, row: (index / width) as u32 }
    }

    /// What these log-odds are taken for.
    pub fn class_of(&self, log_odds: f32) -> CellClass {
        if log_odds > self.header.occupied_above {
            CellClass::Occupied
        } else if log_odds < self.header.free_below {
            CellClass::Free
        } else {
            CellClass::Unknown
        }
    }

    /// What a cell is taken for; outside the grid nobody knows.
    pub fn class(&self, cell: Cell) -> CellClass {
        if cell.col >= self.header.width || cell.row >= self.header.height {
            return CellClass::Unknown;
        }
        self.cells.get(self.index_of(cell)).map_or(CellClass::Unknown, |v| self.class_of(*v))
    }

    /// Columns and rows of the smallest rectangle that holds every known cell; none where no cell is known.
    pub fn known_extent(&self) -> Option<(Range<u32>, Range<u32>)> {
        let is_known = |v: &f32| self.class_of(*v) != CellClass::Unknown;
        let mut extent: Option<(Range<u32>, Range<u32>)> = None;
        for (row, cells) in (0..).zip(self.cells.chunks(self.header.width as usize)) {
            let first = cells.iter().position(is_known);
            let (Some(first), Some(last)) = (first, cells.iter().rposition(is_known)) else { continue };
            let (first, end) = (first as u32, last as u32 + 1);
            let (cols, rows) = extent.get_or_insert((first..end, row..row + 1));
            *cols = cols.start.min(first)..cols.end.max(end);
            rows.end = row + 1;
        }
        extent
    }

    /// Floor that is free, m².
    pub fn free_area_m2(&self) -> f64 {
        let n_free = self.cells.iter().filter(|cell| self.class_of(**cell) == CellClass::Free).count();
        n_free as f64 * self.header.resolution_m * self.header.resolution_m
    }

    /// Marks every cell that a disc touches, and in any case the one its middle lies in, as occupied.
    pub fn occupy_disc(&mut self, middle: Point2, radius_m: f64) {
        let in_grid = self.grid_from_map * middle / self.header.resolution_m;
        let reach = radius_m / self.header.resolution_m;
        let (width, height) = (self.header.width as usize, self.header.height as usize);
        let span = |mid: f64, most: usize| {
            let first = (mid - reach).floor().max(0.0) as usize;
            let last = (mid + reach).floor();
            (first, if last < 0.0 { 0 } else { (last as usize).saturating_add(1).min(most) })
        };
        let ((col0, col1), (row0, row1)) = (span(in_grid.x, width), span(in_grid.y, height));
        let cells = self.cells.make_mut();
        for row in row0..row1 {
            for col in col0..col1 {
                // Distance from the middle to the nearest point of the closed cell.
                let dx = (col as f64 - in_grid.x).max(in_grid.x - (col + 1) as f64).max(0.0);
                let dy = (row as f64 - in_grid.y).max(in_grid.y - (row + 1) as f64).max(0.0);
                if dx * dx + dy * dy <= reach * reach
                    && let Some(cell) = cells.get_mut(row * width + col)
                {
                    *cell = Self::CERTAIN;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned() -> Grid {
        let header = GridHeader { origin: [1.0, 2.0, 0.5], ..*Grid::unknown(4, 3, 0.5).unwrap().header() };
        Grid::new(header, Buffer::zeroed(12)).unwrap()
    }

    #[test]
    fn a_cell_contains_its_middle_also_in_a_turned_grid() {
        let grid = turned();
        for index in 0..12 {
            let cell = grid.cell_of(index);
            assert_eq!(grid.cell_at(grid.center_of(cell)), Some(cell));
            assert_eq!(grid.index_of(cell), index);
        }
        assert_eq!(grid.cell_at(Point2::new(0.0, 0.0)), None);
        assert_eq!(grid.cell_at(Point2::new(f64::NAN, 0.0)), None);
    }

    #[test]
    fn thresholds_are_strict_on_both_sides() {
        let grid = turned();
        assert_eq!(grid.class_of(Grid::OCCUPIED_ABOVE), CellClass::Unknown);
        assert_eq!(grid.class_of(Grid::FREE_BELOW), CellClass::Unknown);
        assert_eq!(grid.class_of(1.0), CellClass::Occupied);
        assert_eq!(grid.class_of(-2.0), CellClass::Free);
        let logit = |p: f64| (p / (1.0 - p)).ln() as f32;
        assert!((logit(0.65) - Grid::OCCUPIED_ABOVE).abs() < 1e-6);
        assert!((logit(0.196) - Grid::FREE_BELOW).abs() < 1e-6);
        assert!((logit(0.999) - Grid::CERTAIN).abs() < 1e-5);
    }

    #[test]
    fn a_disc_occupies_exactly_the_cells_it_touches() {
        let mut grid = Grid::unknown(20, 20, 0.1).unwrap();
        grid.occupy_disc(Point2::new(1.05, 1.05), 0.0);
        assert_eq!(grid.cells.iter().filter(|v| **v > 0.0).count(), 1);
        grid.occupy_disc(Point2::new(1.05, 1.05), 0.10);
        let occupied: Vec<Cell> =
            (0..400).map(|i| grid.cell_of(i)).filter(|c| grid.class(*c) == CellClass::Occupied).collect();
        assert_eq!(occupied.len(), 9);
        grid.occupy_disc(Point2::new(-5.0, 40.0), 0.3);
        grid.occupy_disc(Point2::new(1e300, f64::INFINITY), 0.3);
        assert_eq!(grid.cells.iter().filter(|v| **v > 0.0).count(), 9);
    }

    #[test]
    fn impossible_grids_are_named() {
        assert!(matches!(Grid::unknown(0, 5, 0.1), Err(GridFault::Empty { .. })));
        assert!(matches!(
            Grid::unknown(2, 5, f64::NAN),
            Err(GridFault::Number { field: "resolution_m", .. })
        ));
        let header = *Grid::unknown(2, 2, 0.1).unwrap().header();
        assert!(matches!(
            Grid::new(header, Buffer::zeroed(3)),
            Err(GridFault::Length { found: 3, expected: 4 })
        ));
        let header = GridHeader { origin: [0.0, f64::INFINITY, 0.0], ..header };
        assert!(matches!(
            Grid::new(header, Buffer::zeroed(4)),
            Err(GridFault::Number { field: "origin", .. })
        ));
    }
}
