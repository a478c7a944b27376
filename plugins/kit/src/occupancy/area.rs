//! Fills the area that a fan of beams swept, row by row.

use super::beam_ends::{BeamEnd, BeamEnds};
use super::ceil;
use super::evidence::Evidence;
use crate::GridSize;

/// Cells whose middle lies inside the outline of the swept area, each exactly once. Keeps its memory between scans.
#[derive(Debug, Clone, Default)]
pub struct AreaFill {
    outline: Vec<[f32; 2]>,
    crossings: Vec<(u32, f32)>,
    first_row: u32,
    sorted: Vec<f32>,
    starts: Vec<u32>,
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
        if beams.step_rad.abs() > widest_wedge_rad {
            return;
        }
        self.draw_outline(beams, scale);
        self.cross_rows(size.height);
        self.sort_by_row();
        let rows = cells.chunks_exact_mut(size.width).skip(self.first_row as usize);
        for (line, bounds) in rows.zip(self.starts.windows(2)) {
            let Some(xs) = self.sorted.get_mut(bounds[0] as usize..bounds[1] as usize) else { return };
            xs.sort_unstable_by(f32::total_cmp);
            for span in xs.chunks_exact(2) {
                // A cell is inside when its middle is; the comparison is half open, so neighbors share no cell.
                let first = ceil(span[0] - 0.5).max(0) as usize;
                let last = (ceil(span[1] - 0.5).max(0) as usize).min(line.len());
                for cell in line.get_mut(first.min(last)..last).into_iter().flatten() {
                    *cell = evidence.passed(*cell);
                }
            }
        }
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

    /// Where the outline crosses the middle of each row.
    fn cross_rows(&mut self, n_rows: usize) {
        self.crossings.clear();
        self.first_row = u32::MAX;
        let n_rows = i32::try_from(n_rows).unwrap_or(i32::MAX);
        let Some(&last) = self.outline.last() else { return };
        let mut from = last;
        for &to in &self.outline {
            let (low, high) = if from[1] <= to[1] { (from, to) } else { (to, from) };
            let first = ceil(low[1] - 0.5).max(0);
            let end = ceil(high[1] - 0.5).min(n_rows);
            if first < end {
                let slope = (high[0] - low[0]) / (high[1] - low[1]);
                let begin_x = low[0] + (first as f32 + 0.5 - low[1]) * slope;
                self.first_row = self.first_row.min(first as u32);
                for k in 0..end - first {
                    self.crossings.push(((first + k) as u32, begin_x + k as f32 * slope));
                }
            }
            from = to;
        }
    }

    /// Crossings of row `first_row + r` end up at `starts[r]..starts[r + 1]`.
    fn sort_by_row(&mut self) {
        let last_row = self.crossings.iter().map(|(row, _)| *row).max();
        let n_rows = last_row.map_or(0, |last| last - self.first_row + 1) as usize;
        self.starts.clear();
        // Counted two places on, so that scattering by the place before leaves the starts behind.
        self.starts.resize(n_rows + 2, 0);
        for (row, _) in &self.crossings {
            self.starts[(row - self.first_row) as usize + 2] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.sorted.resize(self.crossings.len(), 0.0);
        for (row, x) in &self.crossings {
            let next = &mut self.starts[(row - self.first_row) as usize + 1];
            self.sorted[*next as usize] = *x;
            *next += 1;
        }
        self.starts.pop();
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
