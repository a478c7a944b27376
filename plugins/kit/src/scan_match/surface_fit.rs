//! How far a scan lies from the surfaces of the map, and where to move it.

use super::points::ScanPoints;
use super::surface_map::SurfaceMap;
use crate::simd::{self, Kernel, Vectors};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;

/// Points that go through the loop together.
const LANES: usize = 16;
/// Points farther from the base add nothing, cells.
const FARTHEST_CELLS: f32 = 1e6;
/// Sums: b, H (upper triangle), then cost, weight, points used.
const N_SUMS: usize = 12;
/// What is seen around a cell counts less, the more directions its lines have, and nothing from this `4 det / trace²` on: a
/// point in a corner is not drawn to both walls.
const CORNER: f32 = 0.3;

/// What a scan at a pose says: the weighted sum of mean squared distances from the map's lines, and its first-order
/// neighborhood in x (m), y (m) and yaw (rad).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceFit {
    /// Sum of weighted `J^T J`.
    pub hessian: Matrix3<f64>,
    /// Where the sum falls fastest, halved, meters.
    pub descent: Vector3<f64>,
    /// Sum of weighted squared distances, m².
    pub cost_m2: f64,
    /// Sum of the weights.
    pub weight: f64,
    /// Points that lie by a surface.
    pub n_used: usize,
}

/// Evaluates a scan at a pose; a point at `doubt_m` from the lines counts half as much as one on them.
pub fn fit_surfaces(
    surfaces: &SurfaceMap,
    points: &ScanPoints,
    map_from_base: &Pose2,
    doubt_m: f64,
) -> SurfaceFit {
    let cell_m = surfaces.resolution_m();
    let level_from_map = surfaces.level_from_map();
    let level_from_base = level_from_map * map_from_base;
    let [u, v] = [level_from_base.translation.x, level_from_base.translation.y].map(|m| m / cell_m);
    // The whole cells are kept apart, so that single precision resolves a ten-thousandth of a cell.
    let whole = [u.floor(), v.floor()];
    if !(whole[0].abs() < 1e8 && whole[1].abs() < 1e8) {
        return SurfaceFit::default();
    }
    let sums = simd::widest(Fold {
        surfaces,
        points,
        turn: [level_from_base.rotation.re / cell_m, level_from_base.rotation.im / cell_m].map(|v| v as f32),
        part: [(u - whole[0]) as f32, (v - whole[1]) as f32],
        whole: whole.map(|v| v as i32),
        per_doubt: (cell_m * cell_m / (doubt_m * doubt_m)) as f32,
    });
    in_map_frame(sums, cell_m, &level_from_map)
}

/// Cells to meters, the level's axes to the map's.
fn in_map_frame(sums: [f64; N_SUMS], cell_m: f64, level_from_map: &Pose2) -> SurfaceFit {
    let [bx, by, bt, xx, xy, xt, yy, yt, tt, cost, weight, n_used] = sums;
    let hessian = Matrix3::new(
        xx,
        xy,
        xt * cell_m,
        xy,
        yy,
        yt * cell_m,
        xt * cell_m,
        yt * cell_m,
        tt * cell_m * cell_m,
    );
    let descent = Vector3::new(bx * cell_m, by * cell_m, bt * cell_m * cell_m);
    let mut turn = Matrix3::identity();
    turn.fixed_view_mut::<2, 2>(0, 0).copy_from(level_from_map.rotation.to_rotation_matrix().matrix());
    SurfaceFit {
        hessian: turn.transpose() * hessian * turn,
        descent: turn.transpose() * descent,
        cost_m2: cost * cell_m * cell_m,
        weight,
        n_used: n_used as usize,
    }
}

struct Fold<'a> {
    surfaces: &'a SurfaceMap,
    points: &'a ScanPoints,
    turn: [f32; 2],
    part: [f32; 2],
    whole: [i32; 2],
    per_doubt: f32,
}

