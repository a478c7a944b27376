//! The planner: converts requests to cells and answers to meters.

use super::AStarParams;
use super::grid_a_star::{AStarFault, GridAStar, GridPath};
use crate::dp::checkpoints::checkpoints;
use crate::hull_fit::fits_hull;
use crate::plan_grid::PlanGrid;
use rumbo_core::map::Layer;
use rumbo_core::messages::Path;
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};
use rumbo_kit::proximity::CellKind;

/// See [`AStarParams`].
pub struct AStar {
    params: AStarParams,
    kinds: Vec<CellKind>,
    search: GridAStar,
}

impl AStar {
    /// A planner with these parameters.
    pub fn new(params: AStarParams) -> Self {
        Self { params, kinds: Vec::new(), search: GridAStar::default() }
    }

    /// Where the path turns, in meters.
    fn path(&self, request: &PlanRequest, grid: &PlanGrid<'_>, found: &GridPath) -> Option<Path> {
        let turns = checkpoints(grid.size, &found.cells, grid.start);
        let mut points = grid.ending_at(&request.goal, &turns, &|cell| self.search.is_open(cell));
        if let Some(first) = points.first_mut() {
            first.position = request.start.translation.vector.into();
        }
        Path::new(points, found.length * grid.resolution_m())
    }
}

impl Planner for AStar {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let grid = PlanGrid::new(request)?;
        grid.kinds(self.params.undetermined_is_obstacle, &mut self.kinds);
        let clearance_m = self.params.clearance_m(request.robot.hull().outer_radius_m());
        let resolution_m = grid.resolution_m();
        let clearance = clearance_m / resolution_m;
        let give_up = || request.give_up.is_raised();
        let found = self
            .search
            .plan(grid.size, &self.kinds, clearance, grid.start_cell, grid.goal_cell, give_up)
            .map_err(|fault| match fault {
                AStarFault::GivenUp => PlanError::GivenUp,
                AStarFault::GoalTooClose(distance) => PlanError::GoalTooClose {
                    goal: request.goal.position,
                    found_m: distance * resolution_m,
                    needed_m: clearance_m,
                },
                AStarFault::Unreachable => PlanError::Unreachable {
                    reason: format!(
                        "obstacles close every way with {clearance_m:.2} m of clearance; lower clearance_m or open a way"
                    ),
                },
            })?;
        request.trace.count("settled_tiles", self.search.field().n_settled_tiles() as f64);
        self.path(request, &grid, &found).ok_or(PlanError::Other("the path has no points".into()))
    }
}

impl Params for AStarParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Planner> for AStarParams {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![Layer::Grid], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        if let Some(clearance_m) = self.clearance_m {
            fits_hull("clearance_m", clearance_m, &context.robot)?;
        }
        Ok(Box::new(AStar::new(self.clone())))
    }
}

rumbo_core::register_planner!(
    AStarParams,
    "a_star",
    "shortest path over eight neighbors with a clearance (A*, Hart, Nilsson and Raphael, 1968)",
);
