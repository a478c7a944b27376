//! Readings of a scan as points, in beam order, without those that met nothing.

use super::LineSettings;
use super::breaks::BreakRule;
use crate::landmarks::BeamFan;
use std::f64::consts::TAU;
use std::ops::Range;

impl BeamFan {
    /// Beams until the circle is closed, where so many beams close it.
    fn circle(&self, n_beams: usize) -> Option<usize> {
        let n_circle = (TAU / self.bearing_step_rad.abs()).round();
        // A device that looks all around may look ahead twice: once at the begin and once at the end.
        let is_closed = n_beams as f64 == n_circle || n_beams as f64 == n_circle + 1.0;
        let is_even =
            (n_circle * self.bearing_step_rad.abs() - TAU).abs() < 0.5 * self.bearing_step_rad.abs();
        (is_closed && is_even).then_some(n_circle as usize)
    }
}

/// Points of one scan, and where they break into runs.
#[derive(Debug, Clone, Default)]
pub struct Points {
    /// Bearings that the directions were computed for.
    fan: Option<[f64; 2]>,
    directions: Vec<[f64; 2]>,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// Unit vectors of the beams.
    pub(super) along_x: Vec<f64>,
    pub(super) along_y: Vec<f64>,
    pub(super) range_m: Vec<f64>,
    /// First points of runs, without the very first.
    breaks: Vec<usize>,
}

impl Points {
    /// Points from their polar coordinates, radians and meters, as one run.
    pub fn of_polar(polar: &[[f64; 2]]) -> Points {
        let mut points = Points::default();
        for [bearing_rad, range_m] in polar {
            let (sin, cos) = bearing_rad.sin_cos();
            points.push([cos, sin], *range_m);
        }
        points
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.range_m.len()
    }

    /// There is none.
    pub fn is_empty(&self) -> bool {
        self.range_m.is_empty()
    }

    fn push(&mut self, [along_x, along_y]: [f64; 2], range_m: f64) {
        self.x.push(range_m * along_x);
        self.y.push(range_m * along_y);
        self.along_x.push(along_x);
        self.along_y.push(along_y);
        self.range_m.push(range_m);
    }

    fn columns(&mut self) -> [&mut Vec<f64>; 5] {
        [&mut self.x, &mut self.y, &mut self.along_x, &mut self.along_y, &mut self.range_m]
    }

    /// Takes in a scan; the last one is forgotten. Ranges outside the device's reach, and those that are no numbers, break
    /// the sequence.
    pub(super) fn place(
        &mut self,
        fan: &BeamFan,
        ranges_m: impl ExactSizeIterator<Item = f64>,
        settings: &LineSettings,
    ) {
        self.columns().into_iter().for_each(Vec::clear);
        self.breaks.clear();
        if !(fan.first_bearing_rad.is_finite() && fan.bearing_step_rad.is_finite()) {
            return;
        }
        let circle = fan.circle(ranges_m.len());
        self.aim(fan, ranges_m.len());
        let rule = BreakRule::new(settings, fan.bearing_step_rad);
        let reach = fan.min_range_m.max(f64::MIN_POSITIVE)..fan.max_range_m;
        let (mut is_after_gap, mut ends_open) = (true, [false; 2]);
        let n_beams = circle.unwrap_or(ranges_m.len());
        for (idx, range_m) in ranges_m.take(n_beams).enumerate() {
            let Some(along) = self.directions.get(idx).copied().filter(|_| reach.contains(&range_m)) else {
                is_after_gap = true;
                continue;
            };
            let last = self.range_m.last().copied();
            if last.is_some_and(|last_m| is_after_gap || rule.parts(last_m, range_m)) {
                self.breaks.push(self.len());
            }
            is_after_gap = false;
            ends_open[0] |= idx == 0;
            ends_open[1] |= idx + 1 == n_beams;
            self.push(along, range_m);
        }
        let ends = [self.range_m.last().copied(), self.range_m.first().copied()];
        if let (Some(_), true, [Some(last_m), Some(first_m)]) = (circle, ends_open == [true; 2], ends)
            && !rule.parts(last_m, first_m)
        {
            self.begin_at_a_break();
        }
    }

    /// Directions of the beams, computed anew only when the device changes.
    fn aim(&mut self, fan: &BeamFan, n_beams: usize) {
        let bearings = [fan.first_bearing_rad, fan.bearing_step_rad];
        if self.fan != Some(bearings) {
            self.fan = Some(bearings);
            self.directions.clear();
        }
        for idx in self.directions.len()..n_beams {
            let (sin, cos) = (bearings[0] + bearings[1] * idx as f64).sin_cos();
            self.directions.push([cos, sin]);
        }
    }

    /// The first run goes on where the last one ends: turns the circle so that none is cut. A circle without a break is
    /// cut at its farthest point, which in a room is a corner.
    fn begin_at_a_break(&mut self) {
        let n_points = self.len();
        let farthest = || {
            let far = self.range_m.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
            far.map_or(0, |(idx, _)| idx)
        };
        let begin = self.breaks.first().copied().unwrap_or_else(farthest);
        for column in self.columns() {
            column.rotate_left(begin);
        }
        if self.breaks.is_empty() {
            // Both pieces at the corner keep its point.
            for column in self.columns() {
                column.extend_from_within(..1);
            }
            return;
        }
        self.breaks.remove(0);
        self.breaks.iter_mut().for_each(|at| *at -= begin);
        debug_assert!(self.breaks.iter().all(|at| *at < n_points));
    }

    /// The runs between breaks.
    pub(super) fn runs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let begins = std::iter::once(0).chain(self.breaks.iter().copied());
        let ends = self.breaks.iter().copied().chain([self.len()]);
        begins.zip(ends).map(|(begin, end)| begin..end)
    }
}
