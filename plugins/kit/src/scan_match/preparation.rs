//! From readings to points: what of a scan is worth matching, and how much.

use super::points::ScanPoints;
use super::shape::ScanShape;
use nalgebra::{Matrix2, Vector2};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::LaserScan;

/// Which readings become points, and their weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPreparation {
    /// Nearer readings are left out, meters.
    pub min_range_m: f64,
    /// Farther readings are left out, meters.
    pub max_range_m: f64,
    /// Points lower or higher than this against the sensor's own height are left out, meters: ground and ceiling as a
    /// tilted scanner sees them.
    pub height_band_m: [f64; 2],
    /// At most so many points, at equal distances along what was seen, so that near walls do not count for more; 0
    /// takes all.
    pub max_points: usize,
    /// Points closer together than this weigh less, by their distance, meters; 0 weighs all the same.
    pub full_weight_spacing_m: f64,
    /// Range noise `a + b r²`, meters and 1/meters: points weigh `1 / (1 + (noise / sigma0)²)`.
    pub noise: [f64; 2],
    /// The noise at which a point weighs half, meters (sigma0); 0 weighs all the same.
    pub half_weight_noise_m: f64,
}

impl Default for ScanPreparation {
    fn default() -> Self {
        ScanPreparation {
            min_range_m: 0.4,
            max_range_m: 30.0,
            height_band_m: [-1.0, 1.0],
            max_points: 0,
            full_weight_spacing_m: 0.0,
            noise: [0.005, 0.0015],
            half_weight_noise_m: 0.0,
        }
    }
}

/// A gap in what was seen counts for no more than this, meters: behind an edge nothing was seen.
const LONGEST_GAP_M: f64 = 0.5;

/// What a scan tells by its own shape, by its readings between these ranges (m); none where it tells all directions many times
/// over.
pub fn shape_of(scan: &LaserScan, base_from_sensor: &Pose3, ranges_m: [f64; 2]) -> Option<ScanShape> {
    let [min_range_m, max_range_m] = ranges_m;
    let height_band_m = [f64::NEG_INFINITY, f64::INFINITY];
    let preparation =
        ScanPreparation { min_range_m, max_range_m, height_band_m, ..ScanPreparation::default() };
    let mut points = ScanPoints::default();
    preparation.prepare(scan, base_from_sensor, &mut points);
    points.take_shape()
}

impl ScanPreparation {
    /// Replaces the points by those of a scan, in the base frame; roll and pitch of the sensor count.
    pub fn prepare(&self, scan: &LaserScan, base_from_sensor: &Pose3, points: &mut ScanPoints) {
        points.clear();
        let axes = base_from_sensor.rotation.to_rotation_matrix();
        let origin = base_from_sensor.translation;
        let [lowest_m, highest_m] = self.height_band_m;
        let mut beams = Vec::with_capacity(scan.ranges_m.len());
        for (idx, &reading_m) in scan.ranges_m.iter().enumerate() {
            let range_m = f64::from(reading_m);
            let is_reading = reading_m >= scan.min_range_m && reading_m <= scan.max_range_m;
            if !is_reading || range_m <= self.min_range_m || range_m >= self.max_range_m {
                continue;
            }
            let (sin, cos) = scan.bearing_rad(idx).sin_cos();
            let (ahead, left) = (range_m * cos, range_m * sin);
            let height_m = axes[(2, 0)] * ahead + axes[(2, 1)] * left;
            if height_m > lowest_m && height_m < highest_m {
                let x = origin.x + axes[(0, 0)] * ahead + axes[(0, 1)] * left;
                let y = origin.y + axes[(1, 0)] * ahead + axes[(1, 1)] * left;
                let n_before = points.len();
                points.push(x as f32, y as f32, self.weight_by_noise(range_m) as f32);
                if points.len() > n_before {
                    beams.push(idx);
                }
            }
        }
        let mount = [axes[(0, 0)], axes[(0, 1)], axes[(1, 0)], axes[(1, 1)], origin.x, origin.y];
        let scanned = Scanned { scan, beams: &beams, max_range_m: self.max_range_m, mount };
        let sensor = [origin.x as f32, origin.y as f32];
        let shape = ScanShape::of(points, sensor, |idx, across| scanned.ends_wall(idx, across, points));
        if self.full_weight_spacing_m > 0.0 {
            self.weigh_by_spacing(points);
        }
        if self.max_points > 0 && points.len() > self.max_points {
            thin(points, self.max_points);
        }
        points.set_shape(shape);
    }

    fn weight_by_noise(&self, range_m: f64) -> f64 {
        if self.half_weight_noise_m <= 0.0 {
            return 1.0;
        }
        let ratio = (self.noise[0] + self.noise[1] * range_m * range_m) / self.half_weight_noise_m;
        1.0 / (1.0 + ratio * ratio)
    }

