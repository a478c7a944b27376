//! What one visit says of the cells of a raster.

use super::beams::{Beam, cells_on};
use super::evidence::{CellEvidence, VisitRules};
use super::raster::Raster;

/// A scan sees through a cell only where its beam goes on for this much behind it, cells: maps are off by one, and a beam
/// may end in the cell before or behind the right one.
const BEHIND_CELLS: f64 = 2.0;
/// And where the beam runs by the middle of the cell no farther off than this, cells: one that grazes a wall, with the pose
/// off by a centimeter, seems to run through the rim of the wall's cells.
const OFF_MIDDLE_CELLS: f64 = 0.25;
/// What a beam meets is looked for this far behind its end, cells: where a surface lies on the border of two cells, as in
/// drawn maps, half of the readings would scatter into the cell before it.
const INTO_CELLS: f64 = 0.3;
/// Cells that get room for evidence together: a visit sees only a part of a large map.
const CHUNK: usize = 1024;

#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    evidence: CellEvidence,
    /// Number of the last scan that said something of it; each says at most one thing.
    scan: u32,
}

/// The evidence of a visit.
#[derive(Debug, Clone)]
pub struct Visit {
    rules: VisitRules,
    chunks: Vec<Option<Box<[Seen]>>>,
    n_scans: u32,
}

impl Visit {
    /// Nothing was seen yet of a raster with so many cells.
    pub fn new(n_cells: usize, rules: VisitRules) -> Visit {
        Visit { rules, chunks: vec![None; n_cells.div_ceil(CHUNK)], n_scans: 0 }
    }

    /// When it is sure.
    pub fn rules(&self) -> &VisitRules {
        &self.rules
    }

    /// Scans taken in.
    pub fn n_scans(&self) -> u32 {
        self.n_scans
    }

    /// Takes in a scan, so many seconds after the visit began. A cell changes at most once, and a hit wins over any number
    /// of beams that pass.
    pub fn take(&mut self, beams: &[Beam], raster: &Raster, now_s: f32) {
        self.n_scans += 1;
        for beam in beams.iter().filter(|beam| beam.is_hit) {
            if let Some(cell) = raster.cell_at(beam.behind_end(INTO_CELLS)) {
                self.say(cell, |evidence, rules| evidence.hit(now_s, rules));
            }
        }
        for beam in beams {
            self.see_through(beam, raster, now_s);
        }
    }

    fn see_through(&mut self, beam: &Beam, raster: &Raster, now_s: f32) {
        let size = raster.size();
        let way = [beam.to[0] - beam.from[0], beam.to[1] - beam.from[1]];
        let length = way[0].hypot(way[1]);
        cells_on(beam.from, beam.to, |[col, row], _, leave| {
            let to_middle = [col as f64 + 0.5 - beam.from[0], row as f64 + 0.5 - beam.from[1]];
            let off_middle = (way[0] * to_middle[1] - way[1] * to_middle[0]).abs() / length;
            let (Ok(col), Ok(row)) = (usize::try_from(col), usize::try_from(row)) else { return };
            let is_inside = col < size.width && row < size.height;
            let is_through = off_middle <= OFF_MIDDLE_CELLS && leave + BEHIND_CELLS <= length;
            if is_inside && is_through {
                self.say(size.index(col, row), |evidence, rules| evidence.pass(now_s, rules));
            }
        });
    }

    fn say(&mut self, cell: usize, what: impl FnOnce(&mut CellEvidence, &VisitRules)) {
        let Some(chunk) = self.chunks.get_mut(cell / CHUNK) else { return };
        let chunk = chunk.get_or_insert_with(|| vec![Seen::default(); CHUNK].into_boxed_slice());
        if let Some(seen) = chunk.get_mut(cell % CHUNK).filter(|seen| seen.scan != self.n_scans) {
            seen.scan = self.n_scans;
            what(&mut seen.evidence, &self.rules);
        }
    }

    /// What is known of a cell.
    pub fn evidence(&self, cell: usize) -> CellEvidence {
        let chunk = self.chunks.get(cell / CHUNK).and_then(Option::as_ref);
        chunk
            .and_then(|chunk| chunk.get(cell % CHUNK))
            .map_or_else(CellEvidence::default, |seen| seen.evidence)
    }

    /// Cells of which something may be known, in their order.
    pub fn cells(&self) -> impl Iterator<Item = usize> + '_ {
        let chunks = self.chunks.iter().enumerate().filter(|(_, chunk)| chunk.is_some());
        chunks.flat_map(|(idx, _)| idx * CHUNK..(idx + 1) * CHUNK)
    }
}
