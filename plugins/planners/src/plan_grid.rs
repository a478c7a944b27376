//! A plan request as cells: what both grid planners check and convert.

use rumbo_core::frames::Point2;
use rumbo_core::map::{Cell, CellClass, Grid};
use rumbo_core::messages::{Goal, PathPoint};
use rumbo_core::stages::{PlanError, PlanRequest};
use rumbo_kit::GridSize;
use rumbo_kit::proximity::CellKind;
use rumbo_kit::segment::all_cells_crossed;

/// A checked request.
pub struct PlanGrid<'a> {
    grid: &'a Grid,
    /// Size of the grid.
    pub size: GridSize,
    /// The robot's place in cells, from the lower left corner of the grid.
    pub start: [f64; 2],
    /// Which way the robot looks, seen from the grid's own axes, radians.
    pub heading_rad: f64,
    /// The robot's cell.
    pub start_cell: usize,
    /// The goal's cell.
    pub goal_cell: usize,
}

impl<'a> PlanGrid<'a> {
    /// Checks a request: finite numbers, a grid, start and goal on it, the goal free.
    pub fn new(request: &'a PlanRequest) -> Result<Self, PlanError> {
        finite_numbers(request)?;
        let (start, goal) = (Point2::from(request.start.translation.vector), request.goal.position);
        let grid = request.grid.as_ref().ok_or(PlanError::MissingLayer { layer: "grid" })?;
        let start_cell = grid.cell_at(start).ok_or(PlanError::StartOutside { start })?;
        let goal_cell = grid.cell_at(goal).ok_or(PlanError::GoalOutside { goal })?;
        if let Some(found) = not_free(grid.class(goal_cell)) {
            return Err(PlanError::GoalOccupied { goal, found });
        }
        if let Some(found) = not_free(grid.class(start_cell)) {
            return Err(PlanError::StartOccupied { start, found });
        }
        let in_grid = grid.grid_from_map() * request.start;
        let start_cells = in_grid.translation.vector / grid.resolution_m();
        Ok(Self {
            grid,
            size: GridSize::new(grid.width() as usize, grid.height() as usize),
            start: [start_cells.x, start_cells.y],
            heading_rad: in_grid.rotation.angle(),
            start_cell: grid.index_of(start_cell),
            goal_cell: grid.index_of(goal_cell),
        })
    }

    /// What every cell is, written over `kinds`.
    pub fn kinds(&self, undetermined_is_obstacle: bool, kinds: &mut Vec<CellKind>) {
        let undetermined = if undetermined_is_obstacle { CellKind::Obstacle } else { CellKind::Closed };
        let kind = |log_odds: &f32| match self.grid.class_of(*log_odds) {
            CellClass::Free => CellKind::Free,
            CellClass::Occupied => CellKind::Obstacle,
            CellClass::Unknown => undetermined,
        };
        kinds.clear();
        kinds.extend(self.grid.cells.iter().map(kind));
    }

    /// The grid itself.
    pub fn cells(&self) -> &Grid {
        self.grid
    }

    /// Edge of a cell, meters.
    pub fn resolution_m(&self) -> f64 {
        self.grid.resolution_m()
    }

    /// A point in cells, in the map's frame.
    pub fn in_map(&self, point: [f64; 2]) -> Point2 {
        self.grid.map_from_grid() * (Point2::new(point[0], point[1]) * self.grid.resolution_m())
    }

    /// Middle of a cell, in the map's frame.
    pub fn middle_of(&self, cell: usize) -> Point2 {
        let (col, row) = self.size.col_row(cell);
        self.grid.center_of(Cell { col: col as u32, row: row as u32 })
    }
}

/// Start and goal of a request are finite numbers.
pub fn finite_numbers(request: &PlanRequest) -> Result<(), PlanError> {
    let start = request.start.translation.vector;
    let goal = request.goal.position;
    let numbers = [
        ("the start's position", start.x + start.y),
        ("the start's heading", request.start.rotation.angle()),
        ("the goal's position", goal.x + goal.y),
        ("the goal's heading", request.goal.yaw_rad.unwrap_or(0.0)),
    ];
    let wrong = numbers.into_iter().find(|(_, number)| !number.is_finite());
    wrong.map_or(Ok(()), |(what, _)| Err(PlanError::NotFinite { what }))
}

fn not_free(class: CellClass) -> Option<&'static str> {
    match class {
        CellClass::Free => None,
        CellClass::Occupied => Some("occupied"),
        CellClass::Unknown => Some("unknown"),
    }
}

impl PlanGrid<'_> {
    /// A path in meters from points in cells that end in the middle of the goal's cell: it ends at the goal itself.
    ///
    /// The first and the last leg lead through the middle of the start's or goal's cell where, to or from the true
    /// place, they would cross a cell that is not open.
    pub fn ending_at(
        &self,
        goal: &Goal,
        points: &[[f64; 2]],
        is_open: &dyn Fn(usize) -> bool,
    ) -> Vec<PathPoint> {
        let at_goal = self.in_cells(goal.position);
        let mut way = points.to_vec();
        let middle_of_goal = way.pop().filter(|_| !way.is_empty());
        if let (Some(middle), Some(&last)) = (middle_of_goal, way.last())
            && !self.is_clear(last, at_goal, is_open)
        {
            way.push(middle);
        }
        if let (Some(&first), Some(&second)) = (way.first(), way.get(1))
            && !self.is_clear(first, second, is_open)
        {
            way.insert(1, [first[0].floor() + 0.5, first[1].floor() + 0.5]);
        }
        let free_to_look = |&point: &[f64; 2]| PathPoint { position: self.in_map(point), yaw_rad: None };
        let mut path: Vec<PathPoint> = way.iter().map(free_to_look).collect();
        path.push(PathPoint { position: goal.position, yaw_rad: goal.yaw_rad });
        path
    }

    fn in_cells(&self, position: Point2) -> [f64; 2] {
        let in_grid = self.grid.grid_from_map() * position / self.grid.resolution_m();
        [in_grid.x, in_grid.y]
    }

    fn is_clear(&self, a: [f64; 2], b: [f64; 2], is_open: &dyn Fn(usize) -> bool) -> bool {
        all_cells_crossed(a, b, |col, row| {
            let (Ok(col), Ok(row)) = (usize::try_from(col), usize::try_from(row)) else { return false };
            let is_inside = col < self.size.width && row < self.size.height;
            is_inside && is_open(self.size.index(col, row))
        })
    }
}
