//! Branch and bound over the poses of a window.

use super::fit_table::{FitTable, Level};
use super::window::{Apart, SearchWindow};
use crate::simd::{self, Kernel, Vectors};
use rumbo_core::frames::{Point2, Pose2};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The pose that fits best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrelativeMatch {
    /// The base in the grid's frame.
    pub grid_from_base: Pose2,
    /// Mean value of the cells that the points lie in: 1 is the best there can be.
    pub score: f64,
}

/// The window is too large for a map that says so little.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("gave up after {nodes} nodes; a smaller window or a higher least score is needed")]
pub struct SearchGaveUp {
    /// How many were looked at.
    pub nodes: usize,
}

/// Points side by side.
const LANES: usize = 16;
/// A coordinate off every grid that can still be added to.
const FAR_AWAY: i32 = 1 << 28;

/// Cells that the points lie in at one turn, padded to whole vectors.
#[derive(Debug, Clone, Default)]
struct TurnedPoints {
    x: Vec<i32>,
    y: Vec<i32>,
}

/// Poses that a square of offsets holds, by what they cost at least: cheapest, finest and nearest to the guess first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Node {
    cost: u32,
    level: u32,
    turn: u32,
    off_center: i64,
    cells: [i32; 2],
}

/// Searches, and keeps its memory between them.
#[derive(Debug, Clone, Default)]
pub struct CorrelativeSearch {
    turned: Vec<TurnedPoints>,
    open: BinaryHeap<Reverse<Node>>,
    squares: Vec<[i32; 2]>,
    costs: Vec<u32>,
    n_points: usize,
    n_nodes: usize,
}

impl CorrelativeSearch {
    /// The pose of the window where the points (seen from the base, meters) fit best, if any fits well enough; poses that
    /// `apart` leaves out are no answer.
    ///
    /// # Errors
    /// When the window's number of nodes is used up.
    pub fn best(
        &mut self,
        table: &FitTable,
        points: &[Point2],
        window: &SearchWindow,
        apart: Option<&Apart>,
    ) -> Result<Option<CorrelativeMatch>, SearchGaveUp> {
        self.open.clear();
        self.n_nodes = 0;
        if points.is_empty() || !rumbo_core::frames::is_finite2(&window.grid_from_base) {
            return Ok(None);
        }
        let turns_rad = window.turns_rad();
        self.turn_points(table, points, window, &turns_rad);
        let most_cost = ((1.0 - window.least_score).clamp(0.0, 1.0) * 255.0 * points.len() as f64) as u32;
        let reach = window.reach_cells(table.resolution_m());
        let top = top_level(table, reach);
        self.open_all(table, top, reach, most_cost);
        while let Some(Reverse(node)) = self.open.pop() {
            if self.n_nodes > window.most_nodes {
                return Err(SearchGaveUp { nodes: self.n_nodes });
            }
            if node.level > 0 {
                self.open_parts(table, &node, reach, most_cost);
                continue;
            }
            let turn_rad = turns_rad.get(node.turn as usize).copied().unwrap_or_default();
            let grid_from_base = window.pose(node.cells, turn_rad, table.resolution_m());
            if apart.is_some_and(|apart| apart.excludes(&grid_from_base)) {
                continue;
            }
            let score = 1.0 - f64::from(node.cost) / (255.0 * points.len() as f64);
            return Ok(Some(CorrelativeMatch { grid_from_base, score }));
        }
        Ok(None)
    }

