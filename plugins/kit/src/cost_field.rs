//! Exact cost-to-goal field of a grid whose cells cost different amounts to be in.
//!
//! Every cell holds the cost of the cheapest path to the source over eight neighbors. A path pays, for each step, the
//! entry cost of the cell that is farther from the source (the one the robot is in when it makes the step), and a
//! diagonal step pays `diagonal_step - 1` on top. This is Dijkstra's problem (1959); the answer is found tile by tile:
//! a queue of tiles ordered by the cheapest news at their edge, each settled on its own in vectors.
//!
//! "Exact" means equal to the bit to Dijkstra's algorithm with a heap in `f64` ([`slow::cost_field`]): every cost is
//! the smallest over all neighbors of `(cost of neighbor [+ extra if diagonal]) + entry`, rounded as `f64` rounds, and
//! since both sums grow with their terms this has one solution, whatever the order of work.

pub mod slow;
mod tile;

use crate::{GridSize, simd};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tile::{BLOCKED, CELLS, SIDE, Side, Steps, TileSolver, UNREACHED};

/// How steps between neighbors are priced and where they may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRule {
    /// Length of a diagonal step where a straight one is 1, at least 1.
    pub diagonal_step: f64,
    /// Diagonal steps may pass a blocked cell on one or both sides.
    pub corner_cutting: bool,
}

impl Default for StepRule {
    fn default() -> Self {
        Self { diagonal_step: std::f64::consts::SQRT_2, corner_cutting: false }
    }
}

impl StepRule {
    /// What a diagonal step costs more than a straight one.
    pub fn diagonal_extra(&self) -> f64 {
        self.diagonal_step - 1.0
    }
}

/// The caller asked to stop before the field was finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GivenUp;

/// When a field may stop growing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// Every cell that can be reached has its cost.
    Everywhere,
    /// The cell, and every cell that costs less, has its cost; others may hold too much.
    Settled(usize),
    /// The cell has its cost, and so has every cell on a cheapest path from it; others may hold too much.
    Query(usize),
}

/// A cost-to-goal field with its working memory, which is kept from one field to the next.
pub struct CostField {
    size: GridSize,
    n_tile_cols: usize,
    n_tile_rows: usize,
    steps: Steps,
    least_entry: f64,
    entries: Vec<[f64; CELLS]>,
    costs: Vec<[f64; CELLS]>,
    /// Left and right column of every tile.
    edges: Vec<[[f64; SIDE]; 2]>,
    tiles: Vec<TileState>,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    solver: Box<TileSolver>,
    n_settled_tiles: usize,
}

#[derive(Clone, Copy)]
struct TileState {
    /// Smallest announced news, `UNREACHED` when there are none.
    key: f64,
    /// Where the news came from.
    sides: u8,
    /// `costs` belong to the present field.
    is_current: bool,
}

const AT_REST: TileState = TileState { key: UNREACHED, sides: 0, is_current: false };

impl Default for CostField {
    fn default() -> Self {
        Self::new()
    }
}

impl CostField {
    /// An empty field.
    pub fn new() -> Self {
        Self {
            size: GridSize::new(0, 0),
            n_tile_cols: 0,
            n_tile_rows: 0,
            steps: Steps { diagonal_extra: 0.0, corner_cutting: false },
            least_entry: 0.0,
            entries: Vec::new(),
            costs: Vec::new(),
            edges: Vec::new(),
            tiles: Vec::new(),
            queue: BinaryHeap::new(),
            solver: TileSolver::new(),
            n_settled_tiles: 0,
        }
    }

    /// Sets what it costs to be in each cell: above zero, or infinite where no path may go. Anything else is taken for
    /// infinite. The field is empty afterwards.
    pub fn set_entry_costs(&mut self, size: GridSize, entry_costs: &[f64], rule: StepRule) {
        assert_eq!(entry_costs.len(), size.n_cells(), "one entry cost per cell");
        self.size = size;
        self.n_tile_cols = size.width.div_ceil(SIDE);
        self.n_tile_rows = size.height.div_ceil(SIDE);
        self.steps = Steps { diagonal_extra: rule.diagonal_extra(), corner_cutting: rule.corner_cutting };
        let n_tiles = self.n_tile_cols * self.n_tile_rows;
        self.entries.resize(n_tiles, [BLOCKED; CELLS]);
        self.costs.resize(n_tiles, [BLOCKED; CELLS]);
        self.edges.resize(n_tiles, [[BLOCKED; SIDE]; 2]);
        self.tiles.resize(n_tiles, AT_REST);
        self.least_entry = simd::widest(CopyIntoTiles { size, entry_costs, tiles: &mut self.entries });
        self.clear();
    }

