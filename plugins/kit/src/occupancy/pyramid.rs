//! The grid and its coarser levels: made, and grown.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::Point2;
use rumbo_core::map::{Grid, GridFault, GridHeader, Map};

/// What became of a wish to grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grown {
    /// There was room already.
    Fits,
    /// There is room now.
    Grew,
    /// There would be more cells than allowed; nothing changed.
    TooLarge,
}

/// Rules for the levels. Level k has cells of `resolution * 2^k` over the same area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pyramid {
    /// Edge of the finest cells, meters.
    pub resolution_m: f64,
    /// How many levels.
    pub levels: u32,
    /// Growth comes in multiples of this, finest cells.
    pub block_cells: u32,
    /// All finest cells together are at most this many.
    pub max_cells: u64,
}

impl Pyramid {
    /// Unknown cells around a point that lies at this share of the width and the height.
    ///
    /// # Errors
    /// A grid that cannot be.
    pub fn lay(&self, map: &mut Map, size: u32, around: Point2, share: [f64; 2]) -> Result<(), GridFault> {
        // Whole coarsest cells from the map's origin, so that maps of one place have the same raster.
        let coarsest_m = self.resolution_m * f64::from(1u32 << (self.levels - 1));
        let extent_m = f64::from(size) * self.resolution_m;
        let snapped =
            |middle: f64, share: f64| ((middle - share * extent_m) / coarsest_m).round() * coarsest_m;
        let origin = [snapped(around.x, share[0]), snapped(around.y, share[1]), 0.0];
        let level = |k: u32| {
            let (cells, resolution_m) = (size >> k, self.resolution_m * f64::from(1u32 << k));
            // Passed more often than hit is free, the reverse occupied: the signs of the log-odds.
            let header = GridHeader {
                width: cells,
                height: cells,
                resolution_m,
                origin,
                occupied_above: 0.0,
                free_below: 0.0,
            };
            Grid::new(header, Buffer::zeroed(cells as usize * cells as usize))
        };
        map.coarse_grids = (1..self.levels).map(level).collect::<Result<_, _>>()?;
        map.grid = Some(level(0)?);
        Ok(())
    }

    /// The map has levels that go with these rules.
    pub fn fits(&self, map: &Map) -> bool {
        let Some(grid) = &map.grid else { return false };
        let is_level = |(k, coarse): (u32, &Grid)| {
            (coarse.width() << k, coarse.height() << k) == (grid.width(), grid.height())
        };
        grid.resolution_m() == self.resolution_m
            && map.coarse_grids.len() as u32 + 1 == self.levels
            && (1..).zip(&map.coarse_grids).all(is_level)
    }

    /// Makes room for a rectangle, in finest cells counted from the grid's corner.
    ///
    /// # Errors
    /// A grid that cannot be.
    pub fn make_room(&self, map: &mut Map, low: [f64; 2], high: [f64; 2]) -> Result<Grown, GridFault> {
        let Some(grid) = &map.grid else { return Ok(Grown::Fits) };
        let block = f64::from(self.block_cells);
        let blocks = |missing: f64| (missing.max(0.0) / block).ceil() * block;
        let size = [f64::from(grid.width()), f64::from(grid.height())];
        let before = low.map(|v| blocks(-v.floor()));
        let after = [0, 1].map(|axis| blocks(high[axis].floor() + 1.0 - size[axis]));
        if before.iter().chain(&after).all(|cells| *cells == 0.0) {
            return Ok(Grown::Fits);
        }
        let new_size = [0, 1].map(|axis| before[axis] + size[axis] + after[axis]);
        let n_cells = new_size[0] * new_size[1];
        // Also where a number is too large to be a size at all.
        let is_small = n_cells <= self.max_cells as f64 && new_size.iter().all(|v| *v < f64::from(u32::MAX));
        if !is_small {
            return Ok(Grown::TooLarge);
        }
        let (before, new_size) = (before.map(|v| v as u32), new_size.map(|v| v as u32));
        map.grid = Some(enlarged(grid, before, new_size)?);
        for (k, coarse) in (1..).zip(&mut map.coarse_grids) {
            *coarse = enlarged(coarse, before.map(|v| v >> k), new_size.map(|v| v >> k))?;
        }
        Ok(Grown::Grew)
    }
}

