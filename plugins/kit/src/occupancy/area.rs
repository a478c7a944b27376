//! Fills the area that a fan of beams swept, row by row.

use super::beam_ends::{BeamEnd, BeamEnds};
use super::ceil;
use super::evidence::Evidence;
use crate::GridSize;
use crate::simd::{self, Kernel, Vectors};

/// Cells whose middle lies inside the outline of the swept area, each exactly once. Keeps its memory between scans.
#[derive(Debug, Clone)]
pub struct AreaFill {
    outline: Vec<[f32; 2]>,
    rows: Rows,
}

/// Where an outline crosses the middles of rows: up to `width` crossings of row `first + r` at `r * width`.
#[derive(Debug, Clone)]
struct Rows {
    first: i32,
    width: usize,
    counts: Vec<u32>,
    crossings: Vec<f32>,
}

impl Default for AreaFill {
    fn default() -> Self {
        let rows = Rows { first: 0, width: 8, counts: Vec::new(), crossings: Vec::new() };
        AreaFill { outline: Vec::new(), rows }
    }
}

impl AreaFill {
    /// Makes the cells that the beams swept freer. Neighboring beams bound a wedge when both say something and the
    /// angle between them is at most `widest_wedge_rad`; beams without such a neighbor are not part of the area.
    /// `scale` is cells of this grid a cell of the ends.
    pub fn fill(
        &mut self,
        cells: &mut [f32],
        size: GridSize,
        beams: &BeamEnds,
        scale: f32,
        widest_wedge_rad: f64,
        evidence: &Evidence,
    ) {
        if beams.step_rad.abs() > widest_wedge_rad || cells.len() != size.n_cells() {
            return;
        }
        self.draw_outline(beams, scale);
        self.rows.span(&self.outline, size.height);
        while !self.rows.cross(&self.outline) {
            // A row is crossed more often than ever before: there will be room for twice as many from now on.
            self.rows.width *= 2;
        }
        simd::widest(FreeBetween { rows: &mut self.rows, cells, width: size.width, evidence });
    }

    /// The closed outline: through the sensor, along the ends of each run of neighbors, and back.
    fn draw_outline(&mut self, beams: &BeamEnds, scale: f32) {
        let origin = beams.origin.map(|v| v * scale);
        self.outline.clear();
        let says = |idx: usize| beams.ends.get(idx).is_some_and(|end| *end != BeamEnd::Nothing);
        let n = beams.ends.len();
        let is_whole = beams.is_closed && (0..n).all(says);
        if !is_whole {
            self.outline.push(origin);
        }
        let mut was_run = is_whole;
        for idx in (0..n).chain(beams.is_closed.then_some(0).filter(|_| !is_whole)) {
            if says(idx) {
                self.outline.push(drawn_in(beams, idx, origin, scale));
            } else if was_run {
                self.outline.push(origin);
            }
            was_run = says(idx);
        }
    }
}

impl Rows {
    /// The rows that the outline lies in.
    fn span(&mut self, outline: &[[f32; 2]], n_rows: usize) {
        let lowest = outline.iter().map(|point| point[1]).fold(f32::INFINITY, f32::min);
        let highest = outline.iter().map(|point| point[1]).fold(f32::NEG_INFINITY, f32::max);
        let n_rows = i32::try_from(n_rows).unwrap_or(i32::MAX);
        self.first = ceil(lowest - 0.5).clamp(0, n_rows);
        let end = ceil(highest - 0.5).clamp(self.first, n_rows);
        self.counts.clear();
        self.counts.resize((end - self.first) as usize, 0);
    }

    /// Collects the crossings of every row; false when a row has more than there is room for.
    fn cross(&mut self, outline: &[[f32; 2]]) -> bool {
        self.counts.fill(0);
        self.crossings.resize(self.counts.len() * self.width, 0.0);
        let end_row = self.first + self.counts.len() as i32;
        let Some(&last) = outline.last() else { return true };
        let mut from = last;
        let mut most = 0;
        for &to in outline {
            let (low, high) = if from[1] <= to[1] { (from, to) } else { (to, from) };
            // A row is crossed when its middle is: half open, so that chained edges cross it once.
            let first = ceil(low[1] - 0.5).max(self.first);
            let end = ceil(high[1] - 0.5).min(end_row);
            if first < end {
                let slope = (high[0] - low[0]) / (high[1] - low[1]);
                let begin_x = low[0] + (first as f32 + 0.5 - low[1]) * slope;
                let begin = (first - self.first) as usize;
                let crossed = &mut self.counts[begin..(end - self.first) as usize];
                for (k, count) in crossed.iter_mut().enumerate() {
                    if (*count as usize) < self.width {
                        // Not added up: the last of many rows is as exact as the first.
                        self.crossings[(begin + k) * self.width + *count as usize] =
                            begin_x + k as f32 * slope;
                    }
                    *count += 1;
                    most = most.max(*count);
                }
            }
            from = to;
        }
        most as usize <= self.width
    }
}

/// Frees the cells between every second pair of crossings of each row.
struct FreeBetween<'a> {
    rows: &'a mut Rows,
    cells: &'a mut [f32],
    width: usize,
    evidence: &'a Evidence,
}

impl Kernel for FreeBetween<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let FreeBetween { rows, cells, width, evidence } = self;
        let lines = cells.chunks_exact_mut(width).skip(rows.first as usize);
        let crossings = rows.crossings.chunks_exact_mut(rows.width);
        for ((line, crossings), count) in lines.zip(crossings).zip(&rows.counts) {
            let Some(xs) = crossings.get_mut(..*count as usize) else { continue };
            sort_few(xs);
            for span in xs.chunks_exact(2) {
                // A cell is inside when its middle is; half open, so that neighbors share no cell.
                let first = ceil(span[0] - 0.5).max(0) as usize;
                let last = (ceil(span[1] - 0.5).max(0) as usize).min(line.len());
                let Some(span) = line.get_mut(first.min(last)..last) else { continue };
                for cell in span {
                    *cell = evidence.passed(*cell);
                }
            }
        }
    }
}

/// Sorts the few crossings of a row by insertion.
#[inline(always)]
fn sort_few(xs: &mut [f32]) {
    for end in 1..xs.len() {
        let mut at = end;
        while at > 0 && xs[at - 1] > xs[at] {
            xs.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// The end of a beam, half a cell short of what it hit: the cell with the end in it is not free.
fn drawn_in(beams: &BeamEnds, idx: usize, origin: [f32; 2], scale: f32) -> [f32; 2] {
    let length = beams.length[idx] * scale;
    let part = match beams.ends[idx] {
        BeamEnd::Hit if length > 0.5 => (length - 0.5) / length,
        BeamEnd::Hit => 0.0,
        _ => 1.0,
    };
    let toward = |end: f32, origin: f32| origin + (end * scale - origin) * part;
    [toward(beams.x[idx], origin[0]), toward(beams.y[idx], origin[1])]
}
