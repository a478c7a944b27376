//! One tile of a cost field: 32 x 32 cells relaxed together, in rows and in columns.
//!
//! A sweep relaxes every cell of a row from the row beside it, all cells at once; columns are rows of the transposed
//! tile. Sums are formed exactly as the slow twin forms them, one step at a time from the source, so both end in the
//! same fixed point to the bit.

use crate::simd::{self, Line, Vectors, lesser};

/// Cells along a tile's edge.
pub(super) const SIDE: usize = simd::LINE_CELLS;
/// Cells of a tile.
pub(super) const CELLS: usize = SIDE * SIDE;
/// Padding before and after a line; the innermost padding cell holds the neighboring tile's edge.
const PAD: usize = simd::LINE_PAD;
const LINE: usize = SIDE + 2 * PAD;

/// Cost of a cell that no path enters.
pub(super) const BLOCKED: f64 = f64::INFINITY;
/// Cost of an open cell not reached so far: finite, so that it differs from a blocked one, and too large to be changed
/// by adding a step.
pub(super) const UNREACHED: f64 = 1e300;

/// Rows or columns with the neighboring tiles' cells at both ends: 1 to `SIDE` are the tile's own, 0 and `SIDE + 1`
/// belong to its neighbors.
#[repr(align(64))]
struct Lines([Line; SIDE + 2]);

/// Costs of straight steps into the cells.
#[repr(align(64))]
struct Entries([[f64; SIDE]; SIDE]);

/// Which lines have been lowered since their neighbors in one direction were relaxed: bit `i` is line `i`.
#[derive(Clone, Copy, Default)]
struct Lowered {
    onwards: u64,
    backwards: u64,
}

impl Lowered {
    fn any(self) -> bool {
        // Nothing lies beyond the outermost lines.
        self.onwards & !(1 << (SIDE + 1)) != 0 || self.backwards & !1 != 0
    }

    fn mark(&mut self, line: usize) {
        self.mark_all(1 << line);
    }

    fn mark_all(&mut self, lines: u64) {
        self.onwards |= lines;
        self.backwards |= lines;
    }
}

/// Working memory for one tile.
pub(super) struct TileSolver {
    rows: Lines,
    cols: Lines,
    row_entries: Entries,
    col_entries: Entries,
    lowered_rows: Lowered,
    lowered_cols: Lowered,
    /// First and last row, first and last column as they were loaded.
    before: [[f64; SIDE]; 4],
}

/// How steps are priced and where they may go.
#[derive(Clone, Copy)]
pub(super) struct Steps {
    /// What a diagonal step costs more than a straight one.
    pub(super) diagonal_extra: f64,
    /// Diagonal steps may squeeze past a blocked cell.
    pub(super) corner_cutting: bool,
}

impl TileSolver {
    pub(super) fn new() -> Box<Self> {
        Box::new(Self {
            rows: Lines([[BLOCKED; LINE]; SIDE + 2]),
            cols: Lines([[BLOCKED; LINE]; SIDE + 2]),
            row_entries: Entries([[BLOCKED; SIDE]; SIDE]),
            col_entries: Entries([[BLOCKED; SIDE]; SIDE]),
            lowered_rows: Lowered::default(),
            lowered_cols: Lowered::default(),
            before: [[BLOCKED; SIDE]; 4],
        })
    }

    /// Loads a tile's costs and entry costs, row by row.
    #[inline(always)]
    pub(super) fn load<V: Vectors>(&mut self, costs: &[f64; CELLS], entries: &[f64; CELLS]) {
        let (costs, _) = costs.as_chunks::<SIDE>();
        let (entries, _) = entries.as_chunks::<SIDE>();
        for (i, (cost, entry)) in costs.iter().zip(entries).enumerate() {
            self.rows.0[i + 1][PAD..PAD + SIDE].copy_from_slice(cost);
            self.row_entries.0[i] = *entry;
        }
        copy_transposed::<V>(&self.rows, &mut self.cols);
        self.begin::<V>();
    }

    /// Loads a tile that no path has reached so far.
    #[inline(always)]
    pub(super) fn load_fresh<V: Vectors>(&mut self, entries: &[f64; CELLS]) {
        let (entries, _) = entries.as_chunks::<SIDE>();
        for (i, entry) in entries.iter().enumerate() {
            self.rows.0[i + 1][PAD..PAD + SIDE].copy_from_slice(&entry.map(super::before_any_path));
            self.row_entries.0[i] = *entry;
        }
        copy_transposed::<V>(&self.rows, &mut self.cols);
        self.begin::<V>();
    }

