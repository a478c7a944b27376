//! Fills the area that a fan of beams swept, row by row.

use super::beam_ends::{BeamEnd, BeamEnds};
use super::ceil;
use super::evidence::Evidence;
use crate::GridSize;
use crate::simd::{self, Kernel, Vectors};

/// Cells whose middle lies inside the outline of the swept area, each exactly once. Keeps its memory between scans.
#[derive(Debug, Clone, Default)]
pub struct AreaFill {
    outline: Vec<[f32; 2]>,
    rows: Rows,
}

/// Where an outline crosses the middles of rows, one row after the other: those of row `first + r` end at `ends[r]`. A row
/// along a wall is crossed a hundred times and most others twice, so each has as much room as it needs.
#[derive(Debug, Clone, Default)]
struct Rows {
    first: i32,
    ends: Vec<i32>,
    crossings: Vec<f32>,
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
        self.rows.cross(&self.outline);
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
        self.ends.clear();
        self.ends.resize((end - self.first) as usize, 0);
    }

    /// Collects the crossings of every row.
    fn cross(&mut self, outline: &[[f32; 2]]) {
        self.make_room(outline);
        let n_rows = self.ends.len();
        for [low, high] in edges(outline) {
            let crossed = rows_between(low, high, self.first, n_rows);
            if crossed.is_empty() {
                continue;
            }
            let slope = (high[0] - low[0]) / (high[1] - low[1]);
            let begin_x = low[0] + ((self.first + crossed.start as i32) as f32 + 0.5 - low[1]) * slope;
            for (k, end) in self.ends[crossed].iter_mut().enumerate() {
                // Not added up: the last of many rows is as exact as the first.
                self.crossings[*end as usize] = begin_x + k as f32 * slope;
                *end += 1;
            }
        }
    }

    /// Counts the crossings of every row; `ends` says where those of each begin.
    fn make_room(&mut self, outline: &[[f32; 2]]) {
        let n_rows = self.ends.len();
        // First by how much each row has more than the row before.
        for [low, high] in edges(outline) {
            let crossed = rows_between(low, high, self.first, n_rows);
            if crossed.is_empty() {
                continue;
            }
            self.ends[crossed.start] += 1;
            if let Some(behind) = self.ends.get_mut(crossed.end) {
                *behind -= 1;
            }
        }
        let (mut count, mut total) = (0, 0);
        for end in &mut self.ends {
            count += *end;
            *end = total;
            total += count;
        }
        self.crossings.clear();
        self.crossings.resize(total as usize, 0.0);
    }
}

/// The edges of a closed outline, each from its lower to its higher end.
fn edges(outline: &[[f32; 2]]) -> impl Iterator<Item = [[f32; 2]; 2]> {
    let before = outline.last().into_iter().chain(outline);
    before.zip(outline).map(|(from, to)| if from[1] <= to[1] { [*from, *to] } else { [*to, *from] })
}

/// Rows after `first` whose middles an edge crosses: half open, so that chained edges cross each once.
#[inline(always)]
fn rows_between(low: [f32; 2], high: [f32; 2], first: i32, n_rows: usize) -> std::ops::Range<usize> {
    let row = |y: f32| (ceil(y - 0.5).clamp(first, first + n_rows as i32) - first) as usize;
    row(low[1])..row(high[1])
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
        let mut begin = 0;
        for (line, end) in lines.zip(&rows.ends) {
            let Some(xs) = rows.crossings.get_mut(begin..*end as usize) else { continue };
            begin = *end as usize;
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
