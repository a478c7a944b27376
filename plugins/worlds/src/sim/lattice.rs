//! Solids and map cells sorted into a lattice of square cells, with the empty squares around each cell.
//!
//! For each of the four diagonal directions a cell knows the largest empty square that starts at it and extends that
//! way, so that a ray leaps over empty rooms and still stops exactly at the edge of the cell it meets. The empty-square
//! recurrence is the one of maximal square problems; leaping over empty blocks is known from distance-field ray
//! marching (Zuiderveld, Koning, Viergever, *Acceleration of ray-casting using 3-D distance transforms*, 1992).
//! All lengths here are in cells.

use rumbo_kit::world_file::segment_cells;

use super::solid::{Footprint, Point, Solid};

/// What a cell is, beyond the empty squares around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Nothing in it.
    Empty,
    /// A piece of wall of the background map.
    Wall,
    /// Parts of solids.
    Listed,
    /// Parts of solids in a piece of wall.
    WalledAndListed,
    /// The rim around the lattice.
    Outside,
}

const LARGEST_LEAP: u8 = u8::MAX;
/// Solids are listed in neighbors they barely touch, so rounding cannot lose them.
const MARGIN: f64 = 1e-6;

/// A lattice ready for rays and distances. A rim of one cell keeps rays inside the arrays.
#[derive(Debug, Clone)]
pub struct Lattice {
    /// Number of columns.
    pub(super) width: usize,
    /// Number of rows.
    pub(super) height: usize,
    /// Edge of the empty square that starts at each cell, per diagonal direction (index [`quadrant`]); 0 where the
    /// cell is not empty.
    pub(super) leap: [Vec<u8>; 4],
    kinds: Vec<Kind>,
    /// Where each cell's solids begin in `listed`; empty without solids.
    first: Vec<u32>,
    listed: Vec<u32>,
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
        let mut lattice = Self {
            width,
            height,
            leap: [const { Vec::new() }; 4],
            kinds: vec![Kind::Outside; (width + 2) * (height + 2)],
            first: Vec::new(),
            listed: Vec::new(),
            solids,
            wall_height,
        };
        for (row, col) in (0..height).flat_map(|row| (0..width).map(move |col| (row, col))) {
            let cell = lattice.cell(col as i32, row as i32);
            lattice.kinds[cell] = if is_wall(col, row) { Kind::Wall } else { Kind::Empty };
        }
        lattice.list_solids();
        lattice.leap = [0, 1, 2, 3].map(|direction| lattice.empty_squares(direction));
        lattice
    }

    /// Cells in a row of the arrays, rim included.
    pub(super) fn stride(&self) -> usize {
        self.width + 2
    }

    /// Position of a cell in the arrays; the rim has column or row -1 and `width` or `height`.
    #[inline(always)]
    pub(super) fn cell(&self, col: i32, row: i32) -> usize {
        (row + 1) as usize * self.stride() + (col + 1) as usize
    }

    pub(super) fn kind(&self, cell: usize) -> Kind {
        self.kinds[cell]
    }

    /// Indices of the solids in a cell.
    pub(super) fn solids_in(&self, cell: usize) -> &[u32] {
        match self.first.get(cell..cell + 2) {
            Some(range) => &self.listed[range[0] as usize..range[1] as usize],
            None => &[],
        }
    }

    /// How many rings of cells around this one are surely empty, itself included; 0 for a cell with something in it.
    pub(super) fn free_rings(&self, cell: usize) -> usize {
        self.leap.iter().map(|leap| usize::from(leap[cell])).min().unwrap_or(0)
    }

    /// Compressed lists of the solids that touch each cell.
    fn list_solids(&mut self) {
        if self.solids.is_empty() {
            return;
        }
        let (width, height) = (self.width as i64, self.height as i64);
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (idx, solid) in self.solids.iter().enumerate() {
            touched_cells(&solid.footprint, |col, row| {
                if (0..width).contains(&col) && (0..height).contains(&row) {
                    pairs.push((self.cell(col as i32, row as i32) as u32, idx as u32));
                }
            });
        }
        pairs.sort_unstable();
        pairs.dedup();
        self.first = vec![0; self.kinds.len() + 1];
        for &(cell, _) in &pairs {
            self.first[cell as usize + 1] += 1;
            let kind = &mut self.kinds[cell as usize];
            *kind = if matches!(kind, Kind::Wall | Kind::WalledAndListed) {
                Kind::WalledAndListed
            } else {
                Kind::Listed
            };
        }
        for cell in 0..self.kinds.len() {
            self.first[cell + 1] += self.first[cell];
        }
        self.listed = pairs.into_iter().map(|(_, idx)| idx).collect();
    }

    /// Edge of the largest empty square that starts at each cell and extends in one diagonal direction.
    fn empty_squares(&self, direction: usize) -> Vec<u8> {
        let (leftwards, downwards) = (direction & 1 != 0, direction & 2 != 0);
        let (width, height) = (self.width as i32, self.height as i32);
        let mut edges = vec![0; self.kinds.len()];
        let (beside, ahead) = (if leftwards { -1 } else { 1 }, if downwards { -1 } else { 1 });
        for n_rows in 0..height {
            // Against the direction, so the cells the square extends to are done.
            let row = if downwards { n_rows } else { height - 1 - n_rows };
            for n_cols in 0..width {
                let col = if leftwards { n_cols } else { width - 1 - n_cols };
                let cell = self.cell(col, row);
                if self.kinds[cell] == Kind::Empty {
                    let around = [(beside, 0), (0, ahead), (beside, ahead)];
                    let smallest = around.map(|(c, r)| edges[self.cell(col + c, row + r)]).into_iter().min();
                    edges[cell] = smallest.unwrap_or(0).min(LARGEST_LEAP - 1) + 1;
                }
            }
        }
        edges
    }
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
                let edge = i64::from(leap[lattice.cell(col, row)]);
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
        for (col, row) in (0..5).flat_map(|row| (0..5).map(move |col| (col, row))) {
            let touches = (1..=2).contains(&col) && (1..=2).contains(&row);
            assert_eq!(
                lattice.solids_in(lattice.cell(col, row)).len(),
                usize::from(touches),
                "cell {col},{row}"
            );
        }
        let kind = |col, row| lattice.kind(lattice.cell(col, row));
        assert_eq!((kind(1, 1), kind(2, 1), kind(0, 0)), (Kind::WalledAndListed, Kind::Listed, Kind::Empty));
        assert_eq!((kind(-1, 0), kind(5, 5)), (Kind::Outside, Kind::Outside));
        assert_eq!(lattice.free_rings(lattice.cell(1, 1)), 0);
        assert_eq!(lattice.free_rings(lattice.cell(0, 0)), 1);
    }
}
