//! One tile of a cost field: 32 x 32 cells relaxed together, in rows and in columns.
//!
//! A sweep relaxes every cell of a row from the row beside it, all cells at once; columns are rows of the transposed
//! tile. Sums are formed exactly as the slow twin forms them, one step at a time from the source, so both end in the
//! same fixed point to the bit.

/// Cells along a tile's edge.
pub(super) const SIDE: usize = 32;
/// Cells of a tile.
pub(super) const CELLS: usize = SIDE * SIDE;
/// Padding before and after a line; the innermost padding cell holds the neighboring tile's edge.
const PAD: usize = 8;
const LINE: usize = SIDE + 2 * PAD;

/// Cost of a cell that no path enters.
pub(super) const BLOCKED: f64 = f64::INFINITY;
/// Cost of an open cell not reached so far: finite, so that it differs from a blocked one, and too large to be changed
/// by adding a step.
pub(super) const UNREACHED: f64 = 1e300;

/// A row or column of cells with the neighboring tiles' cells at both ends.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Line([f64; LINE]);

/// The lines 1 to `SIDE` are the tile's own, 0 and `SIDE + 1` belong to its neighbors.
type Lines = [Line; SIDE + 2];

/// Costs of straight steps into the cells.
type Entries = [[f64; SIDE]; SIDE];

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
        self.onwards |= 1 << line;
        self.backwards |= 1 << line;
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
        let lines = [Line([BLOCKED; LINE]); SIDE + 2];
        Box::new(Self {
            rows: lines,
            cols: lines,
            row_entries: [[BLOCKED; SIDE]; SIDE],
            col_entries: [[BLOCKED; SIDE]; SIDE],
            lowered_rows: Lowered::default(),
            lowered_cols: Lowered::default(),
        })
    }

    /// Loads a tile's costs and entry costs, row by row.
    #[inline(always)]
    pub(super) fn load(&mut self, costs: &[f64; CELLS], entries: &[f64; CELLS]) {
        let (costs, _) = costs.as_chunks::<SIDE>();
        let (entries, _) = entries.as_chunks::<SIDE>();
        for (i, (cost, entry)) in costs.iter().zip(entries).enumerate() {
            self.rows[i + 1].0[PAD..PAD + SIDE].copy_from_slice(cost);
            self.row_entries[i] = *entry;
        }
        transpose_costs(&self.rows, &mut self.cols);
        transpose(&self.row_entries, &mut self.col_entries);
        self.lowered_rows = Lowered::default();
        self.lowered_cols = Lowered::default();
    }

    /// Sets the edges of the neighbors below, above, left and right; `BLOCKED` where there is none.
    #[inline(always)]
    pub(super) fn set_edges(&mut self, edges: [&[f64; SIDE]; 4], corners: [f64; 4]) {
        let [below, above, left, right] = edges;
        for i in 0..SIDE {
            self.cols[i + 1].0[PAD - 1] = below[i];
            self.cols[i + 1].0[PAD + SIDE] = above[i];
            self.rows[i + 1].0[PAD - 1] = left[i];
            self.rows[i + 1].0[PAD + SIDE] = right[i];
        }
        let whole = |edge: &[f64; SIDE], before: f64, after: f64| {
            let mut line = Line([BLOCKED; LINE]);
            line.0[PAD..PAD + SIDE].copy_from_slice(edge);
            line.0[PAD - 1] = before;
            line.0[PAD + SIDE] = after;
            line
        };
        let [below_left, below_right, above_left, above_right] = corners;
        self.rows[0] = whole(below, below_left, below_right);
        self.rows[SIDE + 1] = whole(above, above_left, above_right);
        self.cols[0] = whole(left, below_left, above_left);
        self.cols[SIDE + 1] = whole(right, below_right, above_right);
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
    pub(super) fn settle(&mut self, steps: Steps) {
        if steps.corner_cutting { self.settle_with::<true>(steps) } else { self.settle_with::<false>(steps) }
    }

    #[inline(always)]
    fn settle_with<const CUTTING: bool>(&mut self, steps: Steps) {
        let extra = steps.diagonal_extra;
        loop {
            if self.lowered_rows.any() {
                let lowered = sweep::<CUTTING>(&mut self.rows, &self.row_entries, &mut self.lowered_rows, extra);
                if lowered {
                    copy_transposed(&self.rows, &mut self.cols, &mut self.lowered_cols);
                }
            }
            if !self.lowered_cols.any() {
                if self.lowered_rows.any() {
                    continue;
                }
                return;
            }
            let lowered = sweep::<CUTTING>(&mut self.cols, &self.col_entries, &mut self.lowered_cols, extra);
            if lowered {
                copy_transposed(&self.cols, &mut self.rows, &mut self.lowered_rows);
            }
        }
    }

    /// What each tile around could gain, in the order of [`crate::NEIGHBORS_8`]: a lower bound on the smallest cost it
    /// could lower a cell to, or more than `UNREACHED` when nothing. `costs` and `side_cols` are those before.
    #[inline(always)]
    pub(super) fn news(
        &self,
        costs: &[f64; CELLS],
        side_cols: &[[f64; SIDE]; 2],
        steps: Steps,
        least_entry: f64,
    ) -> [f64; 8] {
        let extra = steps.diagonal_extra;
        let (rows_before, _) = costs.as_chunks::<SIDE>();
        let along = |line: &Line, beyond: &Line, before: &[f64; SIDE]| {
            gain(own_cells(line), own_cells(beyond), before, extra, least_entry)
        };
        let across = |own: f64, before: f64, beyond: f64| {
            let offer = own + extra + least_entry;
            if own < before && beyond != BLOCKED && offer < beyond { offer } else { BLOCKED }
        };
        let corner = |row: usize, col: usize, beyond_row: usize, beyond_col: usize| {
            let own = self.rows[row + 1].0[PAD + col];
            across(own, rows_before[row][col], self.rows[beyond_row].0[PAD + beyond_col - 1])
        };
        const LAST: usize = SIDE - 1;
        [
            along(&self.cols[SIDE], &self.cols[SIDE + 1], &side_cols[1]),
            corner(LAST, LAST, SIDE + 1, SIDE + 1),
            along(&self.rows[SIDE], &self.rows[SIDE + 1], &rows_before[LAST]),
            corner(LAST, 0, SIDE + 1, 0),
            along(&self.cols[1], &self.cols[0], &side_cols[0]),
            corner(0, 0, 0, 0),
            along(&self.rows[1], &self.rows[0], &rows_before[0]),
            corner(0, LAST, 0, SIDE + 1),
        ]
    }

    /// Writes the tile's costs and its outer columns back.
    #[inline(always)]
    pub(super) fn store(&self, costs: &mut [f64; CELLS], side_cols: &mut [[f64; SIDE]; 2]) {
        for (to, from) in costs.chunks_exact_mut(SIDE).zip(&self.rows[1..]) {
            to.copy_from_slice(own_cells(from));
        }
        *side_cols = [*own_cells(&self.cols[1]), *own_cells(&self.cols[SIDE])];
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
    line.0[PAD..].first_chunk().unwrap_or(&[BLOCKED; SIDE])
}

/// Relaxes lines onwards, then backwards, wherever the line before was lowered. Tells whether anything was.
#[inline(always)]
fn sweep<const CUTTING: bool>(lines: &mut Lines, entries: &Entries, lowered: &mut Lowered, extra: f64) -> bool {
    let mut any = false;
    for line in 1..=SIDE {
        if lowered.onwards >> (line - 1) & 1 != 0 {
            let (before, after) = lines.split_at_mut(line);
            if relax_line::<CUTTING>(&before[line - 1], &mut after[0], &entries[line - 1], extra) {
                lowered.mark(line);
                any = true;
            }
        }
    }
    lowered.onwards = 0;
    for line in (1..=SIDE).rev() {
        if lowered.backwards >> (line + 1) & 1 != 0 {
            let (before, after) = lines.split_at_mut(line + 1);
            if relax_line::<CUTTING>(&after[0], &mut before[line], &entries[line - 1], extra) {
                lowered.mark(line);
                any = true;
            }
        }
    }
    lowered.backwards = 0;
    any
}

/// Lowers the cells of a line by steps from the line beside it.
#[inline(always)]
fn relax_line<const CUTTING: bool>(from: &Line, to: &mut Line, entries: &[f64; SIDE], extra: f64) -> bool {
    // A diagonal step into a cell squeezes between the cell before it in its own line and its straight source.
    let mut diagonal = [0.0; SIDE + 2];
    for i in 0..SIDE + 2 {
        let (source, beside) = (from.0[PAD - 1 + i], to.0[PAD - 1 + i]);
        diagonal[i] = if !CUTTING && beside == BLOCKED { BLOCKED } else { source };
    }
    let mut any = 0_u64;
    for i in 0..SIDE {
        let straight = from.0[PAD + i];
        let slanted = lesser(diagonal[i], diagonal[i + 2]) + extra;
        let slanted = if !CUTTING && straight == BLOCKED { BLOCKED } else { slanted };
        let lower = lesser(straight, slanted) + entries[i];
        let present = to.0[PAD + i];
        any |= u64::from(lower < present);
        to.0[PAD + i] = lesser(lower, present);
    }
    any != 0
}

/// The smaller of two numbers that are never NaN: one instruction, where `f64::min` needs three.
#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn transpose(from: &Entries, to: &mut Entries) {
    for (i, line) in to.iter_mut().enumerate() {
        for (cell, source) in line.iter_mut().zip(from) {
            *cell = source[i];
        }
    }
}

#[inline(always)]
fn transpose_costs(from: &Lines, to: &mut Lines) {
    for i in 0..SIDE {
        for j in 0..SIDE {
            to[i + 1].0[PAD + j] = from[j + 1].0[PAD + i];
        }
    }
}

/// Copies the tile's own cells into the other layout and marks the lines that differ.
#[inline(always)]
fn copy_transposed(from: &Lines, to: &mut Lines, lowered: &mut Lowered) {
    for i in 0..SIDE {
        let mut line = [0.0; SIDE];
        for j in 0..SIDE {
            line[j] = from[j + 1].0[PAD + i];
        }
        let present = &mut to[i + 1].0[PAD..PAD + SIDE];
        let mut any = 0_u64;
        for j in 0..SIDE {
            any |= u64::from(line[j] < present[j]);
            present[j] = line[j];
        }
        if any != 0 {
            lowered.mark(i + 1);
        }
    }
}