    #[inline(always)]
    fn begin<V: Vectors>(&mut self) {
        V::transpose(self.row_entries.0.as_flattened(), SIDE, self.col_entries.0.as_flattened_mut(), SIDE);
        self.lowered_rows = Lowered::default();
        self.lowered_cols = Lowered::default();
        let outer = [&self.rows.0[1], &self.rows.0[SIDE], &self.cols.0[1], &self.cols.0[SIDE]];
        self.before = outer.map(|line| *own_cells(line));
    }

    /// Sets the edges of the neighbors below, above, left and right; `BLOCKED` where there is none.
    #[inline(always)]
    pub(super) fn set_edges(&mut self, edges: [&[f64; SIDE]; 4], corners: [f64; 4]) {
        let [below, above, left, right] = edges;
        for i in 0..SIDE {
            self.cols.0[i + 1][PAD - 1] = below[i];
            self.cols.0[i + 1][PAD + SIDE] = above[i];
            self.rows.0[i + 1][PAD - 1] = left[i];
            self.rows.0[i + 1][PAD + SIDE] = right[i];
        }
        let whole = |edge: &[f64; SIDE], before: f64, after: f64| {
            let mut line = [BLOCKED; LINE];
            line[PAD..PAD + SIDE].copy_from_slice(edge);
            line[PAD - 1] = before;
            line[PAD + SIDE] = after;
            line
        };
        let [below_left, below_right, above_left, above_right] = corners;
        self.rows.0[0] = whole(below, below_left, below_right);
        self.rows.0[SIDE + 1] = whole(above, above_left, above_right);
        self.cols.0[0] = whole(left, below_left, above_left);
        self.cols.0[SIDE + 1] = whole(right, below_right, above_right);
    }

    /// Marks what changed around the tile: bits as [`Side`].
    pub(super) fn mark_sides(&mut self, sides: u8) {
        if sides & Side::Below as u8 != 0 {
            self.lowered_rows.onwards |= 1;
        }
        if sides & Side::Above as u8 != 0 {
            self.lowered_rows.backwards |= 1 << (SIDE + 1);
        }
        if sides & Side::Left as u8 != 0 {
            self.lowered_cols.onwards |= 1;
        }
        if sides & Side::Right as u8 != 0 {
            self.lowered_cols.backwards |= 1 << (SIDE + 1);
        }
        if sides & Side::Inside as u8 != 0 {
            for line in 1..=SIDE {
                self.lowered_rows.mark(line);
                self.lowered_cols.mark(line);
            }
        }
    }

    /// Relaxes until nothing in the tile can be lowered.
    #[inline(always)]
    pub(super) fn settle<V: Vectors>(&mut self, steps: Steps) {
        if steps.corner_cutting {
            self.settle_with::<V, true>(steps)
        } else {
            self.settle_with::<V, false>(steps)
        }
    }

    #[inline(always)]
    fn settle_with<V: Vectors, const CUTTING: bool>(&mut self, steps: Steps) {
        let extra = steps.diagonal_extra;
        loop {
            if self.lowered_rows.any() {
                let lowered =
                    sweep::<V, CUTTING>(&mut self.rows, &self.row_entries, &mut self.lowered_rows, extra);
                if lowered {
                    self.lowered_cols.mark_all(copy_transposed::<V>(&self.rows, &mut self.cols));
                }
            }
            if !self.lowered_cols.any() {
                if self.lowered_rows.any() {
                    continue;
                }
                return;
            }
            let lowered =
                sweep::<V, CUTTING>(&mut self.cols, &self.col_entries, &mut self.lowered_cols, extra);
            if lowered {
                self.lowered_rows.mark_all(copy_transposed::<V>(&self.cols, &mut self.rows));
            }
        }
    }

