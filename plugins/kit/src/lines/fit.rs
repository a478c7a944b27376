//! Orthogonal least squares with the first-order covariance of (rho, phi).
//!
//! With centered sums `A = -2 S_xy`, `B = S_yy - S_xx` the normal is `phi = atan2(A, B) / 2`. In axes along the line (tau)
//! and across it (n), with `R = hypot(A, B)` and `(t', d')` a point's place from the middle, the derivatives of the fit are
//!
//! ```text
//! d phi / d p = -w (t' n + d' tau) / R        d rho / d p = w n / W + t_mean d phi / d p
//! ```
//!
//! the source's four expressions, turned: no angle but `phi` itself is needed. The tests keep the expressions as printed.

use super::PointNoise;
use super::points::Points;
use std::f64::consts::PI;
use std::iter::repeat;
use std::ops::Range;

/// A fitted line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineFit {
    /// Distance from the sensor, meters, at least zero.
    pub distance_m: f64,
    /// Direction of the normal, radians in (-pi, pi].
    pub normal_rad: f64,
    /// The normal itself.
    pub normal: [f64; 2],
    /// Root of the (weighted) mean square of residuals, meters.
    pub rms_m: f64,
    /// Middle of the points along the line, from the foot of the normal, meters.
    middle_m: f64,
    /// `hypot(A, B)`: how much farther the points spread along the line than across it, m² times the weights' unit.
    spread_m2: f64,
    /// Sum of the weights (W).
    weight: f64,
}

/// The line with the least sum of squared distances from points; none without a direction.
pub fn fit(points: &Points, piece: Range<usize>) -> Option<LineFit> {
    fitted(points, piece, repeat(1.0))
}

/// The line with the least sum of squared distances, each times its point's weight: one weight a point of the piece, at
/// least 0. None without a direction, and where weights are missing.
pub fn fit_weighted(points: &Points, piece: Range<usize>, weights: &[f64]) -> Option<LineFit> {
    let is_whole = weights.len() == piece.len() && weights.iter().all(|weight| *weight >= 0.0);
    is_whole.then(|| fitted(points, piece, weights.iter().copied()))?
}

#[inline(always)]
fn fitted(
    points: &Points,
    piece: Range<usize>,
    weights: impl Iterator<Item = f64> + Clone,
) -> Option<LineFit> {
    let (x, y) = (points.x.get(piece.clone())?, points.y.get(piece)?);
    let [weight, sum_x, sum_y] = sums(x, y, weights.clone());
    let (mean_x, mean_y) = (sum_x / weight, sum_y / weight);
    let [xx, xy, yy] = scatter(x, y, weights, [mean_x, mean_y]);
    let (a, b) = (-2.0 * xy, yy - xx);
    let spread_m2 = a.hypot(b);
    if !(spread_m2 > 0.0 && spread_m2.is_finite()) {
        return None;
    }
    let mut normal_rad = 0.5 * a.atan2(b);
    let (mut sin, mut cos) = normal_rad.sin_cos();
    let mut distance_m = mean_x * cos + mean_y * sin;
    if distance_m < 0.0 {
        (distance_m, sin, cos) = (-distance_m, -sin, -cos);
        normal_rad += if normal_rad > 0.0 { -PI } else { PI };
    }
    let across_m2 = (0.5 * (xx + yy - spread_m2)).max(0.0);
    Some(LineFit {
        distance_m,
        normal_rad,
        normal: [cos, sin],
        rms_m: (across_m2 / weight).sqrt(),
        middle_m: mean_y * cos - mean_x * sin,
        spread_m2,
        weight,
    })
}

/// Sum of the weights, and weighted sums of both coordinates.
#[inline(always)]
fn sums(x: &[f64], y: &[f64], weights: impl Iterator<Item = f64>) -> [f64; 3] {
    x.iter().zip(y).zip(weights).fold([0.0; 3], |[sum, sum_x, sum_y], ((x, y), weight)| {
        [sum + weight, sum_x + weight * x, sum_y + weight * y]
    })
}

#[inline(always)]
fn scatter(x: &[f64], y: &[f64], weights: impl Iterator<Item = f64>, [mean_x, mean_y]: [f64; 2]) -> [f64; 3] {
    x.iter().zip(y).zip(weights).fold([0.0; 3], |[xx, xy, yy], ((x, y), weight)| {
        let (dx, dy) = (x - mean_x, y - mean_y);
        [xx + weight * dx * dx, xy + weight * dx * dy, yy + weight * dy * dy]
    })
}

impl LineFit {
    /// Largest distance of a point from the line, meters.
    pub fn worst_m(&self, points: &Points, piece: Range<usize>) -> f64 {
        let [cos, sin] = self.normal;
        let places =
            points.x.get(piece.clone()).into_iter().flatten().zip(points.y.get(piece).into_iter().flatten());
        places.map(|(x, y)| (x * cos + y * sin - self.distance_m).abs()).fold(0.0, f64::max)
    }

