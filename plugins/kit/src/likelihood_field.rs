//! Likelihood field of a range finder: how probable is a reading that ends in this cell?
//!
//! Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), table 6.3: the probability depends on the distance from the
//! reading's end point to the nearest occupied cell only. Differs from the book: a sum of logarithms, not a product, so
//! that many beams stay finite; distances are truncated, so that one reading can only say so much.
//!
//! A million particle-beams a step must not take a logarithm each. So every cell keeps one byte, the logarithm's
//! distance from its maximum in steps of 1/255 of the whole span, and beams add up as integers. [`exact_ln`] is the slow
//! twin in double precision; the two differ by at most half a step a beam, and where rounding to `f32` moves an end
//! point across the edge of a cell.
//!
//! [`exact_ln`]: LikelihoodField::exact_ln

use crate::GridSize;
use crate::distance_field::{NO_MARK, squared_distance_field};
use crate::grid_poses::GridPoses;
use crate::simd::{self, Kernel, Vectors};

/// How probable a reading is by its end point's distance to the nearest obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldShape {
    /// Longer distances count as this one, meters.
    pub max_distance_m: f64,
    /// Standard deviation of readings that hit something on the map, meters.
    pub sigma_hit_m: f64,
    /// Share of these.
    pub z_hit: f64,
    /// Share of readings that can be anything.
    pub z_rand: f64,
    /// Reach of the device, meters.
    pub z_max_range_m: f64,
}

impl FieldShape {
    /// z_hit exp(-d²/2σ²) + z_rand/z_max_range for a distance in meters.
    pub fn likelihood(&self, distance_m: f64) -> f64 {
        let off = distance_m.min(self.max_distance_m) / self.sigma_hit_m;
        self.z_hit * (-0.5 * off * off).exp() + self.z_rand / self.z_max_range_m
    }
}

/// End points of a scan's beams as seen from the base, in cells, padded to whole vectors.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EndPoints {
    x: Vec<f32>,
    y: Vec<f32>,
    n_beams: usize,
}

/// Beams side by side.
const LANES: usize = 16;
/// A point that is off every map from wherever it is seen.
const FAR_AWAY: f32 = 1e9;

impl EndPoints {
    /// How many beams there are.
    pub fn n_beams(&self) -> usize {
        self.n_beams
    }

    /// Replaces all points, given in cells.
    pub fn set(&mut self, points: impl Iterator<Item = [f64; 2]>) {
        self.x.clear();
        self.y.clear();
        for [x, y] in points {
            self.x.push(x as f32);
            self.y.push(y as f32);
        }
        self.n_beams = self.x.len();
        let n_padded = self.n_beams.next_multiple_of(LANES);
        self.x.resize(n_padded, FAR_AWAY);
        self.y.resize(n_padded, 0.0);
    }

    fn n_padding(&self) -> usize {
        self.x.len() - self.n_beams
    }
}

/// The field of one map.
#[derive(Debug, Clone)]
pub struct LikelihoodField {
    size: GridSize,
    resolution_m: f64,
    shape: FieldShape,
    squared: Vec<u32>,
    /// One byte a cell with a border of one cell, which stands for everything off the map.
    costs: Vec<u8>,
    ln_best: f64,
    ln_step: f64,
}

impl LikelihoodField {
    /// Cost of a cell that is as far from everything as counts.
    const FARTHEST: u8 = u8::MAX;

    /// The field of a map whose nonzero bytes are obstacles.
    pub fn new(size: GridSize, resolution_m: f64, occupied: &[u8], shape: FieldShape) -> LikelihoodField {
        let squared = squared_distance_field(size, occupied);
        let (ln_best, ln_worst) = (shape.likelihood(0.0).ln(), shape.likelihood(shape.max_distance_m).ln());
        let ln_step = ((ln_best - ln_worst) / f64::from(Self::FARTHEST)).max(f64::MIN_POSITIVE);
        let mut field = LikelihoodField {
            size,
            resolution_m,
            shape,
            squared,
            costs: vec![Self::FARTHEST; (size.width + 2) * (size.height + 2)],
            ln_best,
            ln_step,
        };
        field.fill_costs();
        field
    }

