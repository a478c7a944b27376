//! Obstacle-proximity map: length of the shortest path over eight neighbors from each free cell to an obstacle, in
//! cells. Hernández Alamilla (2005), section 3.2.2 and algorithm 3.1.
//!
//! Differs from the source: every obstacle is a starting point (the printed algorithm begins with one), and cells are
//! queued only when their distance shrinks (else it never ends).

use crate::{GridSize, NEIGHBORS_8};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What a cell is for the proximity map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum CellKind {
    /// Distances spread through it.
    Free = 0,
    /// Distances start here.
    Obstacle = 1,
    /// Neither: it keeps an infinite distance and nothing spreads through it.
    Closed = 2,
}

/// Distances to the nearest obstacle; infinite where no path leads to one.
///
/// All distances are multiples of 2⁻³⁶ cells, so their sums are exact below 65,536 cells and do not depend on the order
/// in which paths were found: adding obstacles gives the same bits as starting anew.
#[derive(Clone, Debug, PartialEq)]
pub struct ProximityMap {
    size: GridSize,
    diagonal_step: f64,
    kinds: Vec<CellKind>,
    distances: Vec<f64>,
}

/// Distances are counted in this fraction of a cell.
const UNITS_PER_CELL: f64 = (1_u64 << 36) as f64;

fn rounded(length: f64) -> f64 {
    (length * UNITS_PER_CELL).round() / UNITS_PER_CELL
}

impl ProximityMap {
    /// The map of these cells; `diagonal_step` is the length of a diagonal step, from 1 to 2.
    pub fn new(size: GridSize, kinds: &[CellKind], diagonal_step: f64) -> Self {
        let mut map = Self { size, diagonal_step, kinds: Vec::new(), distances: Vec::new() };
        map.recompute(size, kinds, diagonal_step);
        map
    }

    /// [`ProximityMap::new`] into memory that is already there.
    pub fn recompute(&mut self, size: GridSize, kinds: &[CellKind], diagonal_step: f64) {
        assert_eq!(kinds.len(), size.n_cells(), "one kind per cell");
        assert!((1.0..=2.0).contains(&diagonal_step), "a diagonal step is {diagonal_step} cells long");
        self.size = size;
        self.diagonal_step = rounded(diagonal_step);
        self.kinds.clear();
        self.kinds.extend_from_slice(kinds);
        self.distances.clear();
        let at_first = |kind: &CellKind| if *kind == CellKind::Obstacle { 0.0 } else { f64::INFINITY };
        self.distances.extend(kinds.iter().map(at_first));
        if kinds.contains(&CellKind::Closed) {
            let obstacles = (0..kinds.len()).filter(|&i| kinds[i] == CellKind::Obstacle);
            let queue = obstacles.map(|i| Reverse((0, i))).collect();
            self.spread(queue);
        } else {
            self.scan();
        }
    }

    /// Adds obstacle cells: the result equals a new map to the bit.
    pub fn add_obstacles(&mut self, cells: &[usize]) {
        let mut queue = BinaryHeap::new();
        for &cell in cells {
            self.kinds[cell] = CellKind::Obstacle;
            self.distances[cell] = 0.0;
            queue.push(Reverse((0, cell)));
        }
        self.spread(queue);
    }

    /// Size of the map.
    pub fn size(&self) -> GridSize {
        self.size
    }

    /// Whether the map was made for this length of a diagonal step.
    pub fn is_for_step(&self, diagonal_step: f64) -> bool {
        self.diagonal_step == rounded(diagonal_step)
    }

    /// Distances, row by row, in cells.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// What the cells are, row by row.
    pub fn kinds(&self) -> &[CellKind] {
        &self.kinds
    }

    /// Dijkstra's algorithm from the queued cells on.
    fn spread(&mut self, mut queue: BinaryHeap<Reverse<(u64, usize)>>) {
        // Bits of numbers that are not negative sort as the numbers do.
        while let Some(Reverse((bits, cell))) = queue.pop() {
            let distance = self.distances[cell];
            if bits != distance.to_bits() {
                continue;
            }
            for (dx, dy) in NEIGHBORS_8 {
                let Some(next) = self.size.neighbor(cell, dx, dy) else { continue };
                let step = if dx != 0 && dy != 0 { self.diagonal_step } else { 1.0 };
                if self.kinds[next] == CellKind::Free && distance + step < self.distances[next] {
                    self.distances[next] = distance + step;
                    queue.push(Reverse(((distance + step).to_bits(), next)));
                }
            }
        }
    }

    /// Two scans, up and down (Rosenfeld and Pfaltz, 1968): exact where paths need not go round closed cells.
    fn scan(&mut self) {
        let GridSize { width, height } = self.size;
        let mut edged = vec![f64::INFINITY; width + 2];
        let scan_row = |distances: &mut [f64], row: usize, from: usize| {
            edged[1..=width].copy_from_slice(&distances[from * width..][..width]);
            relax_from_row(&edged, &mut distances[row * width..][..width], self.diagonal_step);
        };
        let mut scan_row = scan_row;
        for row in 0..height {
            if row > 0 {
                scan_row(&mut self.distances, row, row - 1);
            }
            relax_along(&mut self.distances[row * width..][..width]);
        }
        for row in (0..height.saturating_sub(1)).rev() {
            scan_row(&mut self.distances, row, row + 1);
            relax_along(&mut self.distances[row * width..][..width]);
        }
    }
}

/// Lowers a row by steps from the row beside it, given with one cell more at each end.
fn relax_from_row(beside: &[f64], row: &mut [f64], diagonal_step: f64) {
    for (cell, near) in row.iter_mut().zip(beside.windows(3)) {
        let shortest = (near[0].min(near[2]) + diagonal_step).min(near[1] + 1.0);
        *cell = cell.min(shortest);
    }
}

/// Lowers a row by steps along it, both ways.
fn relax_along(row: &mut [f64]) {
    let mut before = f64::INFINITY;
    for cell in row.iter_mut() {
        before = cell.min(before + 1.0);
        *cell = before;
    }
    let mut after = f64::INFINITY;
    for cell in row.iter_mut().rev() {
        after = cell.min(after + 1.0);
        *cell = after;
    }
}

#[cfg(test)]
mod tests;
