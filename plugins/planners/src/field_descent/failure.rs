//! Why there is no path, so that another planner can take over, and a person can see what happened.

use super::attempts::Attempt;
use super::descent::{ChargeRules, DescentRules, End, PlacedCharge, Walk};
use rumbo_core::frames::Point2;
use rumbo_core::stages::PlanError;
use rumbo_kit::potential::{Field, Obstacles};

/// The goal is not nearer to obstacles than any walk comes.
pub(super) fn check_clearance(obstacles: &Obstacles, goal: Point2, needed_m: f64) -> Result<(), PlanError> {
    let found_m = obstacles.clearance_m(goal).max(0.0);
    if found_m < needed_m { Err(PlanError::GoalTooClose { goal, found_m, needed_m }) } else { Ok(()) }
}

/// The goal of a field is where the descent can end: the obstacles around it push less than it draws.
pub(super) fn check_goal(field: &Field<'_>, rules: &DescentRules) -> Result<(), PlanError> {
    let at_goal = field.sample(field.goal);
    let draws = field.attraction.slope(rules.goal_tolerance_m);
    if at_goal.repulsion.norm() < draws {
        return Ok(());
    }
    Err(PlanError::GoalTooClose {
        goal: field.goal,
        found_m: at_goal.clearance_m,
        needed_m: field.repulsion.distance_of_push_m(draws).max(rules.minimum_clearance_m),
    })
}

/// What attempts failed by.
#[derive(Default)]
pub(super) struct Failures {
    first_walk: Option<PlanError>,
    refusal: Option<PlanError>,
    n: usize,
    scale: f64,
}

impl Failures {
    /// One more attempt did not arrive.
    pub fn add(&mut self, failure: PlanError, attempt: &Attempt) {
        (self.n, self.scale) = (self.n + 1, attempt.scale);
        // What is wrong with a start as a goal, nobody asked for.
        if attempt.is_backward {
            return;
        }
        if matches!(failure, PlanError::GoalTooClose { .. }) {
            self.refusal = Some(failure);
        } else if self.first_walk.is_none() {
            self.first_walk = Some(failure);
        }
    }

    /// The failure of the first walk that began; where the goal was refused each time, the last refusal, which needs least.
    pub fn summed_up(self) -> PlanError {
        match self.first_walk.or(self.refusal) {
            Some(PlanError::Stuck { place, reason }) if self.n > 1 => PlanError::Stuck {
                place,
                reason: format!(
                    "{reason}; none of {} attempts arrived, with lengths down to {:.2} of those given",
                    self.n, self.scale
                ),
            },
            Some(failure) => failure,
            None => PlanError::Other("no walk was tried".into()),
        }
    }
}

/// The error of a walk that did not arrive.
pub(super) fn of(walk: &Walk, rules: &DescentRules, charge_rules: Option<&ChargeRules>) -> PlanError {
    let place = walk.points.last().copied().unwrap_or_default();
    let charges = charges_of(walk);
    let stuck = |reason: String| PlanError::Stuck { place, reason };
    match walk.end {
        End::GivenUp => PlanError::GivenUp,
        End::StartInObstacle => PlanError::StartOccupied { start: place, found: "on an obstacle" },
        End::Arrived => PlanError::Other("the walk arrived, but was called a failure".into()),
        End::Minimum { force } => stuck(format!(
            "a local minimum of the potential, where a force of {force:.3} is left (minimum_force is {}); try \
             fictitious_charges, or name a [planner_fallback]{charges}",
            rules.minimum_force
        )),
        End::TooManyCharges => stuck(format!(
            "a local minimum that max_charges = {} charges did not lead out of; name a [planner_fallback]{charges}",
            charge_rules.map_or(0, |rules| rules.max_charges)
        )),
        End::OutOfSteps => stuck(format!(
            "max_steps = {} ended the search after {:.1} m{charges}",
            rules.max_steps, walk.length_m
        )),
        End::ClearanceLost { clearance_m } => stuck(format!(
            "led to {clearance_m:.2} m from an obstacle, where {:.2} m are kept (minimum_clearance_m){charges}",
            rules.minimum_clearance_m
        )),
    }
}

fn charges_of(walk: &Walk) -> String {
    if walk.charges.is_empty() {
        return String::new();
    }
    let place = |charge: &PlacedCharge| format!("({:.2}, {:.2})", charge.at.x, charge.at.y);
    let places: Vec<String> = walk.charges.iter().take(MOST_TOLD).map(place).collect();
    let more = match walk.charges.len() - places.len() {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    format!("; charges were at {} m{more}", places.join(", "))
}

/// So many charges are told with their places.
const MOST_TOLD: usize = 8;
