//! Which points of a scan lie at which lines of the key scan.

use super::equations::{Equations, Line};
use super::key_scan::KeyScan;
use super::points::ScanPoints;
use super::settings::ScanOdometrySettings;
use nalgebra::Vector3;

/// A point at a line.
#[derive(Debug, Clone, Copy)]
struct Match {
    line: Line,
    /// The point, turned into the key scan's frame.
    arm: [f64; 2],
    residual_m: f64,
}

/// Standard deviation of a normal distribution over the median of its absolute values.
const NORMAL_OVER_MEDIAN: f64 = 1.4826;

/// Matched points. Kept between scans.
#[derive(Debug, Clone, Default)]
pub(super) struct Matches {
    matches: Vec<Match>,
    sizes_m: Vec<f64>,
}

impl Matches {
    /// Matches all points of a scan that was made at this pose (x, y, yaw in the key scan's frame), up to this distance.
    pub fn find(&mut self, key: &KeyScan, points: &ScanPoints, pose: &Vector3<f64>, within_m: f64) {
        self.matches.clear();
        let (sine, cosine) = pose.z.sin_cos();
        for (px, py) in points.x.iter().zip(&points.y) {
            let arm = [cosine * px - sine * py, sine * px + cosine * py];
            let at = [arm[0] + pose.x, arm[1] + pose.y];
            let found = key.nearest(at, within_m).and_then(|idx| key.line(idx));
            self.matches.extend(found.map(|line| Match {
                line: *line,
                arm,
                residual_m: line.residual_m(at),
            }));
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.matches.len()
    }

    /// The residual that all but the trimmed share are within, meters.
    fn most_m(&mut self, trim: f64) -> f64 {
        self.sizes_m.clear();
        self.sizes_m.extend(self.matches.iter().map(|one| one.residual_m.abs()));
        let n_kept = self.matches.len() - (trim * self.matches.len() as f64) as usize;
        let Some(last) = n_kept.checked_sub(1) else { return f64::INFINITY };
        *self.sizes_m.select_nth_unstable_by(last, f64::total_cmp).1
    }

    /// The normal equations of matches up to this distance, with Huber's weights.
    ///
    /// While the distance is still wide, what is far off is what shows the way: a pillar beside a corridor is a few points that
    /// all are off, and would be trimmed. The kernel is as wide then, and nothing is left out.
    pub fn equations(&mut self, settings: &ScanOdometrySettings, within_m: f64) -> Equations {
        let is_wide = settings.kernel_share > 0.0 && within_m > settings.least_match_m;
        let most_m = self.most_m(if is_wide { 0.0 } else { settings.trim });
        let huber_m =
            if is_wide { settings.huber_m.max(settings.kernel_share * within_m) } else { settings.huber_m };
        let mut equations = Equations::default();
        for one in self.matches.iter().filter(|one| one.residual_m.abs() <= most_m) {
            let size_m = one.residual_m.abs();
            let weight = if size_m <= huber_m { 1.0 } else { huber_m / size_m };
            equations.add(&one.line, one.arm, one.residual_m, weight);
        }
        equations
    }

    /// Variance of the residuals from their median, which neither trimming nor a few outliers change, m².
    pub fn variance_m2(&mut self) -> f64 {
        (NORMAL_OVER_MEDIAN * self.most_m(0.5)).powi(2)
    }

    /// Root of the mean square of the residuals that are not trimmed, meters.
    pub fn rms_m(&mut self, trim: f64) -> f64 {
        let most_m = self.most_m(trim);
        let kept = self.matches.iter().filter(|one| one.residual_m.abs() <= most_m);
        let (sum, n) = kept.fold((0.0, 0), |(sum, n), one| (sum + one.residual_m * one.residual_m, n + 1));
        (sum / f64::from(n.max(1))).sqrt()
    }
}