impl Kernel for Fold<'_> {
    type Output = [f64; N_SUMS];

    #[inline(always)]
    fn run<V: Vectors>(self) -> [f64; N_SUMS] {
        let mut lanes = [[0.0f32; LANES]; N_SUMS];
        let (xs, xs_left) = self.points.x().as_chunks::<LANES>();
        let (ys, ys_left) = self.points.y().as_chunks::<LANES>();
        let (weights, weights_left) = self.points.weights().as_chunks::<LANES>();
        for ((x, y), weight) in xs.iter().zip(ys).zip(weights) {
            self.fold(x, y, weight, &mut lanes);
        }
        if !xs_left.is_empty() {
            // Points without weight add nothing.
            let filled = |left: &[f32]| std::array::from_fn(|k| left.get(k).copied().unwrap_or(0.0));
            let last = [xs_left, ys_left, weights_left].map(filled);
            self.fold(&last[0], &last[1], &last[2], &mut lanes);
        }
        simd::sums_of(&lanes)
    }
}

impl Fold<'_> {
    /// Adds sixteen points to the sums, in three passes: where they lie, what is known there, what it says. The first and the
    /// last become vector code.
    #[inline(always)]
    fn fold(
        &self,
        x: &[f32; LANES],
        y: &[f32; LANES],
        weight: &[f32; LANES],
        sums: &mut [[f32; LANES]; N_SUMS],
    ) {
        let mut along = [[simd::UNWRITTEN; LANES]; 2];
        let mut rest = [[simd::UNWRITTEN; LANES]; 2];
        let mut cell = [[i32::MIN; LANES]; 2];
        let mut used = [simd::UNWRITTEN; LANES];
        let [cos, sin] = self.turn;
        for k in 0..LANES {
            let turned = [cos * x[k] - sin * y[k], sin * x[k] + cos * y[k]];
            let at = [turned[0] + self.part[0], turned[1] + self.part[1]];
            // Also where a place that is too far for single precision is not a number.
            let is_near = (at[0].abs() < FARTHEST_CELLS) & (at[1].abs() < FARTHEST_CELLS);
            used[k] = if is_near { weight[k] } else { 0.0 };
            for axis in 0..2 {
                let at = if is_near { at[axis] } else { 0.0 };
                let lower = at.floor();
                along[axis][k] = if is_near { turned[axis] } else { 0.0 };
                rest[axis][k] = at - lower - 0.5;
                let offset = simd::whole(lower + FARTHEST_CELLS) as i32 - FARTHEST_CELLS as i32;
                cell[axis][k] = offset.wrapping_add(self.whole[axis]);
            }
        }
        let mut known = [[0.0f32; LANES]; 7];
        for k in 0..LANES {
            if used[k] > 0.0
                && let Some(quadric) = self.surfaces.quadric([cell[0][k], cell[1][k]])
            {
                for (column, value) in known.iter_mut().zip(quadric) {
                    column[k] = *value;
                }
            }
        }
        for k in 0..LANES {
            let [xx, xy, yy, bx, by, c, lines] = std::array::from_fn(|i| known[i][k]);
            let has_lines = lines > 0.0;
            let per_line = if has_lines { 1.0 / lines } else { 0.0 };
            let (rx, ry) = (rest[0][k], rest[1][k]);
            let [ax, ay] = [xx * rx + xy * ry, xy * rx + yy * ry];
            let cost = ((ax * rx + ay * ry) - 2.0 * (bx * rx + by * ry) + c) * per_line;
            let cost = if cost > 0.0 { cost } else { 0.0 };
            let spread = 4.0 * (xx * yy - xy * xy) * per_line * per_line;
            let straight = 1.0 - spread * (1.0 / CORNER);
            let straight = if straight > 0.0 { straight } else { 0.0 };
            let doubted = 1.0 + cost * self.per_doubt;
            let w = if has_lines { used[k] * straight / doubted } else { 0.0 };
            let wl = w * per_line;
            let [gx, gy] = [(bx - ax) * wl, (by - ay) * wl];
            let [hxx, hxy, hyy] = [xx * wl, xy * wl, yy * wl];
            // How the point moves with yaw.
            let (tx, ty) = (-along[1][k], along[0][k]);
            let (hxt, hyt) = (hxx * tx + hxy * ty, hxy * tx + hyy * ty);
            let terms = [
                gx,
                gy,
                gx * tx + gy * ty,
                hxx,
                hxy,
                hxt,
                hyy,
                hyt,
                hxt * tx + hyt * ty,
                w * cost,
                w,
                if w > 0.0 { 1.0 } else { 0.0 },
            ];
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum[k] += term;
            }
        }
    }
}