    fn clear(&mut self) {
        self.tiles.fill(AT_REST);
        self.queue.clear();
        self.n_settled_tiles = 0;
    }

    /// Size of the grid.
    pub fn size(&self) -> GridSize {
        self.size
    }

    /// Smallest finite entry cost of the map, infinite when no cell is open.
    pub fn least_entry(&self) -> f64 {
        self.least_entry
    }

    /// How often a tile was settled for the present field: a measure of the work done.
    pub fn n_settled_tiles(&self) -> usize {
        self.n_settled_tiles
    }

    /// Cost from a cell to the source, infinite where there is no path.
    pub fn cost(&self, cell: usize) -> f64 {
        let (tile, inside) = self.place(cell);
        let cost = if self.tiles[tile].is_current { self.costs[tile][inside] } else { UNREACHED };
        if cost < UNREACHED { cost } else { f64::INFINITY }
    }

    /// Entry cost of a cell.
    pub fn entry_cost(&self, cell: usize) -> f64 {
        let (tile, inside) = self.place(cell);
        self.entries[tile][inside]
    }

    /// The neighbor in one of the directions of [`crate::NEIGHBORS_8`], if a step may lead there.
    pub fn neighbor(&self, cell: usize, direction: usize, corner_cutting: bool) -> Option<usize> {
        let (dx, dy) = *crate::NEIGHBORS_8.get(direction)?;
        let is_open = |cell: &usize| self.entry_cost(*cell) < BLOCKED;
        let next = self.size.neighbor(cell, dx, dy).filter(is_open)?;
        let is_clear = dx == 0
            || dy == 0
            || corner_cutting
            || [(dx, 0), (0, dy)]
                .iter()
                .all(|&(x, y)| self.size.neighbor(cell, x, y).is_some_and(|c| is_open(&c)));
        is_clear.then_some(next)
    }

    /// The cells of a cheapest path from `cell` to the source, both included; `None` when there is no path or the
    /// growth stopped before the cell was settled.
    pub fn cheapest_path(&self, cell: usize) -> Option<Vec<usize>> {
        let mut path = vec![cell];
        let mut cell = cell;
        while self.cost(cell) > 0.0 {
            let offer = |direction: usize| {
                let next = self.neighbor(cell, direction, self.steps.corner_cutting)?;
                // The same sums as in the field, so that the neighbor the cost came from is found to the bit.
                let extra = if direction % 2 == 1 { self.steps.diagonal_extra } else { 0.0 };
                Some((self.cost(next) + extra + self.entry_cost(cell), next))
            };
            let offers = (0..crate::NEIGHBORS_8.len()).filter_map(offer);
            let (cost, next) = offers.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if !cost.is_finite() || self.cost(next) >= self.cost(cell) {
                return None;
            }
            path.push(next);
            cell = next;
        }
        Some(path)
    }

    /// All costs, row by row.
    pub fn to_vec(&self) -> Vec<f64> {
        (0..self.size.n_cells()).map(|cell| self.cost(cell)).collect()
    }

    fn place(&self, cell: usize) -> (usize, usize) {
        let (col, row) = self.size.col_row(cell);
        (row / SIDE * self.n_tile_cols + col / SIDE, row % SIDE * SIDE + col % SIDE)
    }

    /// Forgets the field and grows a new one from `source`, whose own entry cost is never paid. A source that is
    /// blocked reaches nothing.
    ///
    /// `give_up` is asked before each tile.
    pub fn grow(
        &mut self,
        source: usize,
        until: Until,
        mut give_up: impl FnMut() -> bool,
    ) -> Result<(), GivenUp> {
        self.clear();
        let (tile, inside) = self.place(source);
        if self.entries[tile][inside] == BLOCKED {
            return Ok(());
        }
        self.costs[tile] = self.entries[tile].map(before_any_path);
        self.costs[tile][inside] = 0.0;
        self.edges[tile] = side_columns(&self.costs[tile]);
        self.tiles[tile].is_current = true;
        let bound = Bound::new(self, until);
        for (neighbor, side) in self.around(tile).into_iter().zip(SEEN_FROM) {
            if let Some(neighbor) = neighbor {
                self.announce(neighbor, side, 0.0, &bound);
            }
        }
        self.announce(tile, Side::Inside as u8, 0.0, &bound);
        while let Some(Reverse((key_bits, tile))) = self.queue.pop() {
            let tile = tile as usize;
            if f64::from_bits(key_bits) >= bound.limit(self) {
                break;
            }
            if bound.ordered(tile, self.tiles[tile].key).to_bits() != key_bits {
                continue;
            }
            if give_up() {
                return Err(GivenUp);
            }
            self.settle(tile, &bound);
        }
        Ok(())
    }