/// The same cells in a larger grid, `before` columns and rows from its corner.
fn enlarged(grid: &Grid, before: [u32; 2], size: [u32; 2]) -> Result<Grid, GridFault> {
    let header = grid.header();
    let corner = grid.map_from_grid()
        * Point2::new(
            -f64::from(before[0]) * header.resolution_m,
            -f64::from(before[1]) * header.resolution_m,
        );
    let origin = [corner.x, corner.y, header.origin[2]];
    let new = GridHeader { width: size[0], height: size[1], origin, ..*header };
    let mut cells = Buffer::zeroed(size[0] as usize * size[1] as usize);
    let rows = grid.cells.chunks_exact(header.width as usize);
    let new_rows = cells.make_mut().chunks_exact_mut(size[0] as usize).skip(before[1] as usize);
    for (row, new_row) in rows.zip(new_rows) {
        for (cell, new_cell) in row.iter().zip(new_row.iter_mut().skip(before[0] as usize)) {
            *new_cell = *cell;
        }
    }
    Grid::new(new, cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: Pyramid = Pyramid { resolution_m: 0.1, levels: 3, block_cells: 8, max_cells: 10_000 };

    fn laid() -> Map {
        let mut map = Map::default();
        RULES.lay(&mut map, 16, Point2::new(3.05, -1.0), [0.5, 0.5]).unwrap();
        map
    }

    #[test]
    fn levels_cover_the_same_area_on_a_common_raster() {
        let map = laid();
        assert!(RULES.fits(&map) && !RULES.fits(&Map::default()));
        let grid = map.grid.as_ref().unwrap();
        assert_eq!(grid.header().origin[0], (2.25f64 / 0.4).round() * 0.4);
        assert!(grid.cell_at(Point2::new(3.05, -1.0)).is_some());
        for (k, coarse) in (1..).zip(&map.coarse_grids) {
            assert_eq!((coarse.width() << k, coarse.header().origin), (16, grid.header().origin));
            assert_eq!(coarse.resolution_m(), 0.1 * f64::from(1 << k));
        }
        assert!(
            !Pyramid { levels: 2, ..RULES }.fits(&map) && !Pyramid { resolution_m: 0.2, ..RULES }.fits(&map)
        );
    }

    #[test]
    fn growing_keeps_every_cell_where_it_is_in_the_map() {
        let mut map = laid();
        let marked = Point2::new(3.15, -0.85);
        for grid in map.grid.iter_mut().chain(&mut map.coarse_grids) {
            let index = grid.index_of(grid.cell_at(marked).unwrap());
            grid.cells.make_mut()[index] = 2.5;
        }
        assert_eq!(RULES.make_room(&mut map, [0.0, 0.0], [15.9, 15.9]).unwrap(), Grown::Fits);
        assert_eq!(RULES.make_room(&mut map, [-0.5, 3.0], [16.0, 40.0]).unwrap(), Grown::Grew);
        assert!(RULES.fits(&map));
        assert_eq!((map.grid.as_ref().unwrap().width(), map.grid.as_ref().unwrap().height()), (32, 48));
        for grid in map.grid.iter().chain(&map.coarse_grids) {
            let index = grid.index_of(grid.cell_at(marked).unwrap());
            assert_eq!(grid.cells[index], 2.5);
            assert_eq!(grid.cells.iter().filter(|cell| **cell != 0.0).count(), 1);
        }
        let before = map.clone();
        for far in [1e4, 1e300, f64::INFINITY] {
            assert_eq!(RULES.make_room(&mut map, [0.0, 0.0], [far, 1.0]).unwrap(), Grown::TooLarge);
        }
        assert_eq!(map, before);
    }
}
