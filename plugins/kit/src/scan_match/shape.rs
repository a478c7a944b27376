//! Which way a scan cannot tell by its own shape, whatever the map it is laid on: along the walls of a bare corridor, around the
//! middle of a round room.
//!
//! The cells of a map do not show that: beams that graze a wall hit it farther apart than cells are wide, so that the wall is
//! drawn as a row of dots, and the noise of near walls makes cells of different strength. Both look like evidence along the wall.
//! So the scan itself is asked: each point tells the way across the straight line through its neighbors, and nothing along it
//! (Censi, *On achievable accuracy for range-finder localization*, ICRA 2007, for surfaces); a point on no straight line tells
//! both. The directions come from the sum of what all points tell, by the rule for degenerate directions of Zhang, Kaess, Singh
//! (ICRA 2016), less what noise in the lines pretends.

use super::linearized::Linearized;
use super::observability::{Observability, ObservabilitySettings};
use super::points::ScanPoints;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2};

/// Neighbors on each side that are this near are looked at, meters, ...
const REACH_M: f64 = 0.25;
/// ... and so many however far they are: where beams graze a wall.
const LEAST_EACH_SIDE: usize = 3;
/// Lines lie this often farther from their points than those of most of the scan do, in deviations, before they are bent.
const STRAIGHT_DEVIATIONS: f64 = 2.5;
/// Deviations of points from their line that are believed of a laser or a camera, meters.
const NOISE_M: [f64; 2] = [0.005, 0.05];
/// Fewer points than this that tell a direction are none; noise bends a line now and then.
const LEAST_POINTS: f64 = 1.0;
/// So many make sure of a place that may be a wrong one.
const PROOF_POINTS: f64 = 10.0;
/// Evidence that is no more than so many times what noise pretends is none.
const PRETENDED_TIMES: f64 = 3.0;
/// The end of a wall counts as so many points that tell the way along it.
const END_POINTS: f64 = 5.0;

/// Walls whose normals are less than 13 degrees apart are the same: the square of the cosine.
const SAME_WALL: f64 = 0.95;
/// A direction that so large a share of the points tells is told whichever of them count.
const TOLD_SHARE: f64 = 0.3;

/// The line through a point's neighbors.
#[derive(Debug, Clone, Copy)]
struct Fit {
    /// The projection on its normal.
    across: Matrix2<f64>,
    mean_square_m2: f64,
    /// Of the middle of those neighbors.
    range_m: f64,
    /// Variance of the normal's direction.
    normal_rad2: f64,
}

/// What points tell of x, y and yaw, and what of that the noise in their lines pretends.
#[derive(Debug, Clone, Copy, Default)]
struct Told {
    evidence: Matrix3<f64>,
    pretended: Matrix3<f64>,
}

/// A point of a scan, in the base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapePoint {
    /// Place, meters.
    pub at: [f32; 2],
    /// The normal of the line through its neighbors, to either side.
    pub normal: Option<[f32; 2]>,
    /// The wall on which it lies ends here.
    pub is_end: bool,
}

/// What is needed of a scan to say what it tells by itself; which of its points count depends on what they are laid on. It is not
/// kept of scans that tell all directions many times over.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanShape {
    /// In order of bearing.
    points: Vec<ShapePoint>,
    extent_m: f64,
}

impl ScanShape {
    /// Of points in order of bearing. `ends_wall` says of a point and the normal's projection at it whether the surface could be
    /// seen farther on and is not there.
    pub(super) fn of(
        points: &ScanPoints,
        ends_wall: impl Fn(usize, &Matrix2<f64>) -> bool,
    ) -> Option<ScanShape> {
        let places: Vec<[f32; 2]> = points.iter().map(|[x, y, _]| [x, y]).collect();
        let extent_m = points.extent_m();
        let many_times = ObservabilitySettings { floor_per_m2: TOLD_SHARE, ratio: 0.0 };
        let unless_told = |told: &Told| {
            Observability::unless_complete(&linearized(told, places.len()), extent_m, &many_times)
        };
        // Ends of walls only add to it, and take most of the time.
        unless_told(&told(&places, |_, _| false)?)?;
        let mut shape = Vec::with_capacity(places.len());
        let told = told(&places, |idx, across| {
            let is_end = ends_wall(idx, across);
            let at = places.get(idx).copied().unwrap_or_default();
            shape.push(ShapePoint { at, normal: normal_of(across), is_end });
            is_end
        })?;
        unless_told(&told)?;
        Some(ScanShape { points: shape, extent_m })
    }

    /// In order of bearing.
    pub fn points(&self) -> &[ShapePoint] {
        &self.points
    }

    /// Directions, in the base frame, of which the scan tells something and nothing; none where it tells all of them.
    pub fn blind(&self) -> Option<Observability> {
        self.blind_where(|_| true)
    }

