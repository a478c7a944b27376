//! A planner finds a way through the map.

use super::GiveUp;
use crate::frames::{Point2, Pose2};
use crate::map::{Grid, Map};
use crate::messages::{Goal, Obstacle, Path};
use crate::robot::Robot;
use crate::time::Time;
use crate::trace::Trace;
use std::sync::Arc;

/// Turns start, goal and map into a path.
#[doc(alias = "nav2_core::GlobalPlanner")]
pub trait Planner: Send {
    /// A path from the start to the goal, or the reason why there is none. Looks at `give_up` at least every 1,000
    /// expansions.
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError>;
}

/// What a planner gets: a snapshot that shares the map's layers.
#[derive(Debug)]
pub struct PlanRequest {
    /// When it was asked.
    pub stamp: Time,
    /// The map, without obstacles.
    pub map: Map,
    /// The map's grid with all obstacles marked as occupied.
    pub grid: Option<Grid>,
    /// The robot in the map.
    pub start: Pose2,
    /// Where to.
    pub goal: Goal,
    /// The robot.
    pub robot: Arc<Robot>,
    /// What is in the way and not on the map, for planners that work on changes; `grid` has it already.
    pub obstacles: Vec<Obstacle>,
    /// Raised when nobody waits for the path any more.
    pub give_up: GiveUp,
    /// Debug drawings.
    pub trace: Trace,
}

/// Why there is no path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The map lacks what this planner works on.
    #[error("the map has no {layer} layer; name a map builder that gives it")]
    MissingLayer {
        /// The layer.
        layer: &'static str,
    },
    /// The goal lies outside the map.
    #[error("the goal ({:.2}, {:.2}) m lies outside the map", goal.x, goal.y)]
    GoalOutside {
        /// The goal.
        goal: Point2,
    },
    /// Something stands on the goal, or nobody knows what.
    #[error("the goal ({:.2}, {:.2}) m is {found}; choose a free place", goal.x, goal.y)]
    GoalOccupied {
        /// The goal.
        goal: Point2,
        /// Occupied or unknown.
        found: &'static str,
    },
    /// The goal is too near to an obstacle.
    #[error(
        "the goal ({:.2}, {:.2}) m is {found_m:.2} m from the nearest obstacle, the planner keeps {needed_m:.2} m; \
         move the goal or lower the clearance", goal.x, goal.y
    )]
    GoalTooClose {
        /// The goal.
        goal: Point2,
        /// Distance to the nearest obstacle, meters.
        found_m: f64,
        /// Distance that the planner keeps, meters.
        needed_m: f64,
    },
    /// The robot stands outside the map.
    #[error("the start ({:.2}, {:.2}) m lies outside the map", start.x, start.y)]
    StartOutside {
        /// The start.
        start: Point2,
    },
    /// The robot stands in an obstacle.
    #[error("the start ({:.2}, {:.2}) m is {found}", start.x, start.y)]
    StartOccupied {
        /// The start.
        start: Point2,
        /// Occupied, unknown or too close.
        found: &'static str,
    },
    /// No way leads from start to goal.
    #[error("no way to the goal: {reason}")]
    Unreachable {
        /// What closes the way, and the smallest change that would open it where that is known.
        reason: String,
    },
    /// The planner's own search ended before the goal.
    #[error("the planner stopped at ({:.2}, {:.2}) m: {reason}", place.x, place.y)]
    Stuck {
        /// Where it stopped.
        place: Point2,
        /// Why.
        reason: String,
    },
    /// `give_up` was raised.
    #[error("planning was given up")]
    GivenUp,
    /// A number that is not finite.
    #[error("{what} is not a finite number")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
