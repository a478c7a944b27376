//! What it costs to be in a cell: Hernández Alamilla (2005), section 3.2.3 and algorithm 3.2.

use rumbo_kit::GridSize;
use rumbo_kit::proximity::{CellKind, ProximityMap};

/// Distances that agree within this many cells are the same: lengths in meters divided by a cell size are rounded.
pub const SAME_DISTANCE: f64 = 1e-9;

/// The distances that shape a plan, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearances {
    /// `D_pref`: nearer than this to an obstacle, a cell costs more.
    pub preferred: f64,
    /// `d_min`: nearer than this to an obstacle, a cell is closed.
    pub minimum: f64,
    /// Length over which the penalty falls by a factor of e.
    pub penalty_unit: f64,
}

/// Around a robot that stands nearer to an obstacle than a plan allows, cells are open down to a smaller distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Escape {
    /// Where the robot stands, in cells.
    pub center: [f64; 2],
    /// How far around it the smaller distance holds, in cells.
    pub radius: f64,
    /// The smaller distance, in cells.
    pub minimum: f64,
}

/// `distance` is not below `limit`.
pub fn keeps(distance: f64, limit: f64) -> bool {
    distance >= limit - SAME_DISTANCE
}

impl Clearances {
    /// Cost of a straight step labeled with a cell at this distance: 1, and `exp((D_pref - d) / unit)` when near.
    fn entry_cost(&self, distance: f64, minimum: f64) -> f64 {
        if !keeps(distance, minimum) {
            f64::INFINITY
        } else if keeps(distance, self.preferred) {
            1.0
        } else {
            1.0 + ((self.preferred - distance) / self.penalty_unit).exp()
        }
    }

    /// Entry costs of all cells, infinite where no plan may go.
    pub fn entry_costs(&self, proximity: &ProximityMap, escape: Option<Escape>, costs: &mut Vec<f64>) {
        let open = |(kind, distance): (&CellKind, &f64)| {
            if *kind == CellKind::Free { self.entry_cost(*distance, self.minimum) } else { f64::INFINITY }
        };
        costs.clear();
        costs.extend(proximity.kinds().iter().zip(proximity.distances()).map(open));
        let Some(escape) = escape else { return };
        for cell in escape.cells(proximity.size()) {
            if proximity.kinds()[cell] == CellKind::Free {
                let minimum = self.minimum.min(escape.minimum);
                costs[cell] = self.entry_cost(proximity.distances()[cell], minimum);
            }
        }
    }
}

impl Escape {
    /// The cells whose centers lie inside.
    fn cells(self, size: GridSize) -> impl Iterator<Item = usize> {
        let span = |center: f64, n: usize| {
            let first = (center - self.radius - 0.5).ceil().max(0.0) as usize;
            let end = (center + self.radius + 0.5).floor().max(0.0) as usize;
            first..end.min(n)
        };
        let (cols, rows) = (span(self.center[0], size.width), span(self.center[1], size.height));
        rows.flat_map(move |row| cols.clone().map(move |col| (col, row)))
            .filter(move |&(col, row)| {
                let (dx, dy) = (col as f64 + 0.5 - self.center[0], row as f64 + 0.5 - self.center[1]);
                dx.hypot(dy) <= self.radius
            })
            .map(move |(col, row)| size.index(col, row))
    }
}
