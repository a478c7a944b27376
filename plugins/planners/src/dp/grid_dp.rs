//! The whole planner on a grid, in cells: proximity map, cost field, path, checkpoints, refinement.

use super::checkpoints::{Point, ShortCut, center_of, checkpoints, distance_at};
use super::cost_map::{Clearances, Escape, keeps};
use super::descent::descend;
use super::obstruction::{Obstruction, find_obstruction};
use rumbo_kit::GridSize;
use rumbo_kit::cost_field::{CostField, GivenUp, StepRule, Until};
use rumbo_kit::proximity::{CellKind, ProximityMap};
use rumbo_kit::segment::all_cells_crossed;

/// How to plan, lengths in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DpRules {
    /// Distances to obstacles.
    pub clearances: Clearances,
    /// Steps between cells.
    pub steps: StepRule,
    /// The refinement's test: see [`ShortCut::no_nearer_than_path`].
    pub no_nearer_than_path: bool,
    /// Radius around a robot inside the forbidden band where [`DpRules::escape_minimum`] holds.
    pub escape_radius: f64,
    /// Smallest distance to obstacles there.
    pub escape_minimum: f64,
    /// How far the robot backs off, once, when even that leaves it without a way.
    pub back_off: f64,
}

/// A request, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DpRequest {
    /// Where the robot is, inside the grid.
    pub start: Point,
    /// Which way it looks, radians.
    pub heading_rad: f64,
    /// The cell to reach.
    pub goal: usize,
}

/// A plan, in cells.
#[derive(Clone, Debug, PartialEq)]
pub struct DpPlan {
    /// Cost of the path from the start's cell.
    pub cost: f64,
    /// The path, cell by cell.
    pub cells: Vec<usize>,
    /// Where it turns.
    pub checkpoints: Vec<Point>,
    /// What the refinement left of them.
    pub refined: Vec<Point>,
    /// Where the robot backs off to before the first checkpoint.
    pub backed_off_to: Option<Point>,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq)]
pub enum DpFault {
    /// The start's cell is not free.
    StartNotFree,
    /// The start is too near to an obstacle, in cells, and backing off does not help.
    StartTooClose(f64),
    /// The goal's cell is not free.
    GoalNotFree,
    /// The goal is this near to an obstacle, in cells.
    GoalTooClose(f64),
    /// No way leads there.
    Unreachable(Option<Obstruction>),
    /// The caller asked to stop.
    GivenUp,
}

/// The planner with its memory: proximity map and cost field are kept, and where only obstacles were added, the
/// proximity map is updated, not computed again.
pub struct GridDp {
    proximity: ProximityMap,
    entry_costs: Vec<f64>,
    field: CostField,
    added: Vec<usize>,
}

impl Default for GridDp {
    fn default() -> Self {
        Self {
            proximity: ProximityMap::new(GridSize::new(0, 0), &[], 1.0),
            entry_costs: Vec::new(),
            field: CostField::new(),
            added: Vec::new(),
        }
    }
}

/// With more new obstacles than this part of the map, a new proximity map is faster.
const FEW: usize = 100;

impl GridDp {
    /// Plans on a grid of these cells.
    pub fn plan(
        &mut self,
        size: GridSize,
        kinds: &[CellKind],
        rules: &DpRules,
        request: &DpRequest,
        give_up: &mut dyn FnMut() -> bool,
    ) -> Result<DpPlan, DpFault> {
        self.update_proximity(size, kinds, rules.steps.diagonal_step);
        if kinds[request.goal] != CellKind::Free {
            return Err(DpFault::GoalNotFree);
        }
        let goal_distance = self.proximity.distances()[request.goal];
        if !keeps(goal_distance, rules.clearances.minimum) {
            return Err(DpFault::GoalTooClose(goal_distance));
        }
        let start_distance = self.start_distance(request.start).ok_or(DpFault::StartNotFree)?;
        if let Some(plan) = self.plan_from(request.start, request.goal, rules, give_up)? {
            return Ok(plan);
        }
        if !keeps(start_distance, rules.clearances.minimum)
            && let Some(behind) = self.behind(request, rules)
            && let Some(plan) = self.plan_from(behind, request.goal, rules, give_up)?
        {
            return Ok(DpPlan { backed_off_to: Some(behind), ..plan });
        }
        if !keeps(start_distance, rules.escape_minimum.min(rules.clearances.minimum)) {
            return Err(DpFault::StartTooClose(start_distance));
        }
        Err(self.no_way(request, rules, give_up))
    }

    /// The proximity map of the last plan.
    pub fn proximity(&self) -> &ProximityMap {
        &self.proximity
    }

    /// The cost field of the last plan; costs above that of the start may be too high.
    pub fn field(&self) -> &CostField {
        &self.field
    }