    fn fill_costs(&mut self) {
        let reach = (self.shape.max_distance_m / self.resolution_m).powi(2);
        // Few distances are different: each logarithm is taken once.
        let by_square: Vec<u8> = (0..=reach.min(1e7) as u32)
            .map(|squared| {
                let ln = self.shape.likelihood(f64::from(squared).sqrt() * self.resolution_m).ln();
                ((self.ln_best - ln) / self.ln_step).round() as u8
            })
            .collect();
        let width = self.size.width;
        let rows = self.costs.chunks_exact_mut(width + 2).skip(1);
        for (row, squares) in rows.zip(self.squared.chunks_exact(width.max(1))) {
            for (cost, squared) in row[1..].iter_mut().zip(squares) {
                *cost = by_square.get(*squared as usize).copied().unwrap_or(Self::FARTHEST);
            }
        }
    }

    /// Distance from the cell that a point (in cells) lies in to the nearest occupied cell, truncated, meters.
    pub fn distance_m(&self, x: f64, y: f64) -> f64 {
        let (width, height) = (self.size.width as f64, self.size.height as f64);
        let is_inside = x >= 0.0 && y >= 0.0 && x < width && y < height;
        let squared = match is_inside {
            true => self.squared[self.size.index(x as usize, y as usize)],
            false => NO_MARK,
        };
        (f64::from(squared).sqrt() * self.resolution_m).min(self.shape.max_distance_m)
    }

    /// ln p of a reading that ends at this point (in cells): the slow twin.
    pub fn exact_ln(&self, x: f64, y: f64) -> f64 {
        self.shape.likelihood(self.distance_m(x, y)).ln()
    }

    /// Adds, for each pose, the sum of ln p over the beams.
    pub fn add_ln(&self, poses: &GridPoses, ends: &EndPoints, ln_p: &mut [f64]) {
        simd::widest(AddLn { field: self, poses, ends, ln_p });
    }
}

struct AddLn<'a> {
    field: &'a LikelihoodField,
    poses: &'a GridPoses,
    ends: &'a EndPoints,
    ln_p: &'a mut [f64],
}

/// Adding this to a number that is not negative leaves it, rounded, in the low bits.
const WHOLE: f32 = (1_u32 << 23) as f32;

impl Kernel for AddLn<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Self { field, poses, ends, ln_p } = self;
        let stride = field.size.width as u32 + 2;
        let last = [(field.size.width + 1) as f32, (field.size.height + 1) as f32];
        // What the two additions of WHOLE leave in a cell's index.
        let excess = WHOLE.to_bits().wrapping_mul(stride).wrapping_add(WHOLE.to_bits());
        let (xs, _) = ends.x.as_chunks::<LANES>();
        let (ys, _) = ends.y.as_chunks::<LANES>();
        let padding = ends.n_padding() as u32 * u32::from(LikelihoodField::FARTHEST);
        let ln_all_hit = field.ln_best * ends.n_beams as f64;
        for ([x, y, cos, sin], ln_p) in poses.iter().zip(ln_p) {
            // One cell of border, and half a cell because conversion rounds.
            let (x, y) = (x + 0.5, y + 0.5);
            let mut total = 0;
            for (xs, ys) in xs.iter().zip(ys) {
                let mut cells = [0; LANES];
                for lane in 0..LANES {
                    let at_x = clamped(x + (cos * xs[lane] - sin * ys[lane]), last[0]);
                    let at_y = clamped(y + (sin * xs[lane] + cos * ys[lane]), last[1]);
                    let (col, row) = ((at_x + WHOLE).to_bits(), (at_y + WHOLE).to_bits());
                    cells[lane] = row.wrapping_mul(stride).wrapping_add(col).wrapping_sub(excess);
                }
                total += V::sum_of(&field.costs, &cells);
            }
            *ln_p += ln_all_hit - f64::from(total - padding) * field.ln_step;
        }
    }
}

