//! Why there is no path, so that another planner can take over, and a person can see what happened.

use super::descent::{ChargeRules, DescentRules, End, Walk};
use rumbo_core::stages::PlanError;
use rumbo_kit::potential::Field;

/// The goal is where the descent can end: the obstacles around it push less than it draws.
pub(super) fn check_goal(field: &Field<'_>, rules: &DescentRules) -> Result<(), PlanError> {
    let at_goal = field.sample(field.goal);
    let needed_m = rules.minimum_clearance_m;
    if at_goal.clearance_m < needed_m {
        let (goal, found_m) = (field.goal, at_goal.clearance_m.max(0.0));
        return Err(PlanError::GoalTooClose { goal, found_m, needed_m });
    }
    let draws = field.attraction.slope(rules.goal_tolerance_m);
    if at_goal.repulsion.norm() < draws {
        return Ok(());
    }
    Err(PlanError::GoalTooClose {
        goal: field.goal,
        found_m: at_goal.clearance_m,
        needed_m: field.repulsion.distance_of_push_m(draws).max(needed_m),
    })
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
        End::StepIntoObstacle => stuck(format!("a step ended on an obstacle; shorten step_m{charges}")),
        End::ClearanceLost { clearance_m } => stuck(format!(
            "pushed to {clearance_m:.2} m from an obstacle, where {:.2} m are kept (minimum_clearance_m){charges}",
            rules.minimum_clearance_m
        )),
    }
}

fn charges_of(walk: &Walk) -> String {
    if walk.charges.is_empty() {
        return String::new();
    }
    let places: Vec<String> =
        walk.charges.iter().map(|charge| format!("({:.2}, {:.2})", charge.at.x, charge.at.y)).collect();
    format!("; charges were at {} m", places.join(", "))
}
