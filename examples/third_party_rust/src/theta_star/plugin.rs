//! The planner: from a request in meters to cells, and back.

use super::ThetaStarParams;
use super::floor::{Floor, Kind};
use super::search::{NoWay, ThetaStar};
use rumbo_core::frames::Point2;
use rumbo_core::map::{Cell, CellClass, Grid, Layer};
use rumbo_core::messages::{Path, PathPoint};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};

struct ThetaStarPlanner {
    params: ThetaStarParams,
    kinds: Vec<Kind>,
    floor: Floor,
    search: ThetaStar,
}

/// More than the hull, where nobody says how much, meters.
const BESIDE_THE_HULL_M: f64 = 0.05;

impl Plugin<dyn Planner> for ThetaStarParams {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![Layer::Grid], ..Manifest::default() }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        Ok(Box::new(ThetaStarPlanner {
            params: self.clone(),
            kinds: Vec::new(),
            floor: Floor::default(),
            search: ThetaStar::default(),
        }))
    }
}

impl Planner for ThetaStarPlanner {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let (grid, start, goal) = checked(request)?;
        let clearance_m = self
            .params
            .clearance_m
            .unwrap_or_else(|| request.robot.hull().outer_radius_m() + BESIDE_THE_HULL_M);
        self.kinds.clear();
        self.kinds.extend(grid.cells.iter().map(|log_odds| match grid.class_of(*log_odds) {
            CellClass::Free => Kind::Free,
            CellClass::Occupied => Kind::Obstacle,
            CellClass::Unknown => Kind::Unknown,
        }));
        self.floor.lay(grid.width() as usize, &self.kinds, clearance_m / grid.resolution_m(), start);
        if !self.floor.is_open(goal) {
            let found_m = distance_to_obstacle_m(grid, goal);
            return Err(PlanError::GoalTooClose {
                goal: request.goal.position,
                found_m,
                needed_m: clearance_m,
            });
        }
        let give_up = || request.give_up.is_raised();
        let found = self.search.search(&self.floor, (start, goal), self.params.greediness, give_up);
        request.trace.count("expanded cells", self.search.n_expanded as f64);
        let (corners, length) = found.map_err(|no_way| match no_way {
            NoWay::GivenUp => PlanError::GivenUp,
            NoWay::Closed => PlanError::Unreachable {
                reason: format!(
                    "obstacles close every way with {clearance_m:.2} m of clearance; lower clearance_m"
                ),
            },
        })?;
        let points = self.points(request, grid, &corners);
        Path::new(points, length * grid.resolution_m())
            .ok_or_else(|| PlanError::Other("no points".to_owned()))
    }
}

impl ThetaStarPlanner {
    /// The way in meters. It begins and ends at the very places, and goes through the middles of their cells only where
    /// the straight way would leave the floor.
    fn points(&self, request: &PlanRequest, grid: &Grid, corners: &[usize]) -> Vec<PathPoint> {
        let in_cells = |point: Point2| {
            let point = grid.grid_from_map() * point / grid.resolution_m();
            [point.x, point.y]
        };
        let (start, goal) = (request.start.translation.vector.into(), request.goal.position);
        let mut way = vec![in_cells(start)];
        way.extend(corners.iter().map(|cell| self.floor.middle(*cell)));
        way.push(in_cells(goal));
        self.leave_out(1, &mut way);
        self.leave_out(way.len().saturating_sub(2), &mut way);
        let inner = way.get(1..way.len() - 1).unwrap_or_default();
        let free_to_look = |position: Point2| PathPoint { position, yaw_rad: None };
        let in_map = |[x, y]: [f64; 2]| grid.map_from_grid() * (Point2::new(x, y) * grid.resolution_m());
        let mut points = vec![free_to_look(start)];
        points.extend(inner.iter().map(|point| free_to_look(in_map(*point))));
        points.push(PathPoint { position: goal, yaw_rad: request.goal.yaw_rad });
        points
    }

    /// Leaves out a point between two others that see each other.
    fn leave_out(&self, middle: usize, way: &mut Vec<[f64; 2]>) {
        let around = middle.checked_sub(1).and_then(|before| Some((way.get(before)?, way.get(middle + 1)?)));
        if around.is_some_and(|(before, after)| self.floor.is_clear(*before, *after)) {
            way.remove(middle);
        }
    }
}

/// The grid, and the cells of start and goal.
fn checked(request: &PlanRequest) -> Result<(&Grid, usize, usize), PlanError> {
    let start: Point2 = request.start.translation.vector.into();
    let goal = request.goal.position;
    let numbers = [
        ("the start's position", start.x + start.y),
        ("the start's heading", request.start.rotation.angle()),
        ("the goal's position", goal.x + goal.y),
        ("the goal's heading", request.goal.yaw_rad.unwrap_or(0.0)),
    ];
    if let Some((what, _)) = numbers.into_iter().find(|(_, number)| !number.is_finite()) {
        return Err(PlanError::NotFinite { what });
    }
    let grid = request.grid.as_ref().ok_or(PlanError::MissingLayer { layer: "grid" })?;
    let start_cell = grid.cell_at(start).ok_or(PlanError::StartOutside { start })?;
    let goal_cell = grid.cell_at(goal).ok_or(PlanError::GoalOutside { goal })?;
    if let Some(found) = not_free(grid, goal_cell) {
        return Err(PlanError::GoalOccupied { goal, found });
    }
    if let Some(found) = not_free(grid, start_cell) {
        return Err(PlanError::StartOccupied { start, found });
    }
    Ok((grid, grid.index_of(start_cell), grid.index_of(goal_cell)))
}

fn not_free(grid: &Grid, cell: Cell) -> Option<&'static str> {
    match grid.class(cell) {
        CellClass::Free => None,
        CellClass::Occupied => Some("occupied"),
        CellClass::Unknown => Some("unknown"),
    }
}

/// From the middle of a cell to that of the nearest occupied one; for messages, so it may take its time.
fn distance_to_obstacle_m(grid: &Grid, from: usize) -> f64 {
    let from = grid.center_of(grid.cell_of(from));
    let occupied = grid.cells.iter().enumerate().filter(|(_, v)| grid.class_of(**v) == CellClass::Occupied);
    let distances = occupied.map(|(idx, _)| (grid.center_of(grid.cell_of(idx)) - from).norm());
    distances.fold(f64::INFINITY, f64::min)
}

rumbo_core::register_planner!(
    ThetaStarParams,
    "theta_star",
    "short paths in any direction over the free cells (Theta*, Nash and others, 2007)"
);

#[cfg(test)]
mod tests;
