//! From a request to a path: obstacles, the check of the goal, the walk, its legs.

use super::descent::{ChargeRules, DescentRules, End, Walk, descend};
use super::failure;
use super::figures;
use super::params::FieldSettings;
use super::rounding::Rounded;
use super::straightening::{StraightenRules, straightened, without_collinear};
use super::surroundings::obstacles;
use rumbo_core::frames::Point2;
use rumbo_core::messages::{Path, PathPoint};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{PlanError, PlanRequest, Planner};
use rumbo_kit::potential::{Field, Obstacles, Repulsion};

/// Beyond the hull, where no clearance is given: what the guard keeps free, and room for an estimate that is off.
const HULL_MARGIN_M: f64 = 0.10;
/// Obstacles are looked for a little beyond the clearance that is kept, meters.
const BEYOND_CLEARANCE_M: f64 = 0.5;

/// A planner's settings for one robot.
pub(crate) struct FieldPlanner {
    pub settings: FieldSettings,
    pub charges: Option<ChargeRules>,
    /// Every plan draws from the same stream, so that the same request gives the same path.
    pub rng: Rng,
}

impl Planner for FieldPlanner {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let hull_m = request.robot.hull().outer_radius_m();
        let settings = &self.settings;
        let inflation_m = if settings.inflate { hull_m } else { 0.0 };
        let repulsion = Repulsion { inflation_m, ..settings.repulsion };
        let minimum_clearance_m = settings.minimum_clearance_m.unwrap_or(hull_m + HULL_MARGIN_M);
        let rules = DescentRules { minimum_clearance_m, ..settings.descent };
        let reach_m = repulsion.reach_m().max(minimum_clearance_m + BEYOND_CLEARANCE_M);
        let obstacles = obstacles(request, settings.source, settings.grouping, reach_m)?;
        if request.give_up.is_raised() {
            return Err(PlanError::GivenUp);
        }
        let field = Field {
            goal: request.goal.position,
            attraction: settings.attraction,
            obstacles: &obstacles,
            repulsion,
            goal_scaling_m: settings.goal_scaling_m,
        };
        failure::check_goal(&field, &rules)?;
        let start = Point2::from(request.start.translation.vector);
        let mut give_up = || request.give_up.is_raised();
        let walk = descend(&field, &rules, self.charges.as_ref(), start, &mut self.rng.clone(), &mut give_up);
        figures::draw(request, &field, self.charges.as_ref(), &walk);
        if walk.end != End::Arrived {
            return Err(failure::of(&walk, &rules, self.charges.as_ref()));
        }
        let way = self.legs(request, &obstacles, &walk, minimum_clearance_m);
        figures::count(&request.trace, &obstacles, &walk, &way);
        path(request, &way)
    }
}

impl FieldPlanner {
    /// The walk to the goal itself, straightened.
    fn legs(&self, request: &PlanRequest, obstacles: &Obstacles, walk: &Walk, clearance_m: f64) -> Rounded {
        let mut points = walk.points.clone();
        let goal = request.goal.position;
        if points.last() != Some(&goal) {
            points.push(goal);
        }
        if !self.settings.straighten {
            return Rounded { points: without_collinear(&points), n_tight_corners: 0 };
        }
        let rules = StraightenRules {
            clearance_m,
            radius_m: self.settings.smoothing_radius_m,
            least_radius_m: request.robot.drive.turning_radius_m(),
        };
        straightened(&points, obstacles, &rules)
    }
}

fn path(request: &PlanRequest, way: &Rounded) -> Result<Path, PlanError> {
    let free_to_look = |position: &Point2| PathPoint { position: *position, yaw_rad: None };
    let mut points: Vec<PathPoint> = way.points.iter().map(free_to_look).collect();
    if let Some(last) = points.last_mut() {
        last.yaw_rad = request.goal.yaw_rad;
    }
    let length_m = super::straightening::length_m(&way.points);
    Path::new(points, length_m).ok_or_else(|| PlanError::Other("the path has no points".into()))
}
