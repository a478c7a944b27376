//! The potential of many charges in every cell of a grid, for drawings: equation (9) in single precision.

use super::{ChargeLaw, NEAREST_CHARGE_M};
use crate::{GridSize, simd};
use nalgebra::Point2;

/// Where the cells of a potential map lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapFrame {
    /// How many cells.
    pub size: GridSize,
    /// Lower left corner of cell (0, 0), meters.
    pub origin: Point2<f64>,
    /// Edge of a cell, meters.
    pub cell_m: f64,
}

impl MapFrame {
    /// Middle of a cell, meters.
    pub fn middle_of(&self, cell: usize) -> Point2<f64> {
        let (col, row) = self.size.col_row(cell);
        let at = |place: usize, k: usize| self.origin[k] + (place as f64 + 0.5) * self.cell_m;
        Point2::new(at(col, 0), at(row, 1))
    }
}

/// Adds the potential of all charges at the middles of the cells to `sums`, which has one number a cell.
///
/// Exponent 2 without a range, the source's, is fast; see [`add_slowly`] for all others.
pub fn add_potential(frame: &MapFrame, law: &ChargeLaw, charges: &[Point2<f64>], sums: &mut [f32]) {
    assert_eq!(sums.len(), frame.size.n_cells(), "one number a cell");
    let diagonal_m = (frame.size.width as f64).hypot(frame.size.height as f64) * frame.cell_m;
    let is_near = |charge: &Point2<f64>| (charge - frame.origin).norm() <= FARTHEST_M;
    let is_fast = law.exponent == 2.0 && law.range_m == f64::INFINITY && diagonal_m <= FARTHEST_M;
    if sums.is_empty() || !is_fast || !charges.iter().all(is_near) {
        return add_slowly(frame, law, charges, sums);
    }
    simd::widest(SumUp { frame, strength: law.strength, charges, sums });
}

/// The twin of [`add_potential`], cell by cell in double precision.
pub fn add_slowly(frame: &MapFrame, law: &ChargeLaw, charges: &[Point2<f64>], sums: &mut [f32]) {
    for (cell, sum) in sums.iter_mut().enumerate() {
        *sum += law.potential_at(frame.middle_of(cell), charges) as f32;
    }
}

/// Four squares of distances up to twice this are multiplied: their product must fit single precision.
const FARTHEST_M: f64 = 10_000.0;
/// Charges whose reciprocals share one division: `1/a + 1/b + 1/c + 1/d = ((a + b) c d + (c + d) a b) / (a b c d)`.
const SHARED: usize = 4;
/// Cells of a row that are summed up together.
const LANES: usize = 64;

struct SumUp<'a> {
    frame: &'a MapFrame,
    strength: f64,
    charges: &'a [Point2<f64>],
    sums: &'a mut [f32],
}

impl simd::Kernel for SumUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: simd::Vectors>(self) {
        let Self { frame, strength, charges, sums } = self;
        let width = frame.size.width;
        let half_strength = 0.5 * strength as f32;
        let middles: Vec<f32> = (0..width.next_multiple_of(LANES))
            .map(|col| ((col as f64 + 0.5) * frame.cell_m) as f32)
            .collect();
        let relative = charges.iter().map(|charge| charge - frame.origin);
        let mut places: Vec<[f32; 2]> = relative.map(|from| [from.x as f32, from.y as f32]).collect();
        // What fills up the last group lies so far away that it adds nothing that single precision could tell.
        let filled = places.len().next_multiple_of(SHARED);
        places.resize(filled, [2.0 * FARTHEST_M as f32; 2]);
        let n_fillers = filled - charges.len();
        for (row, cells) in sums.chunks_exact_mut(width).enumerate() {
            let y = ((row as f64 + 0.5) * frame.cell_m) as f32;
            for (xs, cells) in middles.chunks_exact(LANES).zip(cells.chunks_mut(LANES)) {
                let Some(xs) = xs.first_chunk::<LANES>() else { continue };
                let mut sum = sum_of_reciprocals(&places, xs, y);
                if n_fillers > 0 {
                    take_fillers_away(&mut sum, n_fillers, xs, y);
                }
                for (cell, sum) in cells.iter_mut().zip(sum) {
                    *cell += half_strength * sum;
                }
            }
        }
    }
}

