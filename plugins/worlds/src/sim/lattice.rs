//! Solids and map cells sorted into a lattice of square cells, with the empty squares around each cell.
//!
//! For each of the four diagonal directions a cell knows the largest empty square that starts at it and extends that
//! way, so that a ray leaps over empty rooms and still stops exactly at the edge of the cell it meets. The empty-square
//! recurrence is the one of maximal square problems; leaping over empty blocks is known from distance-field ray
//! marching (Zuiderveld, Koning, Viergever, *Acceleration of ray-casting using 3-D distance transforms*, 1992).
//! All lengths here are in cells.

use rumbo_kit::world_file::segment_cells;

use super::solid::{Footprint, Point, Solid};

/// The cell is a piece of wall of the background map.
pub(super) const WALL: u8 = 0;
/// The cell holds parts of solids, and possibly a wall too.
pub(super) const LISTED: u8 = 255;
const LARGEST_LEAP: u8 = 254;
/// Solids are listed in neighbors they barely touch, so rounding cannot lose them.
const MARGIN: f64 = 1e-6;

/// A lattice ready for rays and distances.
#[derive(Debug, Clone)]
pub struct Lattice {
    /// Number of columns.
    pub(super) width: usize,
    /// Number of rows.
    pub(super) height: usize,
    /// Per cell and diagonal direction (index [`quadrant`]): [`WALL`], [`LISTED`] or the edge of the empty square.
    pub(super) leap: [Vec<u8>; 4],
    /// Where each cell's solids begin in `listed`; empty without solids.
    first: Vec<u32>,
    listed: Vec<u32>,
    /// Listed cells that are a wall of the background map as well, sorted.
    walled: Vec<u32>,
    /// The solids.
    pub(super) solids: Vec<Solid>,
    /// Height of the background map's walls.
    pub(super) wall_height: f64,
}

/// Index of the diagonal direction a ray goes: bit 0 set to the left, bit 1 set downwards.
pub(super) fn quadrant(along_x: f64, along_y: f64) -> usize {
    usize::from(along_x < 0.0) | usize::from(along_y < 0.0) << 1
}

impl Lattice {
    /// Sorts solids into a lattice whose walls are given by `is_wall(col, row)`.
    pub fn new(
        size: (usize, usize),
        wall_height: f64,
        solids: Vec<Solid>,
        is_wall: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let (width, height) = size;
        let mut kinds: Vec<u8> =
            (0..width * height).map(|idx| if is_wall(idx % width, idx / width) { WALL } else { 1 }).collect();
        let (first, listed) = list_solids(width, height, &solids);
        let mut walled = Vec::new();
        for (cell, range) in first.windows(2).enumerate() {
            if range[0] < range[1] {
                if kinds[cell] == WALL {
                    walled.push(cell as u32);
                }
                kinds[cell] = LISTED;
            }
        }
        let leap = [0, 1, 2, 3].map(|direction| empty_squares(&kinds, width, direction));
        Self { width, height, leap, first, listed, walled, solids, wall_height }
    }

    /// Indices of the solids in a cell.
    pub(super) fn solids_in(&self, cell: usize) -> &[u32] {
        match self.first.get(cell..cell + 2) {
            Some(range) => &self.listed[range[0] as usize..range[1] as usize],
            None => &[],
        }
    }

    /// Whether a listed cell is a wall of the background too.
    pub(super) fn is_walled(&self, cell: usize) -> bool {
        !self.walled.is_empty() && self.walled.binary_search(&(cell as u32)).is_ok()
    }

    /// How many rings of cells around this one are surely empty, itself included; 0 for a cell with something in it.
    pub(super) fn free_rings(&self, cell: usize) -> usize {
        self.leap
            .iter()
            .map(|leap| if leap[cell] == LISTED { 0 } else { usize::from(leap[cell]) })
            .min()
            .unwrap_or(0)
    }
}

