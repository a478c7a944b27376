//! The planner: converts requests to cells and answers to meters.

use super::DpParams;
use super::cost_map::keeps;
use super::explanation::Explanation;
use super::grid_dp::{DpFault, DpPlan, DpRequest, DpRules, GridDp};
use super::obstruction::Obstruction;
use super::plan_figures::tell;
use crate::hull_fit::fits_hull;
use crate::plan_grid::PlanGrid;
use rumbo_core::map::Layer;
use rumbo_core::messages::{Path, PathPoint};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, PlanError, PlanRequest, Planner};
use rumbo_core::trace::Drawing;
use rumbo_kit::proximity::CellKind;

/// See [`DpParams`].
pub struct Dp {
    params: DpParams,
    kinds: Vec<CellKind>,
    grid_dp: GridDp,
}

impl Dp {
    /// A planner with these parameters.
    pub fn new(params: DpParams) -> Self {
        Self { params, kinds: Vec::new(), grid_dp: GridDp::default() }
    }

    fn path(
        &self,
        request: &PlanRequest,
        grid: &PlanGrid<'_>,
        rules: &DpRules,
        plan: DpPlan,
    ) -> Option<Path> {
        let map = self.grid_dp.proximity();
        // A robot inside the forbidden band leaves it; its first leg is not held against it.
        let limit = rules.clearances.minimum.min(map.distances()[grid.start_cell]);
        let is_open =
            |cell: usize| map.kinds()[cell] == CellKind::Free && keeps(map.distances()[cell], limit);
        let mut points = Vec::new();
        if let Some(behind) = plan.backed_off_to {
            // Looking the same way while it backs off.
            let yaw_rad = Some(request.start.rotation.angle());
            points.push(PathPoint { position: request.start.translation.vector.into(), yaw_rad });
            points.push(PathPoint { position: grid.in_map(behind), yaw_rad });
        }
        let way = grid.ending_at(&request.goal, &plan.refined, &is_open);
        points.extend(way.into_iter().skip(plan.backed_off_to.map_or(0, |_| 1)));
        if let (None, Some(first)) = (plan.backed_off_to, points.first_mut()) {
            first.position = request.start.translation.vector.into();
        }
        Path::new(points, plan.cost)
    }

    fn explained(
        &mut self,
        request: &PlanRequest,
        grid: &PlanGrid<'_>,
        rules: &DpRules,
        in_cells: &DpRequest,
        fault: DpFault,
    ) -> PlanError {
        let (on_map, hull_radius_m) = (request.map.grid.as_ref(), request.robot.hull().outer_radius_m());
        let explanation = Explanation::new(grid, on_map, self.params.minimum_clearance_m, hull_radius_m);
        let fault = match fault {
            DpFault::Unreachable(found) => self.least_change(request, in_cells, rules, &explanation, found),
            other => other,
        };
        self.error(request, grid, &explanation, fault)
    }

    /// The least change that opens a way: what was found on the way goes before what the map shows.
    fn least_change(
        &mut self,
        request: &PlanRequest,
        in_cells: &DpRequest,
        rules: &DpRules,
        explanation: &Explanation<'_>,
        found: Option<Obstruction>,
    ) -> DpFault {
        if !explanation.knows_found() {
            return DpFault::Unreachable(found);
        }
        let mut give_up = || request.give_up.is_raised();
        let is_removable = |cell: usize| explanation.is_found(cell);
        self.grid_dp
            .obstruction(in_cells, rules, &is_removable, &mut give_up)
            .map_or(DpFault::GivenUp, DpFault::Unreachable)
    }

    fn error(
        &self,
        request: &PlanRequest,
        grid: &PlanGrid<'_>,
        explanation: &Explanation<'_>,
        fault: DpFault,
    ) -> PlanError {
        let resolution_m = grid.resolution_m();
        let needed_m = self.params.minimum_clearance_m;
        match fault {
            DpFault::GivenUp => PlanError::GivenUp,
            DpFault::GoalNotFree => {
                PlanError::GoalOccupied { goal: request.goal.position, found: "not free" }
            }
            DpFault::GoalTooClose(distance) => PlanError::GoalTooClose {
                goal: request.goal.position,
                found_m: distance * resolution_m,
                needed_m,
            },
            DpFault::StartNotFree => {
                PlanError::StartOccupied { start: request.start.translation.vector.into(), found: "not free" }
            }
            DpFault::StartTooClose(_) => PlanError::StartOccupied {
                start: request.start.translation.vector.into(),
                found: "too close to an obstacle, and there is no room to back off",
            },
            DpFault::Unreachable(obstruction) => PlanError::Unreachable {
                reason: obstruction
                    .map_or_else(|| "the goal lies apart from the start".to_owned(), |o| explanation.of(&o)),
            },
        }
    }
}

impl Planner for Dp {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let grid = PlanGrid::new(request)?;
        grid.kinds(self.params.undetermined_is_obstacle, &mut self.kinds);
        let rules = self.params.rules(grid.resolution_m(), request.robot.hull().outer_radius_m());
        let in_cells = DpRequest { start: grid.start, heading_rad: grid.heading_rad, goal: grid.goal_cell };
        let mut give_up = || request.give_up.is_raised();
        let planned = self.grid_dp.plan(grid.size, &self.kinds, &rules, &in_cells, &mut give_up);
        let plan = match planned {
            Ok(plan) => plan,
            Err(fault) => return Err(self.explained(request, &grid, &rules, &in_cells, fault)),
        };
        tell(&request.trace, self.grid_dp.proximity(), &plan, grid.resolution_m());
        request.trace.count("settled_tiles", self.grid_dp.field().n_settled_tiles() as f64);
        request.trace.draw(|| Drawing::Polyline {
            name: "path before refinement",
            points: plan.cells.iter().map(|&cell| grid.middle_of(cell)).collect(),
        });
        self.path(request, &grid, &rules, plan).ok_or(PlanError::Other("the path has no points".into()))
    }
}

impl Params for DpParams {
    fn check(&self) -> Vec<BuildError> {
        self.faults()
    }
}

impl Plugin<dyn Planner> for DpParams {
    fn manifest(&self) -> Manifest {
        Manifest { needs_layers: vec![Layer::Grid], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
        fits_hull("minimum_clearance_m", self.minimum_clearance_m, &context.robot)?;
        Ok(Box::new(Dp::new(self.clone())))
    }
}

rumbo_core::register_planner!(
    DpParams,
    "dp",
    "cost-to-goal field that keeps away from obstacles, then straight pieces (Hernández Alamilla, 2005)",
);
