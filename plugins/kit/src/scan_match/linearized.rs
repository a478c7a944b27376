//! The sum of squares around a pose: the inner loop of matching.

use super::level::MatchLevel;
use super::points::ScanPoints;
use crate::simd::{self, Kernel, Vectors};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;

/// Points that go through the loop together.
const LANES: usize = 16;

/// What a scan at a pose says: the sum of squares, and its first-order neighborhood in x (m), y (m) and yaw (rad).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Linearized {
    /// Sum of weighted `J^T J` (H).
    pub hessian: Matrix3<f64>,
    /// Sum of weighted `J^T (1 - M)` (b): where the sum of squares falls fastest, halved.
    pub descent: Vector3<f64>,
    /// Sum of weighted `(1 - M)²` (F).
    pub cost: f64,
    /// Sum of weighted `1 - M` (F1).
    pub shortfall: f64,
    /// Sum of the weights of the points on the map.
    pub weight: f64,
    /// Points on the map; the others have no value and are left out.
    pub n_used: usize,
    /// Of those, points with at least one corner that some scan has touched.
    pub n_known: usize,
}

impl Linearized {
    /// Mean of `(1 - M)²`: 0 where every point lies on something, 1 where none does or there is no point.
    pub fn mean_cost(&self) -> f64 {
        if self.weight > 0.0 { self.cost / self.weight } else { 1.0 }
    }

    /// Mean of `(1 - M)²` over the points whose place the map knows; 1 where it knows none. Where it knows nothing the
    /// value is a half: a quarter each, whatever the scan looks like.
    pub fn known_cost(&self) -> f64 {
        let share = self.n_known as f64 / self.n_used.max(1) as f64;
        let known_weight = self.weight * share;
        if known_weight > 0.0 {
            ((self.cost - 0.25 * (self.weight - known_weight)) / known_weight).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }

    /// Mean value under the points: the likelihood that a sampled covariance is made of.
    pub fn mean_value(&self) -> f64 {
        if self.weight > 0.0 { 1.0 - self.shortfall / self.weight } else { 0.0 }
    }
}

/// Evaluates a scan at a pose (equations 8 to 14). What the map seems to say along a direction that the scan by its own shape
/// cannot tell is left out.
pub fn linearize<L: MatchLevel>(level: &L, points: &ScanPoints, map_from_base: &Pose2) -> Linearized {
    let level_from_map = level.level_from_map();
    let size = level.size();
    if size.width < 2 || size.height < 2 {
        return Linearized::default();
    }
    let placed = Placed::new(&(level_from_map * map_from_base), level.resolution_m());
    let sums = simd::widest(Fold { level, points, placed });
    let mut told = sums.in_map_frame(level.resolution_m(), &level_from_map);
    if let Some(blind) = points.blind() {
        let seen = blind.turned(&map_from_base.rotation);
        (told.hessian, told.descent) = seen.only_seen(&told.hessian, &told.descent);
    }
    told
}

/// The base on a level, in cells. The whole cells are kept apart, so that single precision resolves a ten-thousandth of
/// a cell wherever the base is.
#[derive(Debug, Clone, Copy)]
struct Placed {
    cos: f32,
    sin: f32,
    x: f32,
    y: f32,
    whole: [f64; 2],
}

impl Placed {
    fn new(level_from_base: &Pose2, resolution_m: f64) -> Placed {
        // Values belong to the middles of cells.
        let [u, v] =
            [level_from_base.translation.x, level_from_base.translation.y].map(|m| m / resolution_m - 0.5);
        let whole = [u.floor(), v.floor()];
        Placed {
            cos: (level_from_base.rotation.re / resolution_m) as f32,
            sin: (level_from_base.rotation.im / resolution_m) as f32,
            x: (u - whole[0]) as f32,
            y: (v - whole[1]) as f32,
            whole,
        }
    }
}

/// Sums by lane, with derivatives in cells: b, H (upper triangle), then cost, shortfall, weight, points used and known.
const N_SUMS: usize = 14;

#[derive(Debug, Clone, Copy)]
struct Sums([f64; N_SUMS]);

impl Sums {
    /// Cells to meters, the level's axes to the map's.
    fn in_map_frame(self, resolution_m: f64, level_from_map: &Pose2) -> Linearized {
        let [bx, by, bt, xx, xy, xt, yy, yt, tt, cost, shortfall, weight, n_used, n_known] = self.0;
        let per_m = 1.0 / resolution_m;
        let descent = Vector3::new(bx * per_m, by * per_m, bt);
        let (xx, xy, yy) = (xx * per_m * per_m, xy * per_m * per_m, yy * per_m * per_m);
        let (xt, yt) = (xt * per_m, yt * per_m);
        let hessian = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
        let mut turn = Matrix3::identity();
        let axes = level_from_map.rotation.to_rotation_matrix();
        turn.fixed_view_mut::<2, 2>(0, 0).copy_from(axes.matrix());
        Linearized {
            hessian: turn.transpose() * hessian * turn,
            descent: turn.transpose() * descent,
            cost,
            shortfall,
            weight,
            n_used: n_used as usize,
            n_known: n_known as usize,
        }
    }
}

struct Fold<'a, L> {
    level: &'a L,
    points: &'a ScanPoints,
    placed: Placed,
}

