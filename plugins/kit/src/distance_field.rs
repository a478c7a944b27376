//! Exact squared Euclidean distance of every cell to the nearest marked cell.
//!
//! Columns first, then rows, as Meijster, Roerdink and Hesselink, "A general algorithm for computing distance
//! transforms in linear time" (2000). The row pass differs: most cells lie near a marked one, so every block of cells
//! first looks at its neighbors outwards while any could still be nearer, which vectorizes; only a row with cells
//! farther than a fixed reach takes the lower envelope of parabolas of Felzenszwalb and Huttenlocher (2012). The time
//! is linear in the number of cells either way.

use crate::{GridSize, simd};

/// Squared distance of every cell when no cell is marked.
pub const NO_MARK: u32 = u32::MAX;

/// Longest side of a grid: squared distances must fit 32 bits.
pub const LONGEST_SIDE: usize = 32_767;

/// Larger than any distance inside a grid, and its square still fits.
const FAR: u32 = 32_768;
const FAR_SQUARED: u32 = FAR * FAR;

/// Cells handled together in the row pass.
const BLOCK: usize = 32;
/// How far the row pass looks before it falls back on parabolas.
const REACH: usize = 64;

/// Squared distance in cells from each cell's center to that of the nearest marked (nonzero) cell.
pub fn squared_distance_field(size: GridSize, marked: &[u8]) -> Vec<u32> {
    let mut field = vec![0; size.n_cells()];
    squared_distance_field_into(size, marked, &mut field);
    field
}

/// [`squared_distance_field`] into memory that is already there.
pub fn squared_distance_field_into(size: GridSize, marked: &[u8], field: &mut [u32]) {
    assert_eq!(marked.len(), size.n_cells(), "one byte per cell");
    assert_eq!(field.len(), size.n_cells(), "one distance per cell");
    assert!(size.width.max(size.height) <= LONGEST_SIDE, "a side is longer than {LONGEST_SIDE} cells");
    if !field.is_empty() {
        simd::widest(FillField { size, marked, field });
    }
}

struct FillField<'a> {
    size: GridSize,
    marked: &'a [u8],
    field: &'a mut [u32],
}

impl simd::Kernel for FillField<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: simd::Vectors>(self) {
        let Self { size, marked, field } = self;
        let GridSize { width, height } = size;
        let mut from_below = vec![FAR; width];
        for (row, marks) in field.chunks_exact_mut(width).zip(marked.chunks_exact(width)) {
            step_column_distances(&mut from_below, marks);
            row.copy_from_slice(&from_below);
        }
        let mut from_above = vec![FAR; width];
        let mut rows = RowPass::new(width);
        for row in (0..height).rev() {
            step_column_distances(&mut from_above, &marked[row * width..][..width]);
            rows.fill_row(&from_above, &mut field[row * width..][..width]);
        }
    }
}

/// One row onwards: a marked cell is at distance 0, any other one farther than the cell before it.
#[inline(always)]
fn step_column_distances(distances: &mut [u32], marks: &[u8]) {
    for (distance, &mark) in distances.iter_mut().zip(marks) {
        *distance = if mark == 0 { (*distance + 1).min(FAR) } else { 0 };
    }
}

/// Working memory of the row pass.
struct RowPass {
    width: usize,
    /// Squared column distances of the row, with `REACH` far cells before it and at least as many after it.
    padded: Vec<u32>,
    /// Sites of the lower envelope and where each one begins to be the nearest.
    sites: Vec<(u32, u32)>,
}

impl RowPass {
    fn new(width: usize) -> Self {
        let n_blocks = width.div_ceil(BLOCK);
        Self {
            width,
            padded: vec![FAR_SQUARED; n_blocks * BLOCK + 2 * REACH],
            sites: Vec::with_capacity(width),
        }
    }

    /// Turns a row of column distances (the smaller of `row` and `other`) into squared distances.
    #[inline(always)]
    fn fill_row(&mut self, other: &[u32], row: &mut [u32]) {
        let squares = &mut self.padded[REACH..][..self.width];
        for ((square, &a), &b) in squares.iter_mut().zip(&*row).zip(other) {
            let distance = a.min(b);
            *square = distance * distance;
        }
        for (i, cells) in row.chunks_mut(BLOCK).enumerate() {
            let Some(nearest) = nearest_within_reach(&self.padded[i * BLOCK..][..BLOCK + 2 * REACH]) else {
                self.fill_row_by_envelope(row);
                return;
            };
            cells.copy_from_slice(&nearest[..cells.len()]);
        }
    }

