//! Reasons of planners: most of them name a place.

use super::super::abi::*;
use super::super::convert::cut_into;
use super::{Crosses, reason};
use crate::frames::Point2;
use crate::stages::PlanError;

fn put(error: &mut rumbo_error, point: &Point2, text: &str) {
    error.place = rumbo_point { x_m: point.x, y_m: point.y };
    cut_into(&mut error.text, text);
}

impl Crosses for PlanError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        match self {
            PlanError::MissingLayer { layer } => {
                cut_into(&mut e.text, layer);
                RUMBO_MISSING_LAYER
            }
            PlanError::GoalOutside { goal } => {
                put(e, goal, "");
                RUMBO_GOAL_OUTSIDE
            }
            PlanError::GoalOccupied { goal, found } => {
                put(e, goal, found);
                RUMBO_GOAL_OCCUPIED
            }
            PlanError::GoalTooClose { goal, found_m, needed_m } => {
                put(e, goal, "");
                e.values = [*found_m, *needed_m];
                RUMBO_GOAL_TOO_CLOSE
            }
            PlanError::StartOutside { start } => {
                put(e, start, "");
                RUMBO_START_OUTSIDE
            }
            PlanError::StartOccupied { start, found } => {
                put(e, start, found);
                RUMBO_START_OCCUPIED
            }
            PlanError::Unreachable { reason } => {
                cut_into(&mut e.text, reason);
                RUMBO_UNREACHABLE
            }
            PlanError::Stuck { place, reason } => {
                put(e, place, reason);
                RUMBO_STUCK
            }
            PlanError::GivenUp => RUMBO_GIVEN_UP,
            PlanError::NotFinite { what } => {
                cut_into(&mut e.text, what);
                RUMBO_BAD_NUMBER
            }
            PlanError::Other(_) => RUMBO_ERROR,
        }
    }

    fn from_code(code: i32, e: &rumbo_error) -> PlanError {
        match code {
            RUMBO_MISSING_LAYER => PlanError::MissingLayer { layer: e.noun() },
            RUMBO_GOAL_OUTSIDE => PlanError::GoalOutside { goal: e.point() },
            RUMBO_GOAL_OCCUPIED => PlanError::GoalOccupied { goal: e.point(), found: e.noun() },
            RUMBO_GOAL_TOO_CLOSE => {
                PlanError::GoalTooClose { goal: e.point(), found_m: e.values[0], needed_m: e.values[1] }
            }
            RUMBO_START_OUTSIDE => PlanError::StartOutside { start: e.point() },
            RUMBO_START_OCCUPIED => PlanError::StartOccupied { start: e.point(), found: e.noun() },
            RUMBO_UNREACHABLE => PlanError::Unreachable { reason: reason(e, code) },
            RUMBO_STUCK => PlanError::Stuck { place: e.point(), reason: reason(e, code) },
            RUMBO_GIVEN_UP => PlanError::GivenUp,
            RUMBO_BAD_NUMBER => PlanError::NotFinite { what: e.noun() },
            _ => PlanError::Other(e.words(code)),
        }
    }
}
