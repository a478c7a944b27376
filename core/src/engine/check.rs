//! What can be said of a mission before anything moves.

use super::step::Engine;
use crate::map::CellClass;

/// A waypoint that cannot be a goal.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("waypoint {index} {message}")]
pub struct WaypointFault {
    /// Which waypoint, from 0.
    pub index: usize,
    /// What is wrong with it.
    pub message: String,
}

impl Engine {
    /// Waypoints that lie outside the map or on something, as the map is before the robot has seen anything.
    pub fn waypoint_faults(&self) -> Vec<WaypointFault> {
        let Some(grid) = &self.map.grid else { return Vec::new() };
        // A map that is still to be built says nothing about goals.
        if grid.cells.iter().all(|cell| *cell == 0.0) {
            return Vec::new();
        }
        let fault = |(index, goal): (usize, &crate::messages::Goal)| {
            let at = goal.position;
            let message = match grid.cell_at(at).map(|cell| grid.class(cell)) {
                Some(CellClass::Free) => return None,
                Some(CellClass::Occupied) => format!("({:.2}, {:.2}) m is occupied on the map", at.x, at.y),
                Some(CellClass::Unknown) => format!("({:.2}, {:.2}) m is unknown on the map", at.x, at.y),
                None => {
                    let (width, height) = (f64::from(grid.width()), f64::from(grid.height()));
                    let corner = |col: f64, row: f64| {
                        grid.map_from_grid() * (crate::frames::Point2::new(col, row) * grid.resolution_m())
                    };
                    let (low, high) = (corner(0.0, 0.0), corner(width, height));
                    format!(
                        "({:.2}, {:.2}) m lies outside the map, which spans ({:.2}, {:.2}) to ({:.2}, {:.2}) m",
                        at.x, at.y, low.x, low.y, high.x, high.y
                    )
                }
            };
            Some(WaypointFault { index, message })
        };
        self.pending.iter().enumerate().filter_map(fault).collect()
    }
}
