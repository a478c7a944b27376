//! One scan into one grid: free space, then hits.

use super::area::AreaFill;
use super::beam_ends::{BeamEnd, BeamEnds};
use super::evidence::Evidence;
use super::floor;
use super::line::line_cells;
use crate::GridSize;

/// Which cells a scan says are free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FreeSpace {
    /// Those on the beams (Bresenham lines).
    Beams,
    /// Those between neighboring beams that are at most this far apart, radians; other beams as lines.
    Area {
        /// Widest angle between beams that bound an area.
        widest_wedge_rad: f64,
    },
}

/// Puts scans into grids of log-odds. Keeps its memory, so that a warm scan allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct ScanPainter {
    area: AreaFill,
    passed: Vec<(u32, f32)>,
    hits: Vec<(u32, f32)>,
}

impl ScanPainter {
    /// Adds the scan whose beams end at `beams`; `scale` is cells of this grid a cell of the ends. Returns whether the
    /// sensor stands on the grid; if not, nothing is changed.
    pub fn paint(
        &mut self,
        cells: &mut [f32],
        size: GridSize,
        beams: &BeamEnds,
        scale: f32,
        free_space: FreeSpace,
        evidence: &Evidence,
    ) -> bool {
        let sensor = beams.origin.map(|v| floor(v * scale));
        let inside = |cell: [i32; 2]| {
            cell[0] >= 0
                && cell[1] >= 0
                && (cell[0] as usize) < size.width
                && (cell[1] as usize) < size.height
        };
        if !inside(sensor) || cells.len() != size.n_cells() {
            return false;
        }
        self.passed.clear();
        self.hits.clear();
        let is_fan_of_lines = match free_space {
            FreeSpace::Beams => true,
            FreeSpace::Area { widest_wedge_rad } => beams.step_rad.abs() > widest_wedge_rad,
        };
        let at_sensor = size.index(sensor[0] as usize, sensor[1] as usize);
        self.hits.reserve(beams.n_hits);
        let mut says_something = false;
        let mut before = beams.neighbor_before_first();
        for (idx, end) in beams.ends.iter().copied().enumerate() {
            let beside = [std::mem::replace(&mut before, end), beams.after(idx)];
            if end == BeamEnd::Nothing {
                continue;
            }
            let cell = [beams.x[idx], beams.y[idx]].map(|v| floor(v * scale));
            if cell == sensor {
                continue;
            }
            says_something = true;
            let is_inside = inside(cell);
            let index = if is_inside { size.index(cell[0] as usize, cell[1] as usize) } else { 0 };
            // Without a neighbor it bounds no area, so its own cells are all that it says.
            if is_fan_of_lines || beside == [BeamEnd::Nothing; 2] {
                let passed = &mut self.passed;
                line_cells(size, sensor, cell, |passing| passed.push((passing as u32, cells[passing])));
                if end == BeamEnd::Open && is_inside {
                    passed.push((index as u32, cells[index]));
                }
            }
            if end == BeamEnd::Hit && is_inside {
                self.hits.push((index as u32, cells[index]));
            }
        }
        if !says_something {
            return true;
        }
        self.passed.push((at_sensor as u32, cells[at_sensor]));
        if let FreeSpace::Area { widest_wedge_rad } = free_space {
            self.area.fill(cells, size, beams, scale, widest_wedge_rad, evidence);
        }
        // Written from what the cells held before the scan: once, however many beams met in a cell.
        for (index, before) in &self.passed {
            cells[*index as usize] = evidence.passed(*before);
        }
        for (index, before) in &self.hits {
            cells[*index as usize] = evidence.hit(*before);
        }
        true
    }
}