    /// Where the points begin and end along the line, from the foot of the normal, meters.
    pub fn extent_m(&self, points: &Points, piece: Range<usize>) -> [f64; 2] {
        let [cos, sin] = self.normal;
        let places =
            points.x.get(piece.clone()).into_iter().flatten().zip(points.y.get(piece).into_iter().flatten());
        let along = places.map(|(x, y)| y * cos - x * sin);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], t| [least.min(t), most.max(t)])
    }

    /// The place that is so far along the line, meters.
    pub fn at(&self, along_m: f64) -> [f64; 2] {
        let [cos, sin] = self.normal;
        [self.distance_m * cos - along_m * sin, self.distance_m * sin + along_m * cos]
    }

    /// Covariance (rho², rho phi, phi²) from the noise of each point that the line was fitted to: polar noise
    /// `J diag(sigma_r², sigma_alpha²) J^T` plus `sigma_xy²` along both axes.
    pub fn covariance(&self, points: &Points, piece: Range<usize>, noise: &PointNoise) -> [f64; 3] {
        self.spread_of(points, piece, repeat(1.0), noise)
    }

    /// The covariance of a line that was fitted with these weights.
    pub fn weighted_covariance(
        &self,
        points: &Points,
        piece: Range<usize>,
        weights: &[f64],
        noise: &PointNoise,
    ) -> [f64; 3] {
        self.spread_of(points, piece, weights.iter().copied(), noise)
    }

    /// Weights that make of all lines through these points the surest one (Gauss and Markov): the inverse of each point's
    /// variance across this line. False, and no weights, where a point has no noise at all.
    pub fn weights(
        &self,
        points: &Points,
        piece: Range<usize>,
        noise: &PointNoise,
        weights: &mut Vec<f64>,
    ) -> bool {
        let [cos, sin] = self.normal;
        let beams = points.along_x.get(piece.clone()).into_iter().flatten();
        let beams = beams.zip(points.along_y.get(piece.clone()).into_iter().flatten());
        let beams = beams.zip(points.range_m.get(piece).into_iter().flatten());
        weights.clear();
        weights.extend(beams.map(|((along_x, along_y), range_m)| {
            let (across, along) = (along_x * cos + along_y * sin, along_y * cos - along_x * sin);
            let parts = [noise.range_m * across, noise.bearing_rad * range_m * along, noise.surface_m];
            1.0 / parts.iter().map(|sigma| sigma * sigma).sum::<f64>()
        }));
        let is_noisy = weights.iter().all(|weight| weight.is_finite());
        if !is_noisy {
            weights.clear();
        }
        is_noisy
    }

    #[inline(always)]
    fn spread_of(
        &self,
        points: &Points,
        piece: Range<usize>,
        weights: impl Iterator<Item = f64>,
        noise: &PointNoise,
    ) -> [f64; 3] {
        let [cos, sin] = self.normal;
        let middle_m = self.middle_m;
        let [range_m2, bearing_rad2, surface_m2] =
            [noise.range_m, noise.bearing_rad, noise.surface_m].map(|sigma| sigma * sigma);
        let (mut range, mut bearing, mut surface) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let beams = points.along_x.get(piece.clone()).into_iter().flatten();
        let beams = beams.zip(points.along_y.get(piece.clone()).into_iter().flatten());
        let beams = beams.zip(points.range_m.get(piece).into_iter().flatten());
        for (((along_x, along_y), range_m), weight) in beams.zip(weights) {
            let (turn, shift) = (-weight / self.spread_m2, weight / self.weight);
            // The beam in the line's axes, and the point from the middle of all.
            let (across, along) = (along_x * cos + along_y * sin, along_y * cos - along_x * sin);
            let (d_m, t_m) = (range_m * across - self.distance_m, range_m * along - middle_m);
            // How the normal and the distance answer to a longer range, ...
            let phi_range = turn * (t_m * across + d_m * along);
            add(&mut range, [across * shift + middle_m * phi_range, phi_range]);
            // ... to another bearing, which moves the point across the beam by its range, ...
            let phi_bearing = turn * range_m * (d_m * across - t_m * along);
            add(&mut bearing, [-along * range_m * shift + middle_m * phi_bearing, phi_bearing]);
            // ... and to a rough wall: across the line and along it.
            let phi_across = turn * t_m;
            add(&mut surface, [shift + middle_m * phi_across, phi_across]);
            let phi_along = turn * d_m;
            add(&mut surface, [middle_m * phi_along, phi_along]);
        }
        [0, 1, 2].map(|k| range_m2 * range[k] + bearing_rad2 * bearing[k] + surface_m2 * surface[k])
    }
}

/// Adds what one error does to (rho, phi) as squares and product.
#[inline(always)]
fn add(sum: &mut [f64; 3], [rho, phi]: [f64; 2]) {
    sum[0] += rho * rho;
    sum[1] += rho * phi;
    sum[2] += phi * phi;
}