    /// The eight tiles around a tile, in the order of [`crate::NEIGHBORS_8`].
    fn around(&self, tile: usize) -> [Option<usize>; 8] {
        let grid = GridSize::new(self.n_tile_cols, self.n_tile_rows);
        crate::NEIGHBORS_8.map(|(dx, dy)| grid.neighbor(tile, dx, dy))
    }

    fn announce(&mut self, tile: usize, side: u8, key: f64, bound: &Bound) {
        let state = &mut self.tiles[tile];
        state.sides |= side;
        if key < state.key {
            state.key = key;
            // Bits of numbers that are not negative sort as the numbers do.
            self.queue.push(Reverse((bound.ordered(tile, key).to_bits(), tile as u32)));
        }
    }

    /// Settles a tile and tells the tiles around it what they could gain.
    fn settle(&mut self, tile: usize, bound: &Bound) {
        self.n_settled_tiles += 1;
        let around = self.around(tile);
        let sides = std::mem::take(&mut self.tiles[tile].sides);
        self.tiles[tile].key = UNREACHED;
        let news = simd::widest(SettleOne { field: self, tile, around, sides });
        self.tiles[tile].is_current = true;
        for ((neighbor, side), key) in around.into_iter().zip(SEEN_FROM).zip(news) {
            if let Some(neighbor) = neighbor
                && key < UNREACHED
            {
                self.announce(neighbor, side, key, bound);
            }
        }
    }
}

/// From which side a neighbor, in the order of [`crate::NEIGHBORS_8`], sees the tile in the middle.
const SEEN_FROM: [u8; 8] = [
    Side::Left as u8,
    Side::Below as u8,
    Side::Below as u8,
    Side::Below as u8,
    Side::Right as u8,
    Side::Above as u8,
    Side::Above as u8,
    Side::Above as u8,
];

/// Settles one tile against its surroundings; returns what each tile around could gain.
struct SettleOne<'a> {
    field: &'a mut CostField,
    tile: usize,
    around: [Option<usize>; 8],
    sides: u8,
}

impl simd::Kernel for SettleOne<'_> {
    type Output = [f64; 8];

    #[inline(always)]
    fn run<V: simd::Vectors>(self) -> [f64; 8] {
        let Self { field, tile, around, sides } = self;
        let CostField { solver, entries, costs, edges, tiles, steps, least_entry, .. } = field;
        if tiles[tile].is_current {
            solver.load::<V>(&costs[tile], &entries[tile]);
        } else {
            solver.load_fresh::<V>(&entries[tile]);
        }
        let row = |tile: Option<usize>, row: usize| match tile {
            None => [BLOCKED; SIDE],
            Some(t) if tiles[t].is_current => line_of(&costs[t], row),
            Some(t) => line_of(&entries[t], row).map(before_any_path),
        };
        let col = |tile: Option<usize>, side: usize| match tile {
            None => [BLOCKED; SIDE],
            Some(t) if tiles[t].is_current => edges[t][side],
            Some(t) => side_columns(&entries[t])[side].map(before_any_path),
        };
        let corner = |tile: Option<usize>, cell: usize| match tile {
            None => BLOCKED,
            Some(t) if tiles[t].is_current => costs[t][cell],
            Some(t) => before_any_path(entries[t][cell]),
        };
        let [right, above_right, above, above_left, left, below_left, below, below_right] = around;
        solver.set_edges(
            [&row(below, SIDE - 1), &row(above, 0), &col(left, 1), &col(right, 0)],
            [
                corner(below_left, CELLS - 1),
                corner(below_right, CELLS - SIDE),
                corner(above_left, SIDE - 1),
                corner(above_right, 0),
            ],
        );
        solver.mark_sides(sides);
        solver.settle::<V>(*steps);
        solver.store(&mut costs[tile], &mut edges[tile]);
        solver.news(*steps, *least_entry)
    }
}