    fn update_proximity(&mut self, size: GridSize, kinds: &[CellKind], diagonal_step: f64) {
        let known = self.proximity.kinds();
        let is_same_grid = self.proximity.size() == size && self.proximity.is_for_step(diagonal_step);
        self.added.clear();
        if is_same_grid {
            let changed = (0..kinds.len()).filter(|&cell| kinds[cell] != known[cell]);
            self.added.extend(changed.take(kinds.len() / FEW + 1));
            let only_added = self.added.iter().all(|&cell| kinds[cell] == CellKind::Obstacle);
            if only_added && self.added.len() <= kinds.len() / FEW {
                self.proximity.add_obstacles(&self.added);
                return;
            }
        }
        self.proximity.recompute(size, kinds, diagonal_step);
    }

    fn start_distance(&self, start: Point) -> Option<f64> {
        distance_at(&self.proximity, start[0].floor() as i64, start[1].floor() as i64)
    }

    /// Cost of the cheapest path, infinite where there is none: a plan's cost without the plan.
    pub fn cost(
        &mut self,
        size: GridSize,
        kinds: &[CellKind],
        rules: &DpRules,
        request: &DpRequest,
        give_up: &mut dyn FnMut() -> bool,
    ) -> Result<f64, DpFault> {
        self.update_proximity(size, kinds, rules.steps.diagonal_step);
        let start_cell = self.grow_field(request.start, request.goal, rules, give_up)?;
        Ok(self.field.cost(start_cell))
    }

    /// Grows the cost field around the goal up to the start's cell, which is returned.
    fn grow_field(
        &mut self,
        start: Point,
        goal: usize,
        rules: &DpRules,
        give_up: &mut dyn FnMut() -> bool,
    ) -> Result<usize, DpFault> {
        let size = self.proximity.size();
        let distance = self.start_distance(start).ok_or(DpFault::StartNotFree)?;
        let is_inside_band = !keeps(distance, rules.clearances.minimum);
        let escape = Escape { center: start, radius: rules.escape_radius, minimum: rules.escape_minimum };
        let escape = is_inside_band.then_some(escape);
        rules.clearances.entry_costs(&self.proximity, escape, &mut self.entry_costs);
        self.field.set_entry_costs(size, &self.entry_costs, rules.steps);
        let start_cell = size.index(start[0] as usize, start[1] as usize);
        self.field.grow(goal, Until::Settled(start_cell), give_up).map_err(|_| DpFault::GivenUp)?;
        Ok(start_cell)
    }

    /// A plan, or `None` where there is no way.
    fn plan_from(
        &mut self,
        start: Point,
        goal: usize,
        rules: &DpRules,
        give_up: &mut dyn FnMut() -> bool,
    ) -> Result<Option<DpPlan>, DpFault> {
        let size = self.proximity.size();
        let start_cell = self.grow_field(start, goal, rules, give_up)?;
        let Some(cells) = descend(&self.field, rules.steps, start_cell, goal) else {
            return Ok(None);
        };
        let cost = self.field.cost(start_cell);
        let checkpoints = checkpoints(size, &cells, start);
        let short_cut = ShortCut {
            preferred: rules.clearances.preferred,
            minimum: rules.clearances.minimum,
            no_nearer_than_path: rules.no_nearer_than_path,
            corner_cutting: rules.steps.corner_cutting,
        };
        let refined = short_cut.refine(&self.proximity, &checkpoints, give_up).ok_or(DpFault::GivenUp)?;
        Ok(Some(DpPlan { cost, cells, checkpoints, refined, backed_off_to: None }))
    }

    /// What keeps the start from the goal.
    fn no_way(&mut self, request: &DpRequest, rules: &DpRules, give_up: &mut dyn FnMut() -> bool) -> DpFault {
        self.obstruction(request, rules, &|_| false, give_up).map_or(DpFault::GivenUp, DpFault::Unreachable)
    }

    /// What keeps the start from the goal on the grid of the last plan, if removable cells are the first to be opened.
    pub fn obstruction(
        &mut self,
        request: &DpRequest,
        rules: &DpRules,
        is_removable: &dyn Fn(usize) -> bool,
        give_up: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Obstruction>, GivenUp> {
        let start = self.proximity.size().index(request.start[0] as usize, request.start[1] as usize);
        let (minimum, ends) = (rules.clearances.minimum, [start, request.goal]);
        find_obstruction(&self.proximity, &mut self.field, minimum, rules.steps, ends, is_removable, give_up)
    }

    /// The place straight behind the robot, if the way there is free.
    fn behind(&self, request: &DpRequest, rules: &DpRules) -> Option<Point> {
        let (sin, cos) = request.heading_rad.sin_cos();
        let [x, y] = request.start;
        let behind = [x - rules.back_off * cos, y - rules.back_off * sin];
        let is_free = all_cells_crossed(request.start, behind, |col, row| {
            distance_at(&self.proximity, col, row).is_some()
        });
        is_free.then_some(behind)
    }
}

/// Ends of a plan that are cells, as points.
pub fn ends(size: GridSize, start: usize, goal: usize) -> DpRequest {
    DpRequest { start: center_of(size, start), heading_rad: 0.0, goal }
}