    /// What each tile around could gain, in the order of [`crate::NEIGHBORS_8`]: a lower bound on the smallest cost it
    /// could lower a cell to, or more than `UNREACHED` when nothing.
    #[inline(always)]
    pub(super) fn news(&self, steps: Steps, least_entry: f64) -> [f64; 8] {
        let extra = steps.diagonal_extra;
        let [first_row, last_row, first_col, last_col] = &self.before;
        let along = |line: &Line, beyond: &Line, before: &[f64; SIDE]| {
            gain(own_cells(line), own_cells(beyond), before, extra, least_entry)
        };
        let across = |own: f64, before: f64, beyond: f64| {
            let offer = own + extra + least_entry;
            if own < before && beyond != BLOCKED && offer < beyond { offer } else { BLOCKED }
        };
        let corner = |row: usize, col: usize, before: f64, beyond_row: usize, beyond_col: usize| {
            let own = self.rows.0[row + 1][PAD + col];
            across(own, before, self.rows.0[beyond_row][PAD + beyond_col - 1])
        };
        const LAST: usize = SIDE - 1;
        [
            along(&self.cols.0[SIDE], &self.cols.0[SIDE + 1], last_col),
            corner(LAST, LAST, last_row[LAST], SIDE + 1, SIDE + 1),
            along(&self.rows.0[SIDE], &self.rows.0[SIDE + 1], last_row),
            corner(LAST, 0, last_row[0], SIDE + 1, 0),
            along(&self.cols.0[1], &self.cols.0[0], first_col),
            corner(0, 0, first_row[0], 0, 0),
            along(&self.rows.0[1], &self.rows.0[0], first_row),
            corner(0, LAST, first_row[LAST], 0, SIDE + 1),
        ]
    }

    /// Writes the tile's costs and its outer columns back.
    #[inline(always)]
    pub(super) fn store(&self, costs: &mut [f64; CELLS], side_cols: &mut [[f64; SIDE]; 2]) {
        for (to, from) in costs.chunks_exact_mut(SIDE).zip(&self.rows.0[1..]) {
            to.copy_from_slice(own_cells(from));
        }
        *side_cols = [*own_cells(&self.cols.0[1]), *own_cells(&self.cols.0[SIDE])];
    }
}

/// Smallest cost that the lowered cells of an edge could give the cells beyond it.
#[inline(always)]
fn gain(own: &[f64; SIDE], beyond: &[f64; SIDE], before: &[f64; SIDE], extra: f64, least_entry: f64) -> f64 {
    let mut offers = [UNREACHED; SIDE + 2];
    for i in 0..SIDE {
        offers[i + 1] = if own[i] < before[i] { own[i] } else { UNREACHED };
    }
    let mut least = [BLOCKED; SIDE];
    for i in 0..SIDE {
        let offer = lesser(offers[i + 1], lesser(offers[i], offers[i + 2]) + extra) + least_entry;
        let gains = offer < beyond[i] && beyond[i] != BLOCKED;
        least[i] = if gains { offer } else { BLOCKED };
    }
    least.into_iter().fold(BLOCKED, lesser)
}

/// What changed around or in a tile.
#[derive(Clone, Copy)]
#[repr(u8)]
pub(super) enum Side {
    Below = 1,
    Above = 2,
    Left = 4,
    Right = 8,
    Inside = 16,
}

#[inline(always)]
fn own_cells(line: &Line) -> &[f64; SIDE] {
    // The length is a constant, so this never falls back.
    line[PAD..].first_chunk().unwrap_or(&[BLOCKED; SIDE])
}

/// Relaxes lines onwards, then backwards, wherever the line before was lowered. Tells whether anything was.
#[inline(always)]
fn sweep<V: Vectors, const CUTTING: bool>(
    lines: &mut Lines,
    entries: &Entries,
    lowered: &mut Lowered,
    extra: f64,
) -> bool {
    let mut any = false;
    for line in 1..=SIDE {
        if lowered.onwards >> (line - 1) & 1 != 0 {
            let (before, after) = lines.0.split_at_mut(line);
            if V::relax_line::<CUTTING>(&before[line - 1], &mut after[0], &entries.0[line - 1], extra) {
                lowered.mark(line);
                any = true;
            }
        }
    }
    lowered.onwards = 0;
    for line in (1..=SIDE).rev() {
        if lowered.backwards >> (line + 1) & 1 != 0 {
            let (before, after) = lines.0.split_at_mut(line + 1);
            if V::relax_line::<CUTTING>(&after[0], &mut before[line], &entries.0[line - 1], extra) {
                lowered.mark(line);
                any = true;
            }
        }
    }
    lowered.backwards = 0;
    any
}

/// Copies the tile's own cells into the other layout; bit `i` of the answer says that line `i` was lowered.
#[inline(always)]
fn copy_transposed<V: Vectors>(from: &Lines, to: &mut Lines) -> u64 {
    let first_own = LINE + PAD;
    V::transpose(&from.0.as_flattened()[first_own..], LINE, &mut to.0.as_flattened_mut()[first_own..], LINE)
        << 1
}