impl<L: MatchLevel> Kernel for Fold<'_, L> {
    type Output = Sums;

    #[inline(always)]
    fn run<V: Vectors>(self) -> Sums {
        let bounds = Bounds::new(self.level, &self.placed);
        let mut lanes = [[0.0f32; LANES]; N_SUMS];
        let (xs, xs_left) = self.points.x().as_chunks::<LANES>();
        let (ys, ys_left) = self.points.y().as_chunks::<LANES>();
        let (weights, weights_left) = self.points.weights().as_chunks::<LANES>();
        for ((x, y), weight) in xs.iter().zip(ys).zip(weights) {
            fold(self.level, &self.placed, &bounds, x, y, weight, &mut lanes);
        }
        if !xs_left.is_empty() {
            // Points without weight add nothing.
            let filled = |left: &[f32]| std::array::from_fn(|k| left.get(k).copied().unwrap_or(0.0));
            let last = [xs_left, ys_left, weights_left].map(filled);
            fold(self.level, &self.placed, &bounds, &last[0], &last[1], &last[2], &mut lanes);
        }
        Sums(simd::sums_of(&lanes))
    }
}

/// Where interpolation is defined, relative to the base's whole cells.
struct Bounds {
    low: [f32; 2],
    high: [f32; 2],
}

impl Bounds {
    #[inline(always)]
    fn new<L: MatchLevel>(level: &L, placed: &Placed) -> Bounds {
        let size = level.size();
        let [x, y] = placed.whole;
        Bounds {
            low: [-x as f32, -y as f32],
            high: [(size.width as f64 - 1.0 - x) as f32, (size.height as f64 - 1.0 - y) as f32],
        }
    }
}

/// Adds sixteen points to the sums, in three passes: where they lie, what is stored there, what it says. The first and the
/// last become vector code.
#[inline(always)]
fn fold<L: MatchLevel>(
    level: &L,
    placed: &Placed,
    bounds: &Bounds,
    x: &[f32; LANES],
    y: &[f32; LANES],
    weight: &[f32; LANES],
    sums: &mut [[f32; LANES]; N_SUMS],
) {
    let mut turned = [[simd::UNWRITTEN; LANES]; 2];
    let mut part = [[simd::UNWRITTEN; LANES]; 2];
    let mut cell = [[u32::MAX; LANES]; 2];
    let mut used = [simd::UNWRITTEN; LANES];
    for k in 0..LANES {
        let along = [placed.cos * x[k] - placed.sin * y[k], placed.sin * x[k] + placed.cos * y[k]];
        let at = [along[0] + placed.x, along[1] + placed.y];
        let is_inside = (at[0] >= bounds.low[0])
            & (at[0] <= bounds.high[0])
            & (at[1] >= bounds.low[1])
            & (at[1] <= bounds.high[1])
            & (weight[k] > 0.0);
        used[k] = if is_inside { 1.0 } else { 0.0 };
        for axis in 0..2 {
            // The last middle belongs to the last pair of cells.
            let lower = at[axis].floor().min(bounds.high[axis] - 1.0);
            // Not a number times no weight would still be not a number.
            turned[axis][k] = if is_inside { along[axis] } else { 0.0 };
            part[axis][k] = if is_inside { at[axis] - lower } else { 0.0 };
            cell[axis][k] = simd::whole(if is_inside { lower - bounds.low[axis] } else { 0.0 });
        }
    }
    let mut stored = [[0.0f32; LANES]; 4];
    for k in 0..LANES {
        // A point off the map has no weight: whatever lies in its place.
        let corners = level.corners(cell[0][k] as usize, cell[1][k] as usize);
        for (column, corner) in stored.iter_mut().zip(corners) {
            column[k] = corner;
        }
    }
    for k in 0..LANES {
        let is_known = stored.iter().any(|corner| L::is_touched(corner[k]));
        let [p00, p10] = [L::value(stored[0][k]), L::value(stored[1][k])];
        let [p01, p11] = [L::value(stored[2][k]), L::value(stored[3][k])];
        let (fx, fy) = (part[0][k], part[1][k]);
        let (lower, upper) = (p00 + fx * (p10 - p00), p01 + fx * (p11 - p01));
        let missing = 1.0 - (lower + fy * (upper - lower));
        let dx = (p10 - p00) + fy * ((p11 - p01) - (p10 - p00));
        let dy = upper - lower;
        let dt = dy * turned[0][k] - dx * turned[1][k];
        let w = weight[k] * used[k];
        let [wx, wy, wt, wm] = [w * dx, w * dy, w * dt, w * missing];
        let terms = [
            wx * missing,
            wy * missing,
            wt * missing,
            wx * dx,
            wx * dy,
            wx * dt,
            wy * dy,
            wy * dt,
            wt * dt,
            wm * missing,
            wm,
            w,
            used[k],
            if is_known { used[k] } else { 0.0 },
        ];
        for (sum, term) in sums.iter_mut().zip(terms) {
            sum[k] += term;
        }
    }
}
