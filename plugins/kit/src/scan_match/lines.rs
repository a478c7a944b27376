//! The straight line through the neighbors of each point of a scan, where there is one.

use nalgebra::{Matrix2, Vector2};

/// Neighbors on each side that are this near are looked at, meters, ...
const REACH_M: f64 = 0.25;
/// ... and so many however far they are: where beams graze a wall.
const LEAST_EACH_SIDE: usize = 3;
/// Lines lie this often farther from their points than those of most of the scan do, in deviations, before they are bent.
const STRAIGHT_DEVIATIONS: f64 = 2.0;
/// Deviations of points from their line that are believed of a laser or a camera, meters.
const NOISE_M: [f64; 2] = [0.005, 0.05];

/// The line through a point's neighbors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// The projection on its normal.
    pub across: Matrix2<f64>,
    mean_square_m2: f64,
    /// Of the middle of those neighbors from the base, meters.
    range_m: f64,
    /// Variance of the normal's direction.
    pub normal_rad2: f64,
}

/// Of points in order of bearing; nothing where fewer than two have a line.
pub(super) fn lines_of(points: &[[f32; 2]]) -> Option<Vec<Option<Line>>> {
    let sums = running_sums(points);
    let windows = windows(points);
    let around: Vec<Option<Line>> = windows.iter().map(|[first, end]| fit(&sums, *first, *end)).collect();
    let noise = Noise::of(&around)?;
    let is_straight =
        |line: &Line| line.mean_square_m2.sqrt() <= STRAIGHT_DEVIATIONS * noise.at_m(line.range_m);
    let line = |(idx, ([first, end], around)): (usize, (&[usize; 2], Option<Line>))| {
        // Around a corner neither line is bent.
        let side = || {
            let sides = [fit(&sums, *first, idx + 1), fit(&sums, idx, *end)].into_iter().flatten();
            sides.min_by(|one, other| one.mean_square_m2.total_cmp(&other.mean_square_m2)).filter(is_straight)
        };
        around.filter(is_straight).or_else(side)
    };
    Some(windows.iter().zip(around).enumerate().map(line).collect())
}

/// How far points lie from straight lines: of a laser the same at all ranges, of a camera more at long ones.
#[derive(Debug, Clone, Copy)]
struct Noise {
    near_m: f64,
    near_range_m: f64,
    per_m: f64,
}

impl Noise {
    /// By the medians of the nearer and the farther half; none where fewer than two points have a line.
    fn of(fits: &[Option<Line>]) -> Option<Noise> {
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
fn fit(sums: &[[f64; 5]], first: usize, end: usize) -> Option<Line> {
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
    Some(Line { across, mean_square_m2, range_m: x.hypot(y), normal_rad2: mean_square_m2 / (n * along_m2) })
}