    #[inline(never)]
    fn fill_row_by_envelope(&mut self, row: &mut [u32]) {
        let squares = &self.padded[REACH..][..self.width];
        self.sites.clear();
        for (col, &square) in (0_u32..).zip(squares) {
            if square == FAR_SQUARED {
                continue;
            }
            let mut begins = 0;
            while let Some(&(site, site_begins)) = self.sites.last() {
                begins = first_nearer(site, squares[site as usize], col, square);
                if begins > site_begins {
                    break;
                }
                self.sites.pop();
                begins = 0;
            }
            if (begins as usize) < self.width {
                self.sites.push((col, begins));
            }
        }
        if self.sites.is_empty() {
            row.fill(NO_MARK);
            return;
        }
        let mut ends = self.width;
        for &(site, begins) in self.sites.iter().rev() {
            for (col, cell) in (begins..).zip(&mut row[begins as usize..ends]) {
                *cell = col.abs_diff(site).pow(2) + squares[site as usize];
            }
            ends = begins as usize;
        }
    }
}

/// Smallest sum of a squared offset and the square found there, for a block of cells in the middle of its
/// surroundings; `None` when something beyond the reach could be nearer.
#[inline(always)]
fn nearest_within_reach(around: &[u32]) -> Option<[u32; BLOCK]> {
    let mut nearest = [0; BLOCK];
    nearest.copy_from_slice(&around[REACH..REACH + BLOCK]);
    let mut offset = 1;
    while offset <= REACH {
        let farthest = nearest.iter().fold(0, |a, &b| a.max(b));
        if (offset * offset) as u32 >= farthest {
            return Some(nearest);
        }
        for offset in offset..offset + 4 {
            let left = &around[REACH - offset..][..BLOCK];
            let right = &around[REACH + offset..][..BLOCK];
            let added = (offset * offset) as u32;
            for i in 0..BLOCK {
                nearest[i] = nearest[i].min(left[i].min(right[i]) + added);
            }
        }
        offset += 4;
    }
    None
}

/// First column at which `later` (right of `site`) is at least as near; 0 when it is nearer everywhere.
#[inline(always)]
fn first_nearer(site: u32, site_square: u32, later: u32, later_square: u32) -> u32 {
    // Equal at x: (x - site)² + a = (x - later)² + b, so x = (later² - site² + b - a) / (2 (later - site)).
    let (s, l) = (i64::from(site), i64::from(later));
    let numerator = l * l - s * s + i64::from(later_square) - i64::from(site_square);
    let denominator = 2 * (l - s);
    if numerator <= 0 { 0 } else { ((numerator + denominator - 1) / denominator) as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn brute_force(size: GridSize, marked: &[u8]) -> Vec<u32> {
        let marks: Vec<(usize, usize)> =
            (0..size.n_cells()).filter(|&i| marked[i] != 0).map(|i| size.col_row(i)).collect();
        let nearest = |i| {
            let (col, row) = size.col_row(i);
            let squared = |&(c, r): &(usize, usize)| (c.abs_diff(col).pow(2) + r.abs_diff(row).pow(2)) as u32;
            marks.iter().map(squared).min().unwrap_or(NO_MARK)
        };
        (0..size.n_cells()).map(nearest).collect()
    }

    #[test]
    fn the_field_is_that_of_brute_force_on_random_grids() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
        for round in 0..200 {
            // Long thin grids with few marks need the parabolas.
            let (widest, tallest) = [(40, 40), (400, 6), (6, 300), (150, 60)][round % 4];
            let size =
                GridSize::new(1 + rng.next_u32() as usize % widest, 1 + rng.next_u32() as usize % tallest);
            let n_marks = [0, 1, 2, 5, 60][rng.next_u32() as usize % 5];
            let mut marked = vec![0; size.n_cells()];
            for _ in 0..n_marks {
                marked[rng.random_range(0..size.n_cells())] = 1;
            }
            let oracle = brute_force(size, &marked);
            assert_eq!(squared_distance_field(size, &marked), oracle, "{size:?} with {n_marks} marks");
            let mut scalar = vec![0; size.n_cells()];
            simd::narrowest(FillField { size, marked: &marked, field: &mut scalar });
            assert_eq!(scalar, oracle, "scalar twin, {size:?} with {n_marks} marks");
        }
    }

    #[test]
    fn a_grid_without_cells_has_an_empty_field() {
        assert!(squared_distance_field(GridSize::new(0, 0), &[]).is_empty());
        assert!(squared_distance_field(GridSize::new(0, 5), &[]).is_empty());
    }

    #[test]
    fn a_grid_without_marks_is_far_everywhere() {
        assert_eq!(squared_distance_field(GridSize::new(3, 2), &[0; 6]), [NO_MARK; 6]);
    }
}
