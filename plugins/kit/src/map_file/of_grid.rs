//! A grid of the framework as a map file's grid.

use rumbo_core::frames::Point2;
use rumbo_core::map::{CellClass, Grid};

use super::{MapImage, SavedAs, UNKNOWN};

impl MapImage {
    /// The known part of a grid, cut at whole cells; none where no cell is known. [`SavedAs::Trinary`] keeps the class
    /// of each cell (0, 100, -1), the others its probability in percent.
    pub fn of_grid(grid: &Grid, saved_as: SavedAs) -> Option<MapImage> {
        let (cols, rows) = grid.known_extent()?;
        let value = |log_odds: f32| match saved_as {
            SavedAs::Scale | SavedAs::Raw if log_odds == 0.0 => UNKNOWN,
            SavedAs::Scale | SavedAs::Raw => (100.0 / (1.0 + (-log_odds).exp())).round() as i8,
            SavedAs::Trinary => match grid.class_of(log_odds) {
                CellClass::Free => 0,
                CellClass::Occupied => 100,
                CellClass::Unknown => UNKNOWN,
            },
        };
        let lines =
            grid.cells.chunks_exact(grid.width() as usize).take(rows.end as usize).skip(rows.start as usize);
        let cells = lines.flat_map(|line| line.iter().take(cols.end as usize).skip(cols.start as usize));
        let corner = Point2::new(f64::from(cols.start), f64::from(rows.start)) * grid.resolution_m();
        let corner = grid.map_from_grid() * corner;
        Some(MapImage {
            width: cols.len(),
            height: rows.len(),
            resolution_m: grid.resolution_m(),
            origin: [corner.x, corner.y, grid.header().origin[2]],
            cells: cells.map(|log_odds| value(*log_odds)).collect(),
        })
    }
}