    /// The same of those points alone whose surface is known where the scan is laid: what is seen for the first time tells nothing
    /// of where the robot is. Nothing where none is.
    pub fn blind_where(&self, is_known: impl Fn(&ShapePoint) -> bool) -> Option<Observability> {
        let (told, n_points) = self.told_where(is_known)?;
        blind(&told, n_points, self.extent_m, LEAST_POINTS)
    }

    /// Those points alone tell all directions, and none of them by a few only.
    pub fn proves_where(&self, is_known: impl Fn(&ShapePoint) -> bool) -> bool {
        let told = self.told_where(is_known);
        told.is_some_and(|(told, n_points)| blind(&told, n_points, self.extent_m, PROOF_POINTS).is_none())
    }

    /// What those points tell, and how many they are.
    fn told_where(&self, is_known: impl Fn(&ShapePoint) -> bool) -> Option<(Told, usize)> {
        let known: Vec<&ShapePoint> = self.points.iter().filter(|point| is_known(point)).collect();
        let places: Vec<[f32; 2]> = known.iter().map(|point| point.at).collect();
        // Without what stands before a wall, the line at a point may be another one.
        let is_same = |normal: &[f32; 2], across: &Matrix2<f64>| {
            let normal = Vector2::from(*normal).cast::<f64>();
            normal.dot(&(across * normal)) > SAME_WALL
        };
        let ends_wall = |idx: usize, across: &Matrix2<f64>| {
            let normal = known.get(idx).filter(|point| point.is_end).and_then(|point| point.normal);
            normal.is_some_and(|normal| is_same(&normal, across))
        };
        Some((told(&places, ends_wall)?, places.len()))
    }
}

/// What is projected on; none where nothing is.
fn normal_of(across: &Matrix2<f64>) -> Option<[f32; 2]> {
    let [x, y] = [across[(0, 0)], across[(1, 1)]].map(|square| square.max(0.0).sqrt() as f32);
    (across.trace() > 0.5).then_some([x, y.copysign(across[(0, 1)] as f32)])
}

fn linearized(told: &Told, n_points: usize) -> Linearized {
    Linearized { hessian: told.evidence, weight: n_points as f64, ..Linearized::default() }
}

/// Takes apart what the points tell; nothing where they tell every direction.
fn blind(told: &Told, n_points: usize, extent_m: f64, least_points: f64) -> Option<Observability> {
    let evidence = linearized(told, n_points);
    let floor_per_m2 = least_points / evidence.weight;
    // Most scans tell everything, and that is seen at once.
    let sure = ObservabilitySettings { floor_per_m2: 2.0 * floor_per_m2, ratio: 0.01 };
    Observability::unless_complete(&evidence, extent_m, &sure)?;
    let rule = ObservabilitySettings { floor_per_m2, ..ObservabilitySettings::default() };
    let mut shape = Observability::of(&evidence, extent_m, &rule);
    let noise = shape.evidence_of(&told.pretended);
    for (k, seen) in shape.seen.iter_mut().enumerate() {
        *seen &= shape.evidence[k] > PRETENDED_TIMES * noise[k];
    }
    (!shape.is_complete() && !shape.is_empty()).then_some(shape)
}

/// Sums over all points; none where there is no line among them. `ends_wall` is asked of every point in turn.
fn told(points: &[[f32; 2]], mut ends_wall: impl FnMut(usize, &Matrix2<f64>) -> bool) -> Option<Told> {
    let sums = running_sums(points);
    let windows = windows(points);
    let around: Vec<Option<Fit>> = windows.iter().map(|[first, end]| fit(&sums, *first, *end)).collect();
    let noise = Noise::of(&around)?;
    let is_straight = |fit: &Fit| fit.mean_square_m2.sqrt() <= STRAIGHT_DEVIATIONS * noise.at_m(fit.range_m);
    let mut told = Told::default();
    let places = points.iter().zip(windows.iter().zip(around));
    for (idx, ([x, y], ([first, end], around))) in places.enumerate() {
        let arm = Matrix2x3::new(1.0, 0.0, -f64::from(*y), 0.0, 1.0, f64::from(*x));
        // Around a corner neither line is bent.
        let side = || {
            let sides = [fit(&sums, *first, idx + 1), fit(&sums, idx, *end)].into_iter().flatten();
            sides.min_by(|one, other| one.mean_square_m2.total_cmp(&other.mean_square_m2)).filter(is_straight)
        };
        let line = around.filter(is_straight).or_else(side);
        let is_end = ends_wall(idx, &line.map_or_else(Matrix2::zeros, |line| line.across));
        let Some(line) = line else {
            told.evidence += arm.transpose() * arm * 0.5;
            continue;
        };
        let along = Matrix2::identity() - line.across;
        let end = if is_end { END_POINTS } else { 0.0 };
        told.evidence += arm.transpose() * (line.across + along * end) * arm;
        told.pretended += arm.transpose() * along * arm * line.normal_rad2;
    }
    Some(told)
}

