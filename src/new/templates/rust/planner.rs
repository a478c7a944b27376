//! The planner `{{name}}`: Dijkstra's wave over the free cells of the grid.
//!
//! Replace what [`Wave::plan`] does by your own algorithm; the rest can stay.

use rumbo_core::frames::Point2;
use rumbo_core::map::{CellClass, Grid, Layer};
use rumbo_core::messages::{Path, PathPoint};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, GiveUp, PlanError, PlanRequest, Planner};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Shortest paths over the free cells of the grid.
// These comments are what `rumbo plugins describe` and editors show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Free space between the robot's middle and every obstacle, meters.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub clearance_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Parameters { clearance_m: 0.35 }
    }
}

impl Params for Parameters {
    fn check(&self) -> Vec<BuildError> {
        let found = self.clearance_m;
        let fits = (0.0..=5.0).contains(&found);
        let fault = || BuildError::at("clearance_m", format!("is {found}, expected a number from 0 to 5"));
        (!fits).then(fault).into_iter().collect()
    }
}

impl Plugin<dyn Planner> for Parameters {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![Layer::Grid], ..Manifest::default() }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        Ok(Box::new(Wave { parameters: self.clone() }))
    }
}

struct Wave {
    parameters: Parameters,
}

impl Planner for Wave {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let start: Point2 = request.start.translation.vector.into();
        let goal = request.goal.position;
        let numbers = [start.x, start.y, request.start.rotation.angle(), goal.x, goal.y];
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(PlanError::NotFinite { what: "the start or the goal" });
        }
        let grid = request.grid.as_ref().ok_or(PlanError::MissingLayer { layer: "grid" })?;
        let from = grid.cell_at(start).ok_or(PlanError::StartOutside { start })?;
        let to = grid.cell_at(goal).ok_or(PlanError::GoalOutside { goal })?;
        if grid.class(to) != CellClass::Free {
            return Err(PlanError::GoalOccupied { goal, found: "not free" });
        }
        let (from, to) = (grid.index_of(from), grid.index_of(to));
        let mut open = open_cells(grid, self.parameters.clearance_m);
        // A robot that stands too close to something may still leave.
        if let Some(here) = open.get_mut(from) {
            *here = true;
        }
        let way = shortest_way(grid, &open, from, to, &request.give_up)?;
        let middle = |cell: &usize| PathPoint { position: grid.center_of(grid.cell_of(*cell)), yaw_rad: None };
        let inner = way.get(1..way.len().saturating_sub(1)).unwrap_or_default();
        let mut points = vec![PathPoint { position: start, yaw_rad: None }];
        points.extend(inner.iter().map(middle));
        points.push(PathPoint { position: goal, yaw_rad: request.goal.yaw_rad });
        Path::new(points, way.len() as f64).ok_or_else(|| PlanError::Other("no points".to_owned()))
    }
}

/// Free cells whose middle is far enough from that of every occupied cell.
fn open_cells(grid: &Grid, clearance_m: f64) -> Vec<bool> {
    let mut open: Vec<bool> = grid.cells.iter().map(|v| grid.class_of(*v) == CellClass::Free).collect();
    let occupied = grid.cells.iter().enumerate().filter(|(_, v)| grid.class_of(**v) == CellClass::Occupied);
    let (width, height) = (grid.width() as i64, grid.height() as i64);
    let reach = (clearance_m / grid.resolution_m() + 0.5).ceil();
    let around = -reach as i64..=reach as i64;
    for (idx, _) in occupied {
        let (col, row) = (idx as i64 % width, idx as i64 / width);
        for (dx, dy) in around.clone().flat_map(|dy| around.clone().map(move |dx| (dx, dy))) {
            let (x, y) = (col + dx, row + dy);
            let is_inside = x >= 0 && y >= 0 && x < width && y < height;
            let is_near = (dx as f64).hypot(dy as f64) < reach;
            if is_inside && is_near && let Some(cell) = open.get_mut((y * width + x) as usize) {
                *cell = false;
            }
        }
    }
    open
}

