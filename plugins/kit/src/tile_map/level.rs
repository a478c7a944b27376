//! One level: a rectangle of references to tiles, which grows.

use super::tile::{TILE_CELLS, Tile};
use crate::GridSize;
use crate::scan_match::MatchLevel;
use rumbo_core::frames::{Pose2, pose2};
use std::sync::Arc;

/// Tiles by place. Cell (0, 0) has its lower left corner at the origin of the map.
#[derive(Debug, Clone)]
pub struct TileLevel {
    resolution_m: f64,
    /// Log-odds of one unit of a cell.
    unit: f32,
    /// The lower left tile of the rectangle, counted in tiles from the origin.
    first: [i64; 2],
    /// Tiles along x and y.
    size: [usize; 2],
    tiles: Vec<Option<Arc<Tile>>>,
}

impl TileLevel {
    pub(super) fn new(resolution_m: f64, unit: f32) -> TileLevel {
        TileLevel { resolution_m, unit, first: [0; 2], size: [0; 2], tiles: Vec::new() }
    }

    /// Edge of a cell, meters.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Log-odds of one unit of its cells.
    pub fn unit(&self) -> f32 {
        self.unit
    }

    /// The lower left tile of the rectangle that holds all tiles, counted from the origin.
    pub fn first_tile(&self) -> [i64; 2] {
        self.first
    }

    /// Tiles of that rectangle along x and y.
    pub fn size_tiles(&self) -> [usize; 2] {
        self.size
    }

    fn index(&self, tile: [i64; 2]) -> Option<usize> {
        let [x, y] = [0, 1].map(|axis| usize::try_from(tile[axis] - self.first[axis]).ok());
        let (x, y) = (x?, y?);
        (x < self.size[0] && y < self.size[1]).then(|| y * self.size[0] + x)
    }

    /// The tile at this place, counted in tiles from the origin.
    pub fn tile(&self, tile: [i64; 2]) -> Option<&Arc<Tile>> {
        self.tiles.get(self.index(tile)?)?.as_ref()
    }

    /// Log-odds of a cell counted from the origin; 0 where no scan has been.
    pub fn cell(&self, cell: [i64; 2]) -> f32 {
        let edge = TILE_CELLS as i64;
        let [col, row] = cell.map(|v| v.rem_euclid(edge) as usize);
        self.tile(cell.map(|v| v.div_euclid(edge))).map_or(0.0, |tile| self.unit * tile.at(col, row))
    }

    /// All tiles that are there, with their places.
    pub fn tiles(&self) -> impl Iterator<Item = ([i64; 2], &Arc<Tile>)> {
        let place = |idx: usize| {
            [self.first[0] + (idx % self.size[0]) as i64, self.first[1] + (idx / self.size[0]) as i64]
        };
        self.tiles.iter().enumerate().filter_map(move |(idx, tile)| Some((place(idx), tile.as_ref()?)))
    }

    /// A tile to write to: made if it is not there, copied if somebody else has it too.
    pub(super) fn tile_mut(&mut self, tile: [i64; 2]) -> Option<&mut Tile> {
        self.make_room(tile, tile);
        let idx = self.index(tile)?;
        let slot = self.tiles.get_mut(idx)?;
        Some(Arc::make_mut(slot.get_or_insert_with(|| Arc::new(Tile::unknown()))))
    }

    /// Puts a tile that others may have too.
    pub(super) fn put(&mut self, place: [i64; 2], tile: Arc<Tile>) {
        self.make_room(place, place);
        if let Some(slot) = self.index(place).and_then(|idx| self.tiles.get_mut(idx)) {
            *slot = Some(tile);
        }
    }

    /// Lets the rectangle hold these two tiles and all between them.
    pub(super) fn make_room(&mut self, low: [i64; 2], high: [i64; 2]) {
        if self.index(low).is_some() && self.index(high).is_some() {
            return;
        }
        let is_empty = self.tiles.is_empty();
        let end = [0, 1].map(|axis| self.first[axis] + self.size[axis] as i64);
        let first = [0, 1].map(|k| if is_empty { low[k] } else { low[k].min(self.first[k]) });
        let end = [0, 1].map(|k| if is_empty { high[k] + 1 } else { (high[k] + 1).max(end[k]) });
        let size = [0, 1].map(|k| (end[k] - first[k]) as usize);
        let mut tiles = vec![None; size[0] * size[1]];
        for (idx, tile) in std::mem::take(&mut self.tiles).into_iter().enumerate() {
            let col = (self.first[0] - first[0]) as usize + idx % self.size[0];
            let row = (self.first[1] - first[1]) as usize + idx / self.size[0];
            if let Some(slot) = tiles.get_mut(row * size[0] + col) {
                *slot = tile;
            }
        }
        (self.first, self.size, self.tiles) = (first, size, tiles);
    }
}

/// A level as scans are matched against it.
#[derive(Debug, Clone, Copy)]
pub struct LevelView<'a> {
    level: &'a TileLevel,
    level_from_map: Pose2,
}

impl<'a> LevelView<'a> {
    /// Looks at a level.
    pub fn new(level: &'a TileLevel) -> LevelView<'a> {
        let edge_m = TILE_CELLS as f64 * level.resolution_m;
        let [x, y] = level.first.map(|tile| -(tile as f64) * edge_m);
        LevelView { level, level_from_map: pose2(x, y, 0.0) }
    }
}

impl MatchLevel for LevelView<'_> {
    #[inline(always)]
    fn resolution_m(&self) -> f64 {
        self.level.resolution_m
    }

    #[inline(always)]
    fn level_from_map(&self) -> Pose2 {
        self.level_from_map
    }

    #[inline(always)]
    fn size(&self) -> GridSize {
        GridSize::new(self.level.size[0] * TILE_CELLS, self.level.size[1] * TILE_CELLS)
    }

    #[inline(always)]
    fn corners(&self, col: usize, row: usize) -> [f32; 4] {
        let (width, unit) = (self.level.size[0], self.level.unit);
        let tile = |col: usize, row: usize| {
            self.level.tiles.get(row / TILE_CELLS * width + col / TILE_CELLS).and_then(Option::as_deref)
        };
        let is_within = col % TILE_CELLS < TILE_CELLS - 1 && row % TILE_CELLS < TILE_CELLS - 1;
        if is_within {
            let Some(tile) = tile(col, row) else { return [0.0; 4] };
            return [
                tile.at(col, row),
                tile.at(col + 1, row),
                tile.at(col, row + 1),
                tile.at(col + 1, row + 1),
            ]
            .map(|units| unit * units);
        }
        let cell = |col: usize, row: usize| tile(col, row).map_or(0.0, |tile| unit * tile.at(col, row));
        [cell(col, row), cell(col + 1, row), cell(col, row + 1), cell(col + 1, row + 1)]
    }
}