/// What a cell of this entry cost holds before any path has reached it.
#[inline(always)]
fn before_any_path(entry: f64) -> f64 {
    if entry == BLOCKED { BLOCKED } else { UNREACHED }
}

/// One line of a tile.
#[inline(always)]
fn line_of(cells: &[f64; CELLS], line: usize) -> [f64; SIDE] {
    std::array::from_fn(|i| cells[line * SIDE + i])
}

#[inline(always)]
fn side_columns(costs: &[f64; CELLS]) -> [[f64; SIDE]; 2] {
    [std::array::from_fn(|row| costs[row * SIDE]), std::array::from_fn(|row| costs[row * SIDE + SIDE - 1])]
}

/// Sorts entry costs into tiles and returns the least; what is not above zero blocks, as does what lies outside.
struct CopyIntoTiles<'a> {
    size: GridSize,
    entry_costs: &'a [f64],
    tiles: &'a mut [[f64; CELLS]],
}

impl simd::Kernel for CopyIntoTiles<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<V: simd::Vectors>(self) -> f64 {
        let Self { size, entry_costs, tiles } = self;
        let n_tile_cols = size.width.div_ceil(SIDE);
        let mut least = BLOCKED;
        for (tile, cells) in tiles.iter_mut().enumerate() {
            let (col, row) = (tile % n_tile_cols * SIDE, tile / n_tile_cols * SIDE);
            let n_cols = SIDE.min(size.width - col);
            for (r, line) in cells.chunks_exact_mut(SIDE).enumerate() {
                if row + r >= size.height {
                    line.fill(BLOCKED);
                    continue;
                }
                line[n_cols..].fill(BLOCKED);
                let from = &entry_costs[size.index(col, row + r)..][..n_cols];
                for (cell, &entry) in line.iter_mut().zip(from) {
                    *cell = if entry > 0.0 { entry } else { BLOCKED };
                    least = if *cell < least { *cell } else { least };
                }
            }
        }
        least
    }
}

/// What ends the growth, and in which order tiles are taken.
struct Bound {
    /// Tile and place inside of the cell asked about.
    cell: Option<(usize, usize)>,
    /// Column and row of the cell that the order leads to.
    towards: Option<(usize, usize)>,
    n_tile_cols: usize,
    straight: f64,
    diagonal: f64,
}

/// Keeps an estimate below the true cost where both are rounded.
const ROUNDED_DOWN: f64 = 1.0 - 1e-9;

impl Bound {
    fn new(field: &CostField, until: Until) -> Self {
        let cell = match until {
            Until::Everywhere => None,
            Until::Settled(cell) | Until::Query(cell) => Some(cell),
        };
        let towards = matches!(until, Until::Query(_)).then_some(cell).flatten();
        let straight = field.least_entry;
        Self {
            cell: cell.map(|cell| field.place(cell)),
            towards: towards.map(|cell| field.size.col_row(cell)),
            n_tile_cols: field.n_tile_cols,
            straight,
            diagonal: (straight + field.steps.diagonal_extra).min(2.0 * straight),
        }
    }

    /// No news at or above this can change the answer.
    fn limit(&self, field: &CostField) -> f64 {
        let found = self.cell.filter(|(tile, _)| field.tiles[*tile].is_current);
        found.map_or(UNREACHED, |(tile, inside)| field.costs[tile][inside])
    }

    /// A key plus the least cost of going on from the tile: octile distance to the tile's box.
    fn ordered(&self, tile: usize, key: f64) -> f64 {
        let Some((col, row)) = self.towards else { return key };
        let gap = |at: usize, tile: usize| {
            let first = tile * SIDE;
            first.saturating_sub(at).max(at.saturating_sub(first + SIDE - 1))
        };
        let (dx, dy) = (gap(col, tile % self.n_tile_cols), gap(row, tile / self.n_tile_cols));
        let (more, less) = (dx.max(dy) as f64, dx.min(dy) as f64);
        key + ((more - less) * self.straight + less * self.diagonal) * ROUNDED_DOWN
    }
}

#[cfg(test)]
mod tests;