/// Between 0 and `last`; what is not a number becomes 0. Written so that each line is one instruction.
#[inline(always)]
fn clamped(value: f32, last: f32) -> f32 {
    let value = if value > 0.0 { value } else { 0.0 };
    if value < last { value } else { last }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generated_world::GeneratedWorld;

    const SHAPE: FieldShape =
        FieldShape { max_distance_m: 2.0, sigma_hit_m: 0.2, z_hit: 0.95, z_rand: 0.05, z_max_range_m: 30.0 };

    /// Scattered over the map and beyond its edges.
    fn poses(n: usize) -> Vec<[f64; 3]> {
        let scattered = |k: usize, by: f64| (k as f64 * by).fract();
        (0..n)
            .map(|k| [scattered(k, 0.618) * 440.0 - 20.0, scattered(k, 0.7549) * 440.0 - 20.0, k as f64])
            .collect()
    }

    /// The formula, pose by pose and beam by beam, from the same rounded columns.
    fn exact(field: &LikelihoodField, poses: &GridPoses, beams: &[[f64; 2]]) -> Vec<f64> {
        let one = |[x, y, cos, sin]: [f64; 4]| {
            let ln = |[a, b]: &[f64; 2]| field.exact_ln(x + cos * a - sin * b, y + sin * a + cos * b);
            beams.iter().map(ln).sum()
        };
        poses.iter().map(|pose| one(pose.map(f64::from))).collect()
    }

    #[test]
    fn bytes_agree_with_the_formula_for_any_number_of_beams() {
        let world = GeneratedWorld::indoor(400, 3);
        let field = LikelihoodField::new(world.size, 0.05, &world.occupied, SHAPE);
        let mut columns = GridPoses::default();
        poses(500).iter().for_each(|[x, y, heading]| columns.push(*x, *y, *heading));
        for n_beams in [0, 1, 15, 16, 17, 181] {
            let beams: Vec<[f64; 2]> = (0..n_beams)
                .map(|b| {
                    let (angle, range) = (f64::from(b) * 0.0347, 5.0 + f64::from(b * 37 % 90));
                    [range * angle.cos(), range * angle.sin()]
                })
                .collect();
            let mut ends = EndPoints::default();
            ends.set(beams.iter().copied());
            let (mut wide, mut narrow) = (vec![0.0; columns.len()], vec![0.0; columns.len()]);
            field.add_ln(&columns, &ends, &mut wide);
            simd::narrowest(AddLn { field: &field, poses: &columns, ends: &ends, ln_p: &mut narrow });
            assert_eq!(wide, narrow, "any processor gives the same bits");
            let half_step = field.ln_step / 2.0;
            // Once in some thousand times an end point lies so near to an edge that `f32` puts it beyond.
            let across_an_edge = 0.5;
            for (found, exact) in wide.iter().zip(exact(&field, &columns, &beams)) {
                let off = (found - exact).abs();
                assert!(off <= f64::from(n_beams) * half_step + across_an_edge, "{found} for {exact}");
            }
            let mean_off: f64 =
                wide.iter().zip(exact(&field, &columns, &beams)).map(|(a, b)| a - b).sum::<f64>() / 500.0;
            assert!(mean_off.abs() <= f64::from(n_beams) * half_step / 10.0, "{n_beams}: {mean_off}");
        }
    }

    #[test]
    fn a_map_without_obstacles_and_places_off_the_map_are_as_far_as_counts() {
        let field = LikelihoodField::new(GridSize::new(5, 4), 0.1, &[0; 20], SHAPE);
        let far = SHAPE.likelihood(2.0).ln();
        for (x, y) in [(2.5, 2.5), (-1.0, 2.0), (2.0, 4.0), (f64::NAN, 0.0), (1e12, f64::INFINITY)] {
            assert_eq!(field.exact_ln(x, y), far);
        }
        let (mut poses, mut ends, mut ln_p) = (GridPoses::default(), EndPoints::default(), [0.0; 3]);
        [(2.0, 2.0), (-1e6, 40.0), (f64::NAN, 1.0)].iter().for_each(|(x, y)| poses.push(*x, *y, 0.3));
        ends.set([[1.0, 1.0], [-3.0, 0.5], [0.0, 0.0]].into_iter());
        field.add_ln(&poses, &ends, &mut ln_p);
        ln_p.iter().for_each(|ln| assert!((ln - 3.0 * far).abs() < 1e-9, "{ln}"));
    }
}
