//! What keeps a goal from being reached, and the least that would have to change.

use super::cost_map::keeps;
use super::descent::descend;
use rumbo_kit::cost_field::{CostField, GivenUp, StepRule, Until};
use rumbo_kit::proximity::{CellKind, ProximityMap};

/// The cheapest hindrance on the way.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstruction {
    /// A way exists, but at its narrowest cell it passes nearer to an obstacle than allowed.
    Narrow {
        /// The cell.
        cell: usize,
        /// Its distance to the nearest obstacle, in cells.
        distance: f64,
    },
    /// The way with the fewest closed cells leads through these.
    Closed {
        /// The closed cells, in the order from start to goal.
        cells: Vec<usize>,
    },
}

/// A closed cell weighs more than any detour through open ones.
const CLOSED_CELL: f64 = 1e9;
/// What stands in the way for a time is taken away more easily than a wall.
const REMOVABLE_CELL: f64 = 1e6;
/// So does a narrow one, but less than a closed one; the narrower, the heavier.
const NARROW_CELL: f64 = 1e3;

/// Finds the way that breaks the rules least and says what is wrong with it. `ends` are start and goal; closed cells that
/// are removable were found on the way.
pub fn find_obstruction(
    proximity: &ProximityMap,
    field: &mut CostField,
    minimum: f64,
    steps: StepRule,
    ends: [usize; 2],
    is_removable: &dyn Fn(usize) -> bool,
    give_up: &mut dyn FnMut() -> bool,
) -> Result<Option<Obstruction>, GivenUp> {
    let [start, goal] = ends;
    let entry = |(cell, (kind, distance)): (usize, (&CellKind, &f64))| match kind {
        CellKind::Free if keeps(*distance, minimum) => 1.0,
        CellKind::Free => NARROW_CELL * (1.0 + minimum - distance),
        CellKind::Obstacle | CellKind::Closed if is_removable(cell) => REMOVABLE_CELL,
        CellKind::Obstacle | CellKind::Closed => CLOSED_CELL,
    };
    let entries: Vec<f64> =
        proximity.kinds().iter().zip(proximity.distances()).enumerate().map(entry).collect();
    field.set_entry_costs(proximity.size(), &entries, steps);
    field.grow(goal, Until::Settled(start), give_up)?;
    let Some(way) = descend(field, steps, start, goal) else { return Ok(None) };
    let is_closed = |cell: &usize| proximity.kinds()[*cell] != CellKind::Free;
    let closed: Vec<usize> = way.iter().copied().filter(is_closed).collect();
    if !closed.is_empty() {
        return Ok(Some(Obstruction::Closed { cells: closed }));
    }
    // The robot itself may stand in the forbidden band; that is not what closes the way.
    let narrow = way.iter().skip(1).map(|&cell| (proximity.distances()[cell], cell));
    let narrowest =
        narrow.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(distance, _)| !keeps(*distance, minimum));
    Ok(narrowest.map(|(distance, cell)| Obstruction::Narrow { cell, distance }))
}