/// How far points lie from straight lines: of a laser the same at all ranges, of a camera more at long ones.
#[derive(Debug, Clone, Copy)]
struct Noise {
    near_m: f64,
    near_range_m: f64,
    per_m: f64,
}

impl Noise {
    /// By the medians of the nearer and the farther half; none where no points have a line.
    fn of(fits: &[Option<Fit>]) -> Option<Noise> {
        let mut fits: Vec<(f64, f64)> =
            fits.iter().flatten().map(|fit| (fit.range_m, fit.mean_square_m2.sqrt())).collect();
        let middle = fits.len() / 2;
        if fits.len() < 2 {
            return None;
        }
        fits.select_nth_unstable_by(middle, |one, other| one.0.total_cmp(&other.0));
        let (near, far) = fits.split_at_mut(middle);
        let ([near_range_m, near_m], [far_range_m, far_m]) = (medians(near), medians(far));
        let apart_m = far_range_m - near_range_m;
        let per_m = if apart_m > 0.0 { ((far_m - near_m) / apart_m).max(0.0) } else { 0.0 };
        Some(Noise { near_m, near_range_m, per_m })
    }

    fn at_m(&self, range_m: f64) -> f64 {
        let [least_m, most_m] = NOISE_M;
        (self.near_m + self.per_m * (range_m - self.near_range_m).max(0.0)).clamp(least_m, most_m)
    }
}

fn medians(pairs: &mut [(f64, f64)]) -> [f64; 2] {
    let middle = pairs.len() / 2;
    let mut median = |of: fn(&(f64, f64)) -> f64| {
        pairs.select_nth_unstable_by(middle, |one, other| of(one).total_cmp(&of(other)));
        pairs.get(middle).map_or(0.0, of)
    };
    [median(|pair| pair.0), median(|pair| pair.1)]
}

/// Sums of x, y, x², xy, y² over the points before each.
fn running_sums(points: &[[f32; 2]]) -> Vec<[f64; 5]> {
    let mut sum = [0.0; 5];
    let mut sums = Vec::with_capacity(points.len() + 1);
    sums.push(sum);
    for [x, y] in points {
        let [x, y] = [x, y].map(|v| f64::from(*v));
        sum.iter_mut().zip([x, y, x * x, x * y, y * y]).for_each(|(sum, more)| *sum += more);
        sums.push(sum);
    }
    sums
}

/// The points that are looked at around each: the first, and the one after the last.
fn windows(points: &[[f32; 2]]) -> Vec<[usize; 2]> {
    let at = |idx: usize| points.get(idx).map(|at| Vector2::from(*at));
    let is_near = |one: usize, other: usize| {
        let apart = at(one).zip(at(other)).map(|(one, other)| (one - other).norm_squared());
        apart.is_some_and(|m2| f64::from(m2) <= REACH_M * REACH_M)
    };
    let (mut first, mut last) = (0, 0);
    let window = |idx: usize| {
        while idx > first + LEAST_EACH_SIDE && !is_near(first, idx) {
            first += 1;
        }
        last = idx.max(last);
        while last + 1 < points.len() && (last < idx + LEAST_EACH_SIDE || is_near(last + 1, idx)) {
            last += 1;
        }
        [first, last + 1]
    };
    (0..points.len()).map(window).collect()
}

/// The line through a run of points by orthogonal least squares; none through fewer than four, or without a direction.
fn fit(sums: &[[f64; 5]], first: usize, end: usize) -> Option<Fit> {
    let n_points = end.checked_sub(first).filter(|n| *n > LEAST_EACH_SIDE)?;
    let (before, after) = (sums.get(first)?, sums.get(end)?);
    let n = n_points as f64;
    let [x, y, xx, xy, yy] = std::array::from_fn(|k| (after[k] - before[k]) / n);
    let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y);
    let spread = (xx - yy).hypot(2.0 * xy);
    let (along_m2, across_m2) = (0.5 * (xx + yy + spread), (0.5 * (xx + yy - spread)).max(0.0));
    if !(spread > 1e-9 && spread.is_finite()) {
        return None;
    }
    let across = (Matrix2::identity() * along_m2 - Matrix2::new(xx, xy, xy, yy)) / spread;
    let mean_square_m2 = across_m2 * n / (n - 2.0);
    Some(Fit { across, mean_square_m2, range_m: x.hypot(y), normal_rad2: mean_square_m2 / (n * along_m2) })
}
