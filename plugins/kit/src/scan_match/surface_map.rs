//! Where the surfaces of the map are, finer than its cells: the sum of squared distances from the lines that scans have
//! seen around each cell.
//!
//! A cell of 5 cm says that something is in it, not where. Here each end of a beam, with the direction that its surface
//! faces in the scan, is a line, and a cell keeps the quadratic form that gives the mean squared distance of any point from
//! the lines in and around it: the error quadric of Garland, Heckbert, *Surface Simplification Using Quadric Error
//! Metrics*, SIGGRAPH 1997, in the plane. Forms add up, so a scan is put in without looking at those before it.

use super::points::ScanPoints;
use super::surface_normals::SurfaceNormals;
use rumbo_core::frames::Pose2;

/// Cells along the edge of a tile, as a power of two.
const TILE_BITS: u32 = 3;
const TILE_EDGE: usize = 1 << TILE_BITS;
const TILE_CELLS: usize = TILE_EDGE * TILE_EDGE;
/// Beyond so many lines a cell forgets the oldest: scans that are matched against it may move it, slowly.
const MOST_LINES: f32 = 50.0;
/// Cells beyond this many from the origin are left out.
const FARTHEST_CELL: f64 = 1e8;

/// The sum over lines of `w (n·(p - m) - d)²` around the middle `m` of a cell, in cells: `A` (xx, xy, yy), `b` (x, y), `c`,
/// and the sum of `w`.
pub(super) type Quadric = [f32; 8];

/// The surfaces that scans have seen.
#[derive(Debug, Clone)]
pub struct SurfaceMap {
    resolution_m: f64,
    level_from_map: Pose2,
    /// Number of each tile, one more than its place in `tiles`; zero where there is none. Rows from the lower left.
    index: Vec<u32>,
    first: [i32; 2],
    size: [usize; 2],
    tiles: Vec<[Quadric; TILE_CELLS]>,
    normals: SurfaceNormals,
}

impl SurfaceMap {
    /// Numbers in a tile.
    pub const TILE_NUMBERS: usize = 8 * TILE_CELLS;

    /// Nothing was seen yet. Cells have this edge, and the frame is that of the level's lower left corner, wherever cells are
    /// later added around it.
    pub fn new(resolution_m: f64, level_from_map: Pose2) -> SurfaceMap {
        SurfaceMap {
            resolution_m,
            level_from_map,
            index: Vec::new(),
            first: [0; 2],
            size: [0; 2],
            tiles: Vec::new(),
            normals: SurfaceNormals::default(),
        }
    }

    /// Edge of a cell, meters.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// The frame that cells are counted in.
    pub fn level_from_map(&self) -> Pose2 {
        self.level_from_map
    }

    /// The tiles and where they lie, for a save: columns and rows of tiles, and the numbers of their cells.
    pub fn tiles(&self) -> impl Iterator<Item = ([i32; 2], &[[f32; 8]])> {
        let width = self.size[0].max(1);
        let place = move |k: usize| [self.first[0] + (k % width) as i32, self.first[1] + (k / width) as i32];
        let known = self.index.iter().enumerate().filter(|(_, number)| **number > 0);
        known
            .filter_map(move |(k, number)| Some((place(k), self.tiles.get(*number as usize - 1)?.as_slice())))
    }

    /// Puts a tile of a save back; false where it is none.
    pub fn put_tile(&mut self, tile: [i32; 2], cells: &[[f32; 8]]) -> bool {
        let is_near = tile.iter().all(|v| f64::from(*v).abs() < FARTHEST_CELL / TILE_EDGE as f64);
        let Ok(cells) = <[Quadric; TILE_CELLS]>::try_from(cells) else { return false };
        let is_fine = is_near && cells.iter().flatten().all(|v| v.is_finite());
        if is_fine {
            self.make_room(tile);
            *self.tile_mut(tile) = cells;
        }
        is_fine
    }

    /// Puts the points of a scan in, which are in the base frame in the order of the beams.
    pub fn insert(&mut self, points: &ScanPoints, map_from_base: &Pose2) {
        let mut normals = std::mem::take(&mut self.normals);
        normals.find(points, self.resolution_m);
        let level_from_base = self.level_from_map * map_from_base;
        let (cos, sin) = (level_from_base.rotation.re, level_from_base.rotation.im);
        let [x0, y0] = [level_from_base.translation.x, level_from_base.translation.y];
        for ([x, y, weight], facing) in points.iter().zip(&normals.facings) {
            let lines = facing.share * weight;
            let [x, y] = [f64::from(x), f64::from(y)];
            let end = [cos * x - sin * y + x0, sin * x + cos * y + y0].map(|m| m / self.resolution_m);
            if lines > 0.0 && end.iter().all(|v| v.abs() < FARTHEST_CELL) {
                let [nx, ny] = facing.normal.map(f64::from);
                self.add_line(end, [(cos * nx - sin * ny) as f32, (sin * nx + cos * ny) as f32], lines);
            }
        }
        self.normals = normals;
    }