/// Compressed lists of the solids that touch each cell.
fn list_solids(width: usize, height: usize, solids: &[Solid]) -> (Vec<u32>, Vec<u32>) {
    if solids.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for (idx, solid) in solids.iter().enumerate() {
        touched_cells(&solid.footprint, |col, row| {
            if (0..width as i64).contains(&col) && (0..height as i64).contains(&row) {
                pairs.push(((row as usize * width + col as usize) as u32, idx as u32));
            }
        });
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut first = vec![0; width * height + 1];
    for &(cell, _) in &pairs {
        first[cell as usize + 1] += 1;
    }
    for cell in 0..width * height {
        first[cell + 1] += first[cell];
    }
    (first, pairs.into_iter().map(|(_, idx)| idx).collect())
}

/// Every cell that a footprint touches, inside included.
fn touched_cells(footprint: &Footprint, mut visit: impl FnMut(i64, i64)) {
    if let Footprint::Segment { from, to } = *footprint {
        return segment_cells([from.x, from.y], [to.x, to.y], MARGIN, visit);
    }
    let (center, radius) = footprint.bounding_disc();
    // Half of a cell's diagonal: a cell is touched only if its center is that near.
    let reach = std::f64::consts::FRAC_1_SQRT_2 + MARGIN;
    let range =
        |middle: f64| (middle - radius - MARGIN).floor() as i64..=(middle + radius + MARGIN).floor() as i64;
    for (row, col) in range(center.y).flat_map(|row| range(center.x).map(move |col| (row, col))) {
        if footprint.distance(Point::new(col as f64 + 0.5, row as f64 + 0.5)) <= reach {
            visit(col, row);
        }
    }
}

/// Edge of the largest empty square that starts at each cell and extends in one diagonal direction.
fn empty_squares(kinds: &[u8], width: usize, direction: usize) -> Vec<u8> {
    let height = kinds.len() / width.max(1);
    let (leftwards, downwards) = (direction & 1 != 0, direction & 2 != 0);
    let mut edges = kinds.to_vec();
    let edge_of = |kind: u8| if kind == LISTED { 0 } else { kind };
    for n_rows in 0..height {
        // Against the direction, so the cells the square extends to are done.
        let row = if downwards { n_rows } else { height - 1 - n_rows };
        for n_cols in 0..width {
            let col = if leftwards { n_cols } else { width - 1 - n_cols };
            let cell = row * width + col;
            if kinds[cell] == WALL || kinds[cell] == LISTED || n_rows == 0 || n_cols == 0 {
                continue;
            }
            let beside = if leftwards { cell - 1 } else { cell + 1 };
            let (ahead, diagonal) =
                if downwards { (cell - width, beside - width) } else { (cell + width, beside + width) };
            let smallest = edge_of(edges[beside]).min(edge_of(edges[ahead])).min(edge_of(edges[diagonal]));
            edges[cell] = (smallest + 1).min(LARGEST_LEAP);
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_leap_is_empty_and_cannot_be_longer() {
        let picture = ["..........", "...#......", "..........", ".......#..", ".........."];
        let is_wall = |col: usize, row: usize| picture[row].as_bytes()[col] == b'#';
        let lattice = Lattice::new((10, 5), 2.0, Vec::new(), is_wall);
        for (direction, leap) in lattice.leap.iter().enumerate() {
            for (row, col) in (0..5).flat_map(|row| (0..10).map(move |col| (row, col))) {
                let empty = |edge: i64| {
                    (0..edge).flat_map(|a| (0..edge).map(move |b| (a, b))).all(|(a, b)| {
                        let c = col as i64 + if direction & 1 == 0 { a } else { -a };
                        let r = row as i64 + if direction & 2 == 0 { b } else { -b };
                        (0..10).contains(&c) && (0..5).contains(&r) && !is_wall(c as usize, r as usize)
                    })
                };
                let edge = i64::from(leap[row * 10 + col]);
                assert!(
                    empty(edge) && !empty(edge + 1),
                    "direction {direction} cell {col},{row} edge {edge}"
                );
            }
        }
    }

    #[test]
    fn a_solid_is_listed_wherever_it_touches() {
        let disc = Solid {
            footprint: Footprint::Disc { center: Point::new(2.0, 2.0), radius: 0.5 },
            z_min: 0.0,
            z_max: 1.0,
            is_glass: false,
        };
        let lattice = Lattice::new((5, 5), 2.0, vec![disc], |col, row| (col, row) == (1, 1));
        for cell in 0..25 {
            let (col, row) = (cell % 5, cell / 5);
            let touches = (1..=2).contains(&col) && (1..=2).contains(&row);
            assert_eq!(lattice.solids_in(cell).len(), usize::from(touches), "cell {col},{row}");
        }
        assert!(lattice.is_walled(6) && !lattice.is_walled(7));
        assert_eq!(lattice.free_rings(6), 0);
        assert_eq!(lattice.free_rings(0), 1);
    }
}