/// Sum of `1 / d²` over the charges at each of these places of a row.
#[inline(always)]
fn sum_of_reciprocals(places: &[[f32; 2]], xs: &[f32; LANES], y: f32) -> [f32; LANES] {
    const NEAREST: f32 = (NEAREST_CHARGE_M * NEAREST_CHARGE_M) as f32;
    let mut sum = [0.0; LANES];
    let (groups, _) = places.as_chunks::<SHARED>();
    for group in groups {
        let rises = group.map(|[_, cy]| (y - cy) * (y - cy));
        for lane in 0..LANES {
            let square = |k: usize| {
                let run = xs[lane] - group[k][0];
                let square = run * run + rises[k];
                if square > NEAREST { square } else { NEAREST }
            };
            let (a, b, c, d) = (square(0), square(1), square(2), square(3));
            let (ab, cd) = (a * b, c * d);
            sum[lane] += ((a + b) * cd + (c + d) * ab) / (ab * cd);
        }
    }
    sum
}

#[inline(always)]
fn take_fillers_away(sum: &mut [f32; LANES], n_fillers: usize, xs: &[f32; LANES], y: f32) {
    let far = 2.0 * FARTHEST_M as f32;
    for (sum, x) in sum.iter_mut().zip(xs) {
        *sum -= n_fillers as f32 / ((x - far) * (x - far) + (y - far) * (y - far));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::potential::ChargeForce;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const LAW: ChargeLaw =
        ChargeLaw { strength: 8.0, exponent: 2.0, force: ChargeForce::Consistent, range_m: f64::INFINITY };

    #[test]
    fn the_fast_map_is_that_of_its_slow_twin() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        for n_charges in [0, 1, 2, 3, 4, 7, 64, 255] {
            let size = GridSize::new(rng.random_range(1..200), rng.random_range(1..50));
            let frame = MapFrame { size, origin: Point2::new(-3.0, 120.0), cell_m: 0.08 };
            let charges: Vec<Point2<f64>> = (0..n_charges)
                .map(|_| Point2::new(rng.random_range(-6.0..16.0), rng.random_range(118.0..126.0)))
                .collect();
            let (mut fast, mut slow) = (vec![0.25; size.n_cells()], vec![0.25; size.n_cells()]);
            let mut scalar = fast.clone();
            add_potential(&frame, &LAW, &charges, &mut fast);
            add_slowly(&frame, &LAW, &charges, &mut slow);
            simd::narrowest(SumUp { frame: &frame, strength: 8.0, charges: &charges, sums: &mut scalar });
            for ((fast, slow), scalar) in fast.iter().zip(&slow).zip(&scalar) {
                // Single precision of places: near a charge the distance itself is rounded.
                let allowed = 1e-5 * slow.max(1.0) * slow.sqrt().max(1.0);
                assert!((fast - slow).abs() <= allowed, "{fast} {slow}");
                assert!((scalar - slow).abs() <= allowed, "{scalar} {slow}");
            }
        }
    }

    #[test]
    fn a_cell_on_a_charge_is_finite_and_far_charges_do_not_overflow() {
        let frame = MapFrame { size: GridSize::new(3, 3), origin: Point2::origin(), cell_m: 1.0 };
        let mut sums = vec![0.0; 9];
        add_potential(&frame, &LAW, &[Point2::new(1.5, 1.5)], &mut sums);
        assert!((sums[4] / 4e6 - 1.0).abs() < 1e-5 && (sums[0] - 2.0).abs() < 1e-5, "{sums:?}");
        for far_m in [9_000.0, 1e6, 1e150] {
            let mut sums = vec![0.0; 9];
            add_potential(&frame, &LAW, &[Point2::new(far_m, 0.0); 9], &mut sums);
            assert!(sums.iter().all(|sum| sum.is_finite()), "{sums:?}");
        }
    }

    #[test]
    fn other_laws_are_summed_up_too() {
        let frame = MapFrame { size: GridSize::new(9, 1), origin: Point2::origin(), cell_m: 1.0 };
        let law = ChargeLaw { exponent: 3.0, range_m: 4.0, ..LAW };
        let mut sums = vec![0.0; 9];
        add_potential(&frame, &law, &[Point2::new(0.5, 0.5)], &mut sums);
        assert!((sums[2] - 0.5).abs() < 1e-6 && sums[4] > 0.0 && sums[5] == 0.0, "{sums:?}");
    }
}