    /// Adds a line to the nine cells in and around which a beam has ended.
    fn add_line(&mut self, end: [f64; 2], normal: [f32; 2], weight: f32) {
        let cell = end.map(|v| v.floor() as i32);
        let [nx, ny] = normal;
        let part = [0, 1].map(|axis| (end[axis] - f64::from(cell[axis]) - 0.5) as f32);
        let a = [weight * nx * nx, weight * nx * ny, weight * ny * ny];
        self.make_room(cell.map(|v| (v - 1) >> TILE_BITS));
        self.make_room(cell.map(|v| (v + 1) >> TILE_BITS));
        for row in -1..=1 {
            for col in -1..=1 {
                let distance = nx * (part[0] - col as f32) + ny * (part[1] - row as f32);
                let along = weight * distance;
                let line = [a[0], a[1], a[2], nx * along, ny * along, along * distance, weight, 0.0];
                let quadric = self.quadric_mut([cell[0] + col, cell[1] + row]);
                for (sum, term) in quadric.iter_mut().zip(line) {
                    *sum += term;
                }
                if quadric[6] > MOST_LINES {
                    quadric.iter_mut().for_each(|sum| *sum *= 0.5);
                }
            }
        }
    }

    /// What is known around a cell; none where no beam has ended in it or beside it.
    #[inline(always)]
    pub(super) fn quadric(&self, cell: [i32; 2]) -> Option<&Quadric> {
        let tile = [0, 1].map(|axis| ((cell[axis] >> TILE_BITS).wrapping_sub(self.first[axis])) as usize);
        if tile[0] >= self.size[0] {
            return None;
        }
        let number = *self.index.get(tile[1].wrapping_mul(self.size[0]).wrapping_add(tile[0]))?;
        self.tiles.get((number as usize).wrapping_sub(1))?.get(within_tile(cell))
    }

    #[inline]
    fn quadric_mut(&mut self, cell: [i32; 2]) -> &mut Quadric {
        &mut self.tile_mut(cell.map(|v| v >> TILE_BITS))[within_tile(cell)]
    }

    /// Of a tile that there is room for.
    fn tile_mut(&mut self, tile: [i32; 2]) -> &mut [Quadric; TILE_CELLS] {
        let [col, row] = [0, 1].map(|axis| (tile[axis] - self.first[axis]) as usize);
        let number = &mut self.index[row * self.size[0] + col];
        if *number == 0 {
            self.tiles.push([[0.0; 8]; TILE_CELLS]);
            *number = self.tiles.len() as u32;
        }
        &mut self.tiles[*number as usize - 1]
    }

    /// Makes the index reach a tile, and half as far again as it is wide, so that growth is rare.
    fn make_room(&mut self, tile: [i32; 2]) {
        let last = [0, 1].map(|axis| self.first[axis] + self.size[axis] as i32);
        if (0..2).all(|axis| tile[axis] >= self.first[axis] && tile[axis] < last[axis]) {
            return;
        }
        let mut first = self.first;
        let mut end = last;
        for axis in 0..2 {
            let spare = 8 + self.size[axis] as i32 / 2;
            if self.size[axis] == 0 {
                (first[axis], end[axis]) = (tile[axis] - spare, tile[axis] + spare);
            } else if tile[axis] < first[axis] {
                first[axis] = tile[axis] - spare;
            } else if tile[axis] >= end[axis] {
                end[axis] = tile[axis] + spare;
            }
        }
        let size = [0, 1].map(|axis| (end[axis] - first[axis]) as usize);
        let mut index = vec![0; size[0] * size[1]];
        let [col, row] = [0, 1].map(|axis| (self.first[axis] - first[axis]) as usize);
        for (k, old) in self.index.chunks_exact(self.size[0].max(1)).enumerate() {
            let at = (row + k) * size[0] + col;
            index[at..at + old.len()].copy_from_slice(old);
        }
        (self.index, self.first, self.size) = (index, first, size);
    }
}

#[inline(always)]
fn within_tile(cell: [i32; 2]) -> usize {
    let [col, row] = cell.map(|v| (v as usize) & (TILE_EDGE - 1));
    row * TILE_EDGE + col
}