/// The cells of the shortest way over eight neighbors, both ends included.
fn shortest_way(
    grid: &Grid,
    open: &[bool],
    from: usize,
    to: usize,
    give_up: &GiveUp,
) -> Result<Vec<usize>, PlanError> {
    // Lengths in thousandths of a cell: whole numbers are the same on every computer.
    const STEPS: [(i64, i64, u64); 8] = [
        (1, 0, 1000), (-1, 0, 1000), (0, 1, 1000), (0, -1, 1000),
        (1, 1, 1414), (-1, 1, 1414), (1, -1, 1414), (-1, -1, 1414),
    ];
    let (width, height) = (grid.width() as i64, grid.height() as i64);
    let mut reached: Vec<(u64, usize)> = vec![(u64::MAX, from); open.len()];
    let mut wave = BinaryHeap::from([Reverse((0, from, from))]);
    let mut n_expanded = 0u64;
    while let Some(Reverse((length, cell, parent))) = wave.pop() {
        let Some(known) = reached.get_mut(cell).filter(|known| known.0 == u64::MAX) else { continue };
        *known = (length, parent);
        if n_expanded.is_multiple_of(500) && give_up.is_raised() {
            return Err(PlanError::GivenUp);
        }
        n_expanded += 1;
        if cell == to {
            let mut way = vec![to];
            while let Some(last) = way.last().copied().filter(|last| *last != from) {
                way.push(reached.get(last).map_or(from, |known| known.1));
            }
            way.reverse();
            return Ok(way);
        }
        let (col, row) = (cell as i64 % width, cell as i64 / width);
        let is_open = |x: i64, y: i64| {
            let is_inside = x >= 0 && y >= 0 && x < width && y < height;
            is_inside && open.get((y * width + x) as usize).copied().unwrap_or(false)
        };
        for (dx, dy, step) in STEPS {
            // No squeezing between two corners.
            if is_open(col + dx, row + dy) && is_open(col + dx, row) && is_open(col, row + dy) {
                let next = ((row + dy) * width + col + dx) as usize;
                wave.push(Reverse((length + step, next, cell)));
            }
        }
    }
    Err(PlanError::Unreachable { reason: "obstacles close every way; lower clearance_m".to_owned() })
}

rumbo_core::register_planner!(Parameters, "{{name}}", "shortest paths over the free cells of the grid");

// The line that makes a plugin library of this crate.
rumbo_core::export_plugins!();

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;
    use rumbo_core::messages::Goal;
    use rumbo_core::time::Time;
    use rumbo_core::trace::Trace;

    #[test]
    fn a_path_goes_around_a_wall() {
        // 20 x 20 cells of 0.1 m; a wall in the middle, open at its upper end.
        let mut grid = Grid::unknown(20, 20, 0.1).unwrap();
        for (idx, cell) in grid.cells.make_mut().iter_mut().enumerate() {
            let is_wall = idx % 20 == 10 && idx / 20 < 12;
            *cell = if is_wall { Grid::CERTAIN } else { -Grid::CERTAIN };
        }
        let request = PlanRequest {
            stamp: Time::ZERO,
            map: Default::default(),
            grid: Some(grid),
            start: pose2(0.35, 0.35, 0.0),
            goal: Goal { position: Point2::new(1.65, 0.35), yaw_rad: None },
            robot: Default::default(),
            obstacles: Vec::new(),
            give_up: GiveUp::default(),
            trace: Trace::unwatched(),
        };
        let mut planner = Parameters { clearance_m: 0.2 }.build(&BuildContext::bare("planner")).unwrap();
        let path = planner.plan(&request).unwrap();
        assert_eq!(path.end().position, Point2::new(1.65, 0.35));
        assert!(path.points().iter().any(|point| point.position.y > 1.3), "{path:?}");
    }
}
