//! From a request to a path: obstacles, the check of the goal, the walk, its legs.

use super::attempts::Attempt;
use super::descent::{ChargeRules, DescentRules, End, Walk, descend};
use super::failure::{self, Failures};
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
    /// Walks that are tried; 1: only as given.
    pub n_attempts: usize,
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
        // A step from where nothing is within reach must not end nearer than the clearance.
        let beyond_m = BEYOND_CLEARANCE_M.max(2.0 * rules.step.longest_m());
        let reach_m = repulsion.reach_m().max(minimum_clearance_m + beyond_m);
        let obstacles = obstacles(request, settings.source, settings.grouping, reach_m)?;
        failure::check_clearance(&obstacles, request.goal.position, minimum_clearance_m)?;
        let search = Search { planner: self, request, obstacles: &obstacles, rules, repulsion };
        let walk = search.first_that_arrives()?;
        let way = self.legs(request, &obstacles, &walk, minimum_clearance_m);
        figures::count(&request.trace, &obstacles, &walk, &way);
        path(request, &way)
    }
}

/// One request on its way through the attempts.
struct Search<'a> {
    planner: &'a FieldPlanner,
    request: &'a PlanRequest,
    obstacles: &'a Obstacles,
    rules: DescentRules,
    repulsion: Repulsion,
}

impl Search<'_> {
    /// The walk of the first attempt that arrives; the failure of the first one that began where none does.
    fn first_that_arrives(&self) -> Result<Walk, PlanError> {
        let FieldPlanner { settings, charges, n_attempts, rng } = self.planner;
        let given = Attempt {
            scale: 1.0,
            is_backward: false,
            repulsion: self.repulsion,
            goal_scaling_m: settings.goal_scaling_m,
            charges: *charges,
        };
        let (mut rng, mut failures) = (rng.clone(), Failures::default());
        let mut first_stuck = None;
        let clearance_m = self.rules.minimum_clearance_m;
        for attempt in given.followed_by(&settings.attraction, clearance_m, *n_attempts) {
            if self.request.give_up.is_raised() {
                return Err(PlanError::GivenUp);
            }
            match self.walk(&attempt, &mut rng) {
                Ok(walk) if walk.end == End::Arrived => return Ok(self.forward(&attempt, walk)),
                Ok(walk) if walk.end == End::GivenUp => return Err(PlanError::GivenUp),
                Ok(walk) => {
                    failures.add(failure::of(&walk, &self.rules, attempt.charges.as_ref()), &attempt);
                    if !attempt.is_backward {
                        first_stuck.get_or_insert((attempt, walk));
                    }
                }
                Err(refusal) => failures.add(refusal, &attempt),
            }
        }
        if let Some((attempt, walk)) = first_stuck {
            figures::draw(self.request, &self.field(&attempt), attempt.charges.as_ref(), &walk);
        }
        Err(failures.summed_up())
    }

    fn walk(&self, attempt: &Attempt, rng: &mut Rng) -> Result<Walk, PlanError> {
        let field = self.field(attempt);
        failure::check_goal(&field, &self.rules)?;
        let mut give_up = || self.request.give_up.is_raised();
        let [start, _] = self.ends(attempt);
        Ok(descend(&field, &self.rules, attempt.charges.as_ref(), start, rng, &mut give_up))
    }

    /// A walk that arrived, drawn, from the robot to its goal.
    fn forward(&self, attempt: &Attempt, mut walk: Walk) -> Walk {
        figures::draw(self.request, &self.field(attempt), attempt.charges.as_ref(), &walk);
        if attempt.is_backward {
            let [_, goal] = self.ends(attempt);
            walk.points.push(goal);
            walk.points.reverse();
        }
        walk
    }

    fn field(&self, attempt: &Attempt) -> Field<'_> {
        let [_, goal] = self.ends(attempt);
        Field {
            goal,
            attraction: self.planner.settings.attraction,
            obstacles: self.obstacles,
            repulsion: attempt.repulsion,
            goal_scaling_m: attempt.goal_scaling_m,
        }
    }

    /// Where the walk begins, and where it leads.
    fn ends(&self, attempt: &Attempt) -> [Point2; 2] {
        let ends = [Point2::from(self.request.start.translation.vector), self.request.goal.position];
        if attempt.is_backward { [ends[1], ends[0]] } else { ends }
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
