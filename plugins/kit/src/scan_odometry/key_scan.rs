//! The scan that others are registered to: its points by bearing, with their lines.

use super::equations::Line;
use super::key_lines::{Sums, find_lines};
use super::points::ScanPoints;
use super::settings::ScanOdometrySettings;

/// Parts of the full circle that the search begins from.
const N_PARTS: usize = 1024;

/// Points in order of their bearing from where their beams came, so that the nearest one to a place is found by looking
/// outward from its bearing. Kept between scans, so that a warm one allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct KeyScan {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Unit vectors from the origin.
    toward: Vec<[f64; 2]>,
    lines: Vec<Option<Line>>,
    origin: [f64; 2],
    /// First point at or after the beginning of each part.
    first_of_part: Vec<u32>,
    order: Vec<(f64, u32)>,
    sums: Vec<Sums>,
}

/// Grows with the bearing from 0 (straight back) to 4, without trigonometry.
#[inline(always)]
fn turn_of(x: f64, y: f64) -> f64 {
    let size = x.abs() + y.abs();
    if size <= 0.0 {
        return 0.0;
    }
    let share = y / size;
    if x >= 0.0 {
        2.0 + share
    } else if y < 0.0 {
        -share
    } else {
        4.0 - share
    }
}

fn part_of(turn: f64) -> usize {
    ((turn * (N_PARTS as f64 / 4.0)) as usize).min(N_PARTS - 1)
}

impl KeyScan {
    /// Takes the points of a scan.
    pub fn take(&mut self, points: &ScanPoints, settings: &ScanOdometrySettings) {
        self.origin = points.origin;
        let [x0, y0] = self.origin;
        self.order.clear();
        let places = points.x.iter().zip(&points.y);
        let turns = places.map(|(x, y)| turn_of(x - x0, y - y0));
        self.order.extend(turns.zip(0..));
        self.order.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        self.x.clear();
        self.y.clear();
        self.toward.clear();
        self.first_of_part.clear();
        for (place, (turn, idx)) in self.order.iter().enumerate() {
            let (Some(x), Some(y)) = (points.x.get(*idx as usize), points.y.get(*idx as usize)) else {
                continue;
            };
            let (dx, dy) = (x - x0, y - y0);
            let far_m = dx.hypot(dy).max(f64::MIN_POSITIVE);
            self.x.push(*x);
            self.y.push(*y);
            self.toward.push([dx / far_m, dy / far_m]);
            while self.first_of_part.len() <= part_of(*turn) {
                self.first_of_part.push(place as u32);
            }
        }
        self.first_of_part.resize(N_PARTS, self.order.len() as u32);
        find_lines(&self.x, &self.y, settings, &mut self.sums, &mut self.lines);
    }

    /// How many points it has.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// It has none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// A point of it, in order of bearing.
    pub fn point(&self, idx: usize) -> Option<[f64; 2]> {
        Some([*self.x.get(idx)?, *self.y.get(idx)?])
    }

    /// The line at a point; none where it stands alone.
    pub fn line(&self, idx: usize) -> Option<&Line> {
        self.lines.get(idx)?.as_ref()
    }

    /// The nearest point that is less than `within_m` away; none where there is none.
    ///
    /// Outward from the bearing of the place: a point whose bearing is off by an angle below a right one is at least its
    /// sine times the place's range away, and beyond that the whole range, which ends the search.
    #[inline]
    pub fn nearest(&self, [x, y]: [f64; 2], within_m: f64) -> Option<usize> {
        let n = self.x.len();
        let [rx, ry] = [x - self.origin[0], y - self.origin[1]];
        let start = *self.first_of_part.get(part_of(turn_of(rx, ry)))? as usize;
        let range2 = rx * rx + ry * ry;
        let mut best = (within_m * within_m, None);
        let mut visit = |idx: usize, side: f64| -> bool {
            let (Some(px), Some(py), Some([ux, uy])) =
                (self.x.get(idx), self.y.get(idx), self.toward.get(idx))
            else {
                return false;
            };
            let (dx, dy) = (px - x, py - y);
            let distance2 = dx * dx + dy * dy;
            if distance2 < best.0 {
                best = (distance2, Some(idx));
            }
            let (across, along) = (side * (rx * uy - ry * ux), rx * ux + ry * uy);
            let least2 = match (along > 0.0, across > 0.0) {
                (true, true) => across * across,
                (true, false) => 0.0,
                (false, _) => range2,
            };
            least2 < best.0
        };
        let mut idx = start;
        for _ in 0..n {
            idx = if idx < n { idx } else { 0 };
            if !visit(idx, 1.0) {
                break;
            }
            idx += 1;
        }
        idx = start;
        for _ in 0..n {
            idx = idx.checked_sub(1).unwrap_or(n - 1);
            if !visit(idx, -1.0) {
                break;
            }
        }
        best.1
    }
}
