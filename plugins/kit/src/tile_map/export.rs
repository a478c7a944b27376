//! The finest level as a plain grid, kept up to date tile by tile.

use super::TileMap;
use super::level::TileLevel;
use super::tile::TILE_CELLS;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{Grid, GridFault, GridHeader};

/// Writes maps into a plain grid. Only tiles that differ from what was written last are written again, also where the map
/// is another one that shares most of its tiles.
#[derive(Debug, Clone, Default)]
pub struct GridExport {
    first: [i64; 2],
    size: [usize; 2],
    written: Vec<u64>,
}

impl GridExport {
    /// Makes the grid what the map is, with its origin at this place of the grid's map. One that is none, or that somebody
    /// else made, is made anew.
    ///
    /// # Errors
    /// A grid that cannot be, as one with more cells than `max_cells`.
    pub fn write(
        &mut self,
        map: &TileMap,
        map_from_tiles: &Pose2,
        grid: &mut Option<Grid>,
        max_cells: u64,
    ) -> Result<(), ExportFault> {
        let Some(level) = map.finest() else { return Ok(()) };
        let (first, size) = self.room_for(level);
        let edge = TILE_CELLS;
        let header = header(level.resolution_m(), map_from_tiles, first, size);
        let n_cells = u64::from(header.width) * u64::from(header.height);
        if n_cells > max_cells {
            return Err(ExportFault::TooLarge { n_cells, max_cells });
        }
        if grid.as_ref().is_none_or(|grid| *grid.header() != header) {
            *grid = Some(Grid::new(header, Buffer::zeroed(n_cells as usize))?);
            (self.first, self.size) = (first, size);
            self.written = vec![0; size[0] * size[1]];
        }
        let Some(grid) = grid else { return Ok(()) };
        let stale = |written: &[u64], idx: usize, version: u64| written.get(idx) != Some(&version);
        let place = |idx: usize| [first[0] + (idx % size[0]) as i64, first[1] + (idx / size[0]) as i64];
        let version = |idx: usize| level.tile(place(idx)).map_or(0, |tile| tile.version);
        if (0..self.written.len()).all(|idx| !stale(&self.written, idx, version(idx))) {
            return Ok(());
        }
        let width = size[0] * edge;
        let cells = grid.cells.make_mut();
        for idx in 0..self.written.len() {
            if !stale(&self.written, idx, version(idx)) {
                continue;
            }
            self.written[idx] = version(idx);
            let corner = (idx / size[0]) * edge * width + (idx % size[0]) * edge;
            let tile = level.tile(place(idx));
            for row in 0..edge {
                let Some(line) = cells.get_mut(corner + row * width..corner + row * width + edge) else {
                    break;
                };
                match tile.and_then(|tile| tile.cells.get(row * edge..(row + 1) * edge)) {
                    Some(from) => {
                        line.iter_mut().zip(from).for_each(|(to, from)| *to = level.unit() * f32::from(*from))
                    }
                    None => line.fill(0.0),
                }
            }
        }
        Ok(())
    }

    /// The rectangle of tiles that holds what is there now and was there before: it never shrinks, and grows by a few
    /// tiles at once, so that the grid is not made anew with every step into the unknown.
    fn room_for(&self, level: &TileLevel) -> ([i64; 2], [usize; 2]) {
        const SPARE: i64 = 4;
        let [n_x, n_y] = level.size_tiles();
        let is_empty = n_x == 0 || n_y == 0;
        let (first, n) = if is_empty { ([0; 2], [1, 1]) } else { (level.first_tile(), [n_x, n_y]) };
        if self.written.is_empty() {
            return (first, n);
        }
        let mut grown = (self.first, self.size);
        for axis in 0..2 {
            let (old, old_end) = (self.first[axis], self.first[axis] + self.size[axis] as i64);
            let (new, new_end) = (first[axis], first[axis] + n[axis] as i64);
            let begin = if new < old { new - SPARE } else { old };
            let end = if new_end > old_end { new_end + SPARE } else { old_end };
            (grown.0[axis], grown.1[axis]) = (begin, (end - begin) as usize);
        }
        grown
    }
}

/// Why a map cannot be a plain grid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportFault {
    /// It would be too large.
    #[error("the map has grown to {n_cells} cells, more than the {max_cells} that it may have")]
    TooLarge {
        /// How many there would be.
        n_cells: u64,
        /// How many there may be.
        max_cells: u64,
    },
    /// Another reason.
    #[error(transparent)]
    Grid(#[from] GridFault),
}

/// Passed more often than hit is free, the reverse occupied: the signs of the log-odds.
fn header(resolution_m: f64, map_from_tiles: &Pose2, first: [i64; 2], size: [usize; 2]) -> GridHeader {
    let edge_m = TILE_CELLS as f64 * resolution_m;
    let corner = map_from_tiles * Point2::new(first[0] as f64 * edge_m, first[1] as f64 * edge_m);
    let cells = |n: usize| u32::try_from(n * TILE_CELLS).unwrap_or(u32::MAX);
    GridHeader {
        width: cells(size[0]),
        height: cells(size[1]),
        resolution_m,
        origin: [corner.x, corner.y, map_from_tiles.rotation.angle()],
        occupied_above: 0.0,
        free_below: 0.0,
    }
}
