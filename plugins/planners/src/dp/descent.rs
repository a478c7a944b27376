//! The path down a cost field: Hernández Alamilla (2005), section 3.2.3.

use rumbo_kit::NEIGHBORS_8;
use rumbo_kit::cost_field::{CostField, StepRule};

/// Costs that agree within this are a tie.
const SAME_COST: f64 = 1e-9;

/// The cells from `start` to `goal`, each time the neighbor with the lowest cost; `None` when the start has no finite
/// cost. Among equals the previous direction wins, then the smallest turn, then the cell that comes first from the top
/// left corner.
pub fn descend(field: &CostField, rule: StepRule, start: usize, goal: usize) -> Option<Vec<usize>> {
    if !field.cost(start).is_finite() {
        return None;
    }
    let mut path = vec![start];
    let (mut cell, mut heading) = (start, None);
    while cell != goal {
        let (direction, next) = lowest_neighbor(field, rule, cell, heading)?;
        // A reached cell always has a cheaper neighbor; without one the field is not a field.
        if field.cost(next) >= field.cost(cell) {
            return None;
        }
        path.push(next);
        cell = next;
        heading = Some(direction);
    }
    Some(path)
}

fn lowest_neighbor(
    field: &CostField,
    rule: StepRule,
    cell: usize,
    heading: Option<usize>,
) -> Option<(usize, usize)> {
    let neighbors = || {
        (0..NEIGHBORS_8.len()).filter_map(move |direction| {
            let next = field.neighbor(cell, direction, rule.corner_cutting)?;
            Some((direction, next))
        })
    };
    let lowest = neighbors().map(|(_, next)| field.cost(next)).fold(f64::INFINITY, f64::min);
    let turn = |direction: usize| {
        let eighths = heading.map_or(0, |heading| direction.abs_diff(heading));
        eighths.min(8 - eighths)
    };
    let (width, _) = (field.size().width, ());
    let from_top_left = |next: usize| (std::cmp::Reverse(next / width), next % width);
    neighbors()
        .filter(|(_, next)| field.cost(*next) <= lowest + SAME_COST)
        .min_by_key(|(direction, next)| (turn(*direction), from_top_left(*next)))
}
