//! Which way the surfaces face that a scan has seen: a line through each point and its neighbors in the scan.

use super::points::ScanPoints;

/// Neighbors within this distance count, meters, ...
const REACH_M: f32 = 0.25;
/// ... and so many to each side at least, where beams are far apart.
const LEAST_NEIGHBORS: usize = 2;
/// Beyond a gap like this something else was seen, meters.
const WIDEST_GAP_M: f64 = 0.5;
/// The points lie on a line when across it they spread by at most this share of what they spread along it (variances).
const MOST_SPREAD: f64 = 0.1;

/// A point of a surface: unit normal in the frame of the points, and how much of a cell it stands for; all zero where
/// the scan does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Facing {
    pub normal: [f32; 2],
    pub share: f32,
}

/// Sums of the points before each, so that those of any run of neighbors are a difference.
#[derive(Debug, Clone, Default)]
pub(super) struct SurfaceNormals {
    sums: Vec<[f64; 5]>,
    gaps_m: Vec<f64>,
    /// One for each point.
    pub facings: Vec<Facing>,
}

impl SurfaceNormals {
    /// Finds the normal of each point; a point counts in full where its neighbors are a cell away.
    pub fn find(&mut self, points: &ScanPoints, cell_m: f64) {
        self.sum_up(points);
        self.facings.clear();
        let mut run = [0, 0];
        for idx in 0..points.len() {
            run = self.run(points, idx, run);
            let share = (self.own_length_m(idx) / cell_m).min(1.0);
            let normal = self.normal(run);
            self.facings.push(normal.map_or_else(Facing::default, |normal| Facing {
                normal: normal.map(|v| v as f32),
                share: share as f32,
            }));
        }
    }

    fn sum_up(&mut self, points: &ScanPoints) {
        self.sums.clear();
        self.gaps_m.clear();
        let mut sum = [0.0; 5];
        self.sums.push(sum);
        let mut before: Option<[f64; 2]> = None;
        for [x, y, _] in points.iter() {
            let [x, y] = [f64::from(x), f64::from(y)];
            for (total, term) in sum.iter_mut().zip([x, y, x * x, x * y, y * y]) {
                *total += term;
            }
            self.sums.push(sum);
            if let Some([x0, y0]) = before.replace([x, y]) {
                self.gaps_m.push(((x - x0).powi(2) + (y - y0).powi(2)).sqrt());
            }
        }
    }

    /// The way from each point to the next that is its own: half of it to each side.
    fn own_length_m(&self, idx: usize) -> f64 {
        let before = idx.checked_sub(1).and_then(|before| self.gaps_m.get(before));
        let gap = |gap: Option<&f64>| gap.copied().filter(|gap| *gap <= WIDEST_GAP_M);
        match (gap(before), gap(self.gaps_m.get(idx))) {
            (Some(before), Some(after)) => 0.5 * (before + after),
            (one, other) => one.or(other).unwrap_or(0.0),
        }
    }

    /// The first and the last point of the run around a point, from those of the point before it.
    fn run(&self, points: &ScanPoints, idx: usize, before: [usize; 2]) -> [usize; 2] {
        let (x, y) = (points.x(), points.y());
        let is_near = |other: usize| {
            let (dx, dy) = (x[other] - x[idx], y[other] - y[idx]);
            dx * dx + dy * dy <= REACH_M * REACH_M
        };
        let is_one = |gap: usize| self.gaps_m.get(gap).is_some_and(|gap_m| *gap_m <= WIDEST_GAP_M);
        let goes_on = idx > 0 && is_one(idx - 1);
        let [mut first, mut last] = if goes_on { [before[0], before[1].max(idx)] } else { [idx, idx] };
        while idx - first > LEAST_NEIGHBORS && !is_near(first) {
            first += 1;
        }
        while is_one(last) && (last - idx < LEAST_NEIGHBORS || is_near(last + 1)) {
            last += 1;
        }
        while last - idx > LEAST_NEIGHBORS && !is_near(last) {
            last -= 1;
        }
        [first, last]
    }

    /// Of the line that fits best (total least squares).
    fn normal(&self, [first, last]: [usize; 2]) -> Option<[f64; 2]> {
        let end = last + 1;
        let n = (end - first) as f64;
        if n < 3.0 {
            return None;
        }
        let [x, y, xx, xy, yy] = std::array::from_fn(|k| (self.sums[end][k] - self.sums[first][k]) / n);
        let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y);
        let (half_trace, half_difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let root = (half_difference * half_difference + xy * xy).sqrt();
        let (across, along) = ((half_trace - root).max(0.0), half_trace + root);
        if along <= 0.0 || across > MOST_SPREAD * along {
            return None;
        }
        // The eigenvector of the smaller eigenvalue, by the longer of two ways to write it.
        let [nx, ny] = if half_difference >= 0.0 {
            [-xy, half_difference + root]
        } else {
            [root - half_difference, -xy]
        };
        let length = (nx * nx + ny * ny).sqrt();
        Some([nx / length, ny / length])
    }
}
