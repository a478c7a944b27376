//! The slow twin of the cost field: Dijkstra's algorithm with a binary heap, one cell at a time.

use super::StepRule;
use crate::{GridSize, NEIGHBORS_8};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Costs of all cells to `source`, row by row; infinite where there is no path.
pub fn cost_field(size: GridSize, entry_costs: &[f64], rule: StepRule, source: usize) -> Vec<f64> {
    let is_open = |cell: usize| entry_costs[cell] > 0.0 && entry_costs[cell] < f64::INFINITY;
    let mut costs = vec![f64::INFINITY; size.n_cells()];
    if !is_open(source) {
        return costs;
    }
    costs[source] = 0.0;
    // Bits of numbers that are not negative sort as the numbers do.
    let mut queue = BinaryHeap::from([Reverse((0.0_f64.to_bits(), source))]);
    while let Some(Reverse((bits, cell))) = queue.pop() {
        if bits != costs[cell].to_bits() {
            continue;
        }
        for (dx, dy) in NEIGHBORS_8 {
            let Some(next) = size.neighbor(cell, dx, dy).filter(|&n| is_open(n)) else { continue };
            let is_diagonal = dx != 0 && dy != 0;
            let beside = [size.neighbor(cell, dx, 0), size.neighbor(cell, 0, dy)];
            if is_diagonal && !rule.corner_cutting && !beside.into_iter().flatten().all(is_open) {
                continue;
            }
            let from = if is_diagonal { costs[cell] + rule.diagonal_extra() } else { costs[cell] };
            let cost = from + entry_costs[next];
            if cost < costs[next] {
                costs[next] = cost;
                queue.push(Reverse((cost.to_bits(), next)));
            }
        }
    }
    costs
}