    /// How many nodes the last search looked at.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    fn turn_points(&mut self, table: &FitTable, points: &[Point2], window: &SearchWindow, turns_rad: &[f64]) {
        self.n_points = points.len();
        self.turned.resize_with(turns_rad.len(), TurnedPoints::default);
        let n_padded = points.len().next_multiple_of(LANES);
        for (turned, turn_rad) in self.turned.iter_mut().zip(turns_rad) {
            let pose = window.pose([0, 0], *turn_rad, table.resolution_m());
            turned.x.clear();
            turned.y.clear();
            for point in points {
                let [x, y] = cell_of(&pose, point, table.resolution_m());
                turned.x.push(x);
                turned.y.push(y);
            }
            turned.x.resize(n_padded, FAR_AWAY);
            turned.y.resize(n_padded, FAR_AWAY);
        }
    }

    /// All the squares that cover the window.
    fn open_all(&mut self, table: &FitTable, top: usize, reach: i32, most_cost: u32) {
        let side = 1 << top;
        let starts = || (-reach..=reach).step_by(side);
        self.squares.clear();
        self.squares.extend(starts().flat_map(|y| starts().map(move |x| [x, y])));
        for turn in 0..self.turned.len() {
            self.push_squares(table, top, turn, most_cost);
        }
    }

    /// The four squares that a square consists of.
    fn open_parts(&mut self, table: &FitTable, node: &Node, reach: i32, most_cost: u32) {
        let level = node.level as usize - 1;
        let side = 1 << level;
        let [x, y] = node.cells;
        let parts = [[x, y], [x + side, y], [x, y + side], [x + side, y + side]];
        self.squares.clear();
        self.squares.extend(parts.into_iter().filter(|part| part.iter().all(|start| *start <= reach)));
        self.push_squares(table, level, node.turn as usize, most_cost);
    }

    fn push_squares(&mut self, table: &FitTable, level: usize, turn: usize, most_cost: u32) {
        let (Some(squares), Some(points)) = (table.levels().get(level), self.turned.get(turn)) else {
            return;
        };
        self.costs.clear();
        simd::widest(CostsOf { level: squares, points, at: &self.squares, costs: &mut self.costs });
        self.n_nodes += self.squares.len();
        let n_padding = (points.x.len() - self.n_points) as u32;
        let half = 1 << level >> 1;
        for (cells, cost) in self.squares.iter().zip(&self.costs) {
            let cost = cost - n_padding * u32::from(u8::MAX);
            if cost <= most_cost {
                let off_center = cells.iter().map(|start| i64::from(start + half).pow(2)).sum();
                let node = Node { cost, level: level as u32, turn: turn as u32, off_center, cells: *cells };
                self.open.push(Reverse(node));
            }
        }
    }
}

/// The cell that a point of a scan lies in.
pub(super) fn cell_of(grid_from_base: &Pose2, point: &Point2, resolution_m: f64) -> [i32; 2] {
    let far = f64::from(FAR_AWAY);
    let in_grid = grid_from_base * point / resolution_m;
    [in_grid.x, in_grid.y].map(|v| if v.is_finite() { v.floor().clamp(-far, far) as i32 } else { FAR_AWAY })
}

/// Squares about as large as the window are few and still say something.
fn top_level(table: &FitTable, reach: i32) -> usize {
    let window_cells = 2 * reach + 1;
    let wanted = (0..).take_while(|level| (1 << level) < window_cells).count();
    wanted.saturating_sub(2).min(table.levels().len().saturating_sub(1))
}

struct CostsOf<'a> {
    level: &'a Level,
    points: &'a TurnedPoints,
    at: &'a [[i32; 2]],
    costs: &'a mut Vec<u32>,
}

impl Kernel for CostsOf<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Self { level, points, at, costs } = self;
        let (last_col, last_row) = (level.columns - 1, level.rows - 1);
        let (xs, _) = points.x.as_chunks::<LANES>();
        let (ys, _) = points.y.as_chunks::<LANES>();
        for [x, y] in at {
            let (x, y) = (x + level.side, y + level.side);
            let mut total = 0;
            for (xs, ys) in xs.iter().zip(ys) {
                let mut places = [0; LANES];
                for lane in 0..LANES {
                    let col = (xs[lane] + x).clamp(0, last_col);
                    let row = (ys[lane] + y).clamp(0, last_row);
                    places[lane] = (row * level.columns + col) as u32;
                }
                total += V::sum_of(&level.costs, &places);
            }
            costs.push(total);
        }
    }
}