    fn weigh_by_spacing(&self, points: &mut ScanPoints) {
        let full = self.full_weight_spacing_m;
        let gaps = gaps(points);
        let share = |idx: usize| {
            let before = idx.checked_sub(1).and_then(|before| gaps.get(before));
            let (before, after) = (before.copied(), gaps.get(idx).copied());
            // Half of the way to each neighbor is its own; at an end the one gap counts for both.
            let own = match (before, after) {
                (Some(before), Some(after)) => 0.5 * (before.min(full) + after.min(full)),
                (gap, None) | (None, gap) => gap.unwrap_or(full).min(full),
            };
            (own / full) as f32
        };
        let shares: Vec<f32> = (0..points.len()).map(share).collect();
        // A weight of zero would take the point out of the count.
        for (weight, share) in points.weights_mut().iter_mut().zip(shares) {
            *weight *= share.max(1e-3);
        }
    }
}

/// Where the points of a scan come from.
struct Scanned<'a> {
    scan: &'a LaserScan,
    /// The beam of each point.
    beams: &'a [usize],
    max_range_m: f64,
    /// Ahead and left of the sensor along x, the same along y, and where it is, in the base frame.
    mount: [f64; 6],
}

/// So many beams beside a wall that see nothing of it end it: one or two are lost now and then.
const MISSED_BEAMS: usize = 4;
/// What is seen this much farther away than the wall would be is another surface, meters and a share of the range.
const BEHIND: [f64; 2] = [0.2, 0.1];
/// Where beams meet a wall less steeply than 15 degrees, they may come back to nobody however near it is: the square of the sine.
const STEEP: f64 = 0.067;
/// Share of the longest range at which a wall would surely be seen.
const SURELY_SEEN: f64 = 0.9;

impl Scanned<'_> {
    /// Beams beside the point see nothing, or something behind, although the wall would be within their range if it went on.
    fn ends_wall(&self, idx: usize, across: &Matrix2<f64>, points: &ScanPoints) -> bool {
        let (Some(beam), Some(x), Some(y)) = (self.beams.get(idx), points.x().get(idx), points.y().get(idx))
        else {
            return false;
        };
        let [xx, xy, yx, yy, from_x, from_y] = self.mount;
        let to_point = Vector2::new(f64::from(*x) - from_x, f64::from(*y) - from_y);
        let limit_m = self.max_range_m.min(f64::from(self.scan.max_range_m));
        let is_missed = |beam: usize| {
            let Some(reading_m) = self.scan.ranges_m.get(beam).map(|reading_m| f64::from(*reading_m)) else {
                return false;
            };
            let (sin, cos) = self.scan.bearing_rad(beam).sin_cos();
            let along = Vector2::new(xx * cos + xy * sin, yx * cos + yy * sin);
            let steep = along.dot(&(across * along));
            let wall_m = along.dot(&(across * to_point)) / steep;
            let is_absent = reading_m.is_nan() || reading_m <= 0.0 || reading_m >= limit_m;
            let is_behind =
                if is_absent { steep > STEEP } else { reading_m > wall_m + BEHIND[0] + BEHIND[1] * wall_m };
            is_behind && wall_m > 0.0 && wall_m < SURELY_SEEN * limit_m
        };
        (1..=MISSED_BEAMS).all(|k| is_missed(beam + k))
            || (1..=MISSED_BEAMS).all(|k| beam.checked_sub(k).is_some_and(is_missed))
    }
}

/// The way from each point to the next, meters.
fn gaps(points: &ScanPoints) -> Vec<f64> {
    let apart = |(x, y): (&[f32], &[f32])| match (x, y) {
        (&[x0, x1], &[y0, y1]) => f64::from((x1 - x0).hypot(y1 - y0)),
        _ => 0.0,
    };
    points.x().windows(2).zip(points.y().windows(2)).map(apart).collect()
}

/// Keeps `n` points at equal distances along what was seen.
fn thin(points: &mut ScanPoints, n: usize) {
    let all = points.clone();
    let gaps = gaps(&all);
    let total_m: f64 = gaps.iter().map(|gap| gap.min(LONGEST_GAP_M)).sum();
    points.clear();
    let mut way_m = 0.0;
    let mut n_kept = 0;
    for (idx, [x, y, weight]) in all.iter().enumerate() {
        let n_left = all.len() - idx;
        let is_due = way_m >= total_m * n_kept as f64 / n as f64;
        if n_kept < n && (is_due || n_left <= n - n_kept) {
            points.push(x, y, weight);
            n_kept += 1;
        }
        way_m += gaps.get(idx).map_or(0.0, |gap| gap.min(LONGEST_GAP_M));
    }
}
