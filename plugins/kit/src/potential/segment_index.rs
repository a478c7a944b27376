//! Which pieces may be within reach of a place: a uniform grid of lists.

use super::obstacles::Piece;
use nalgebra::Point2;

/// The lists may hold this many entries for each piece; a finer grid would need more memory than a linear one.
const MOST_ENTRIES_A_PIECE: usize = 32;
/// Cells for each piece, and some more for few pieces.
const MOST_CELLS_A_PIECE: f64 = 4.0;
const MOST_CELLS_FOR_FEW: f64 = 4096.0;

/// For each cell of a uniform grid the pieces that come within reach of any place in it, in order.
///
/// Cells are as wide as the reach, wider where that would need more than linear memory.
#[derive(Clone, Debug, Default)]
pub(super) struct SegmentIndex {
    lower: [f64; 2],
    cell_m: f64,
    n: [usize; 2],
    /// Where the list of each cell begins in `entries`, and where the last one ends.
    begins: Vec<u32>,
    entries: Vec<u32>,
}

impl SegmentIndex {
    pub fn new(pieces: &[Piece], reach_m: f64) -> SegmentIndex {
        if pieces.is_empty() {
            return SegmentIndex::default();
        }
        let (mut lower, mut upper) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for piece in pieces {
            let margin = reach_m + piece.radius_m;
            for k in 0..2 {
                lower[k] = lower[k].min(piece.from[k].min(piece.to[k]) - margin);
                upper[k] = upper[k].max(piece.from[k].max(piece.to[k]) + margin);
            }
        }
        let most_cells = MOST_CELLS_FOR_FEW + MOST_CELLS_A_PIECE * pieces.len() as f64;
        let extent = [upper[0] - lower[0], upper[1] - lower[1]];
        let mut cell_m = reach_m.max(1e-3);
        while (extent[0] / cell_m + 1.0) * (extent[1] / cell_m + 1.0) > most_cells {
            cell_m *= 2.0;
        }
        loop {
            let index = SegmentIndex::with_cells(pieces, reach_m, lower, extent, cell_m);
            let is_one_cell = index.as_ref().is_some_and(|index| index.n == [1, 1]);
            match index {
                Some(index) if is_one_cell || index.is_linear(pieces.len()) => return index,
                _ => cell_m *= 2.0,
            }
        }
    }

    fn is_linear(&self, n_pieces: usize) -> bool {
        self.entries.len() <= MOST_ENTRIES_A_PIECE * n_pieces + MOST_CELLS_FOR_FEW as usize
    }

    /// None as soon as the lists outgrow what is allowed.
    fn with_cells(
        pieces: &[Piece],
        reach_m: f64,
        lower: [f64; 2],
        extent: [f64; 2],
        cell_m: f64,
    ) -> Option<SegmentIndex> {
        let n = extent.map(|length| (length / cell_m) as usize + 1);
        let mut index = SegmentIndex { lower, cell_m, n, begins: vec![0; n[0] * n[1] + 1], entries: vec![] };
        let most = MOST_ENTRIES_A_PIECE * pieces.len() + MOST_CELLS_FOR_FEW as usize;
        let mut n_entries = 0;
        for piece in pieces {
            let (begins, mut n_here) = (&mut index.begins, 0);
            cells_within_reach(lower, cell_m, n, piece, reach_m, |cell| {
                begins[cell + 1] += 1;
                n_here += 1;
            });
            n_entries += n_here;
            if n_entries > most && n != [1, 1] {
                return None;
            }
        }
        for cell in 1..index.begins.len() {
            index.begins[cell] += index.begins[cell - 1];
        }
        let mut next = index.begins.clone();
        index.entries = vec![0; n_entries];
        for (place, piece) in (0_u32..).zip(pieces) {
            let entries = &mut index.entries;
            cells_within_reach(lower, cell_m, n, piece, reach_m, |cell| {
                entries[next[cell] as usize] = place;
                next[cell] += 1;
            });
        }
        Some(index)
    }

    /// The pieces that may be within reach.
    #[inline]
    pub fn around(&self, at: Point2<f64>) -> &[u32] {
        let (x, y) = ((at.x - self.lower[0]) / self.cell_m, (at.y - self.lower[1]) / self.cell_m);
        // Written so that NaN is outside.
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.n[0] as f64 && y < self.n[1] as f64;
        if !is_inside {
            return &[];
        }
        let cell = y as usize * self.n[0] + x as usize;
        let (begin, end) = (self.begins[cell] as usize, self.begins[cell + 1] as usize);
        &self.entries[begin..end]
    }

    pub fn n_entries(&self) -> usize {
        self.entries.len() + self.begins.len()
    }
}

/// The cells with any place within reach of a piece, and a few more: row by row, the stretch of the piece that comes
/// within reach of the row, widened by the reach.
fn cells_within_reach(
    lower: [f64; 2],
    cell_m: f64,
    n: [usize; 2],
    piece: &Piece,
    reach_m: f64,
    mut visit: impl FnMut(usize),
) {
    let margin = reach_m + piece.radius_m;
    let [low, high] =
        if piece.from.y <= piece.to.y { [piece.from, piece.to] } else { [piece.to, piece.from] };
    let cell_of = |v: f64, k: usize| (((v - lower[k]) / cell_m) as usize).min(n[k] - 1);
    let rise = high.y - low.y;
    for row in cell_of(low.y - margin, 1)..=cell_of(high.y + margin, 1) {
        let (below, above) = (lower[1] + row as f64 * cell_m, lower[1] + (row + 1) as f64 * cell_m);
        let share = |y: f64| if rise > 0.0 { ((y - low.y) / rise).clamp(0.0, 1.0) } else { 0.0 };
        let (mut t0, mut t1) = (share(below - margin), share(above + margin));
        if rise <= 0.0 {
            (t0, t1) = (0.0, 1.0);
        }
        let (x0, x1) = (low.x + (high.x - low.x) * t0, low.x + (high.x - low.x) * t1);
        for col in cell_of(x0.min(x1) - margin, 0)..=cell_of(x0.max(x1) + margin, 0) {
            visit(row * n[0] + col);
        }
    }
}
