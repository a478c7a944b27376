//! Shortest paths over eight neighbors with a clearance, in cells.
//!
//! A* (Hart, Nilsson and Raphael, 1968) with the octile distance as its estimate, on tiles instead of single cells (as
//! in Yap, Burch, Holte and Schaeffer, "Block A*", 2011): the queue holds tiles, ordered by the cheapest news at their
//! edge plus the estimate, and a tile is settled as a whole. The path is a shortest one.

use rumbo_kit::cost_field::{CostField, StepRule, Until};
use rumbo_kit::distance_field::squared_distance_field_into;
use rumbo_kit::proximity::CellKind;
use rumbo_kit::{GridSize, NEIGHBORS_8};
use std::f64::consts::FRAC_1_SQRT_2;

/// A shortest path.
#[derive(Clone, Debug, PartialEq)]
pub struct GridPath {
    /// The cells from start to goal.
    pub cells: Vec<usize>,
    /// Length in cells.
    pub length: f64,
}

/// Why there is no path.
#[derive(Clone, Debug, PartialEq)]
pub enum AStarFault {
    /// The goal keeps only this distance, in cells.
    GoalTooClose(f64),
    /// No way leads from start to goal.
    Unreachable,
    /// The caller asked to stop.
    GivenUp,
}

/// The planner with its memory.
#[derive(Default)]
pub struct GridAStar {
    obstacles: Vec<u8>,
    squared_distances: Vec<u32>,
    entry_costs: Vec<f64>,
    known: Vec<CellKind>,
    size: Option<GridSize>,
    field: CostField,
}

/// Around a robot that is too near to an obstacle, how far beyond the clearance cells are open that are no nearer.
const ESCAPE_MARGIN: f64 = 2.0;

impl GridAStar {
    /// A shortest path that keeps `clearance` cells between the centers of its cells and the edges of obstacles. A
    /// robot that starts nearer may leave as long as it does not come any nearer.
    pub fn plan(
        &mut self,
        size: GridSize,
        kinds: &[CellKind],
        clearance: f64,
        start: usize,
        goal: usize,
        give_up: impl FnMut() -> bool,
    ) -> Result<GridPath, AStarFault> {
        self.measure(size, kinds, clearance);
        if clearance > 0.0 && self.distance(goal) < clearance {
            return Err(AStarFault::GoalTooClose(self.distance(goal).max(0.0)));
        }
        self.open_cells(kinds, clearance, start);
        self.field.set_entry_costs(size, &self.entry_costs, StepRule::default());
        self.field.grow(goal, Until::Query(start), give_up).map_err(|_| AStarFault::GivenUp)?;
        let length = self.field.cost(start);
        let cells = self.field.cheapest_path(start).ok_or(AStarFault::Unreachable)?;
        Ok(GridPath { cells, length })
    }

    /// Whether the last plan could enter a cell.
    pub fn is_open(&self, cell: usize) -> bool {
        self.entry_costs.get(cell).is_some_and(|cost| cost.is_finite())
    }

    /// The cost field of the last plan.
    pub fn field(&self) -> &CostField {
        &self.field
    }

    /// Measures the distances to obstacles, unless nothing has changed.
    fn measure(&mut self, size: GridSize, kinds: &[CellKind], clearance: f64) {
        if clearance <= 0.0 || (self.size == Some(size) && self.known == kinds) {
            return;
        }
        self.size = Some(size);
        self.known.clear();
        self.known.extend_from_slice(kinds);
        self.obstacles.clear();
        self.obstacles.extend(kinds.iter().map(|kind| u8::from(*kind == CellKind::Obstacle)));
        self.squared_distances.resize(size.n_cells(), 0);
        squared_distance_field_into(size, &self.obstacles, &mut self.squared_distances);
    }

    /// At most the distance from the center of a cell to the edge of the nearest obstacle: to its center, less half the
    /// diagonal of a cell.
    fn distance(&self, cell: usize) -> f64 {
        f64::from(self.squared_distances[cell]).sqrt() - FRAC_1_SQRT_2
    }

    fn open_cells(&mut self, kinds: &[CellKind], clearance: f64, start: usize) {
        self.entry_costs.clear();
        let open = |is_open: bool| if is_open { 1.0 } else { f64::INFINITY };
        if clearance <= 0.0 {
            self.entry_costs.extend(kinds.iter().map(|kind| open(*kind == CellKind::Free)));
            return;
        }
        let least = (clearance + FRAC_1_SQRT_2).powi(2);
        let keeps = |(kind, squared): (&CellKind, &u32)| {
            open(*kind == CellKind::Free && f64::from(*squared) >= least)
        };
        self.entry_costs.extend(kinds.iter().zip(&self.squared_distances).map(keeps));
        if self.entry_costs[start].is_infinite() {
            self.open_around(kinds, clearance + ESCAPE_MARGIN, start);
        }
    }

    /// Opens the cells around the start that can be reached within the radius and are no nearer to an obstacle.
    fn open_around(&mut self, kinds: &[CellKind], radius: f64, start: usize) {
        let Some(size) = self.size else { return };
        let (col, row) = size.col_row(start);
        let is_within = |cell: usize| {
            let (c, r) = size.col_row(cell);
            (c as f64 - col as f64).hypot(r as f64 - row as f64) <= radius
        };
        let least = self.squared_distances[start];
        let mut reached = vec![start];
        self.entry_costs[start] = 1.0;
        while let Some(cell) = reached.pop() {
            for (dx, dy) in NEIGHBORS_8 {
                let Some(next) = size.neighbor(cell, dx, dy) else { continue };
                let opens = kinds[next] == CellKind::Free && self.squared_distances[next] >= least;
                if opens && self.entry_costs[next].is_infinite() && is_within(next) {
                    self.entry_costs[next] = 1.0;
                    reached.push(next);
                }
            }
        }
    }
}
