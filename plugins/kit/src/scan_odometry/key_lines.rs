//! The line that stands for the surface at each point of a key scan.

use super::equations::Line;
use super::settings::{LineKind, ScanOdometrySettings};

/// Sums of x, y, x², xy, y² over the points before each, from which any run of neighbors is fitted at once.
pub(super) type Sums = [f64; 5];

/// A fitted line with its root mean square.
struct Fit {
    line: Line,
    mean_square_m2: f64,
}

/// Fills `lines` with that of each point, in order of bearing; none where no neighbor is near.
pub(super) fn find_lines(
    x: &[f64],
    y: &[f64],
    settings: &ScanOdometrySettings,
    sums: &mut Vec<Sums>,
    lines: &mut Vec<Option<Line>>,
) {
    lines.clear();
    sums.clear();
    let mut sum = [0.0; 5];
    sums.push(sum);
    for (x, y) in x.iter().zip(y) {
        let more = [*x, *y, x * x, x * y, y * y];
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        sums.push(sum);
    }
    for idx in 0..x.len() {
        lines.push(match settings.lines {
            LineKind::Neighbor => through_neighbor(x, y, idx, settings),
            LineKind::Fitted => {
                fitted(x, y, idx, sums, settings).or_else(|| through_neighbor(x, y, idx, settings))
            }
        });
    }
}

fn distance_m(x: &[f64], y: &[f64], one: usize, other: usize) -> Option<f64> {
    Some((x.get(other)? - x.get(one)?).hypot(y.get(other)? - y.get(one)?))
}

/// The line through a point and the nearer of its neighbors; where that is the published method, it is taken as exact.
fn through_neighbor(x: &[f64], y: &[f64], idx: usize, settings: &ScanOdometrySettings) -> Option<Line> {
    let neighbors = [idx.checked_sub(1), Some(idx + 1)];
    let near =
        neighbors.into_iter().flatten().filter_map(|other| Some((other, distance_m(x, y, idx, other)?)));
    let near = near.filter(|(_, gap_m)| *gap_m > 1e-6 && *gap_m < settings.max_line_gap_m);
    let (other, gap_m) = near.min_by(|one, other| one.1.total_cmp(&other.1))?;
    let ([x0, y0], [x1, y1]) = ([*x.get(idx)?, *y.get(idx)?], [*x.get(other)?, *y.get(other)?]);
    let normal = [(y0 - y1) / gap_m, (x1 - x0) / gap_m];
    let noise_m = if settings.lines == LineKind::Fitted { settings.range_noise_m } else { 0.0 };
    let normal_rad2 = 2.0 * noise_m * noise_m / (gap_m * gap_m);
    Some(Line { normal, distance_m: normal[0] * x0 + normal[1] * y0, normal_rad2 })
}

/// The line of the neighbors within reach: of those on both sides where they are straight, else of the straighter side.
fn fitted(x: &[f64], y: &[f64], idx: usize, sums: &[Sums], settings: &ScanOdometrySettings) -> Option<Line> {
    let reach = |step: isize| {
        let mut end = idx;
        while let Some(next) = end.checked_add_signed(step)
            && distance_m(x, y, end, next).is_some_and(|gap_m| gap_m < settings.max_line_gap_m)
            && distance_m(x, y, idx, next).is_some_and(|far_m| far_m <= settings.line_reach_m)
        {
            end = next;
        }
        end
    };
    let (first, last) = (reach(-1), reach(1));
    let around = fit(sums, first, last + 1, settings)?;
    let straight_m2 = (2.0 * settings.range_noise_m).powi(2);
    if around.mean_square_m2 <= straight_m2 {
        return Some(around.line);
    }
    let sides = [fit(sums, first, idx + 1, settings), fit(sums, idx, last + 1, settings)];
    let all = sides.into_iter().flatten().chain([around]);
    all.min_by(|one, other| one.mean_square_m2.total_cmp(&other.mean_square_m2)).map(|fit| fit.line)
}

/// The line through the points of a run by orthogonal least squares; none for fewer than three, or without a direction.
fn fit(sums: &[Sums], first: usize, end: usize, settings: &ScanOdometrySettings) -> Option<Fit> {
    if end < first + 3 {
        return None;
    }
    let (before, after) = (sums.get(first)?, sums.get(end)?);
    let n = (end - first) as f64;
    let mut mean = [0.0; 5];
    for (mean, (before, after)) in mean.iter_mut().zip(before.iter().zip(after)) {
        *mean = (after - before) / n;
    }
    let [mean_x, mean_y, xx, xy, yy] = mean;
    let (xx, xy, yy) = (xx - mean_x * mean_x, xy - mean_x * mean_y, yy - mean_y * mean_y);
    let (a, b) = (-2.0 * xy, yy - xx);
    let spread = a.hypot(b);
    let (along_m2, across_m2) = (0.5 * (xx + yy + spread), (0.5 * (xx + yy - spread)).max(0.0));
    if !(spread > 1e-9 && spread.is_finite()) {
        return None;
    }
    let (sine, cosine) = (0.5 * a.atan2(b)).sin_cos();
    let noise_m2 = (across_m2 * n / (n - 2.0)).max(settings.range_noise_m.powi(2));
    let line = Line {
        normal: [cosine, sine],
        distance_m: cosine * mean_x + sine * mean_y,
        normal_rad2: noise_m2 / (n * along_m2),
    };
    Some(Fit { line, mean_square_m2: across_m2 * n / (n - 2.0) })
}
