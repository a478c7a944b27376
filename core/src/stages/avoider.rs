//! An avoider follows the path and reacts to what is near.

use super::Cx;
use crate::frames::{Pose2, Twist};
use crate::map::{Grid, Map};
use crate::messages::{Estimate, MessageFault, Obstacle, Path, Seen};
use crate::robot::Robot;

/// Turns path and near surroundings into a velocity.
#[doc(alias = "nav2_core::Controller")]
#[doc(alias = "local planner")]
pub trait Avoider: Send {
    /// What to do until the next call. Runs at the control rate.
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError>;
}

/// What an avoider gets.
#[derive(Debug, Clone, Copy)]
pub struct AvoidInput<'a> {
    /// The robot in the map, now: the last estimate moved on by the odometer.
    pub map_from_base: Pose2,
    /// The last estimate, as old as it is.
    pub estimate: &'a Estimate,
    /// Velocity of the base by the odometer; zero without one.
    pub twist: Twist,
    /// Observations since this avoider last ran.
    pub seen: Seen<'a>,
    /// The map.
    pub map: &'a Map,
    /// The map's grid with the known obstacles, as the last plan had it.
    pub grid: Option<&'a Grid>,
    /// The path; none while the robot wanders without a goal.
    pub path: Option<&'a Path>,
    /// Goes up with every new path, so that an avoider can tell a new one from the old.
    pub path_number: u64,
    /// Distance at which the path's end counts as reached, meters.
    pub arrival_radius_m: f64,
    /// Obstacles that the navigator remembers.
    pub obstacles: &'a [Obstacle],
    /// The robot.
    pub robot: &'a Robot,
}

/// What an avoider wants.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Steering {
    /// Drive like this.
    Drive(Twist),
    /// Stop: these are in the way, and a new path is needed.
    Blocked {
        /// What is in the way; may be empty when the path itself cannot be followed.
        obstacles: Vec<Obstacle>,
    },
    /// The end of this path is reached.
    Arrived,
}

/// Why an avoider cannot steer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AvoidError {
    /// A sensor that it needs gave nothing.
    #[error("no {kind} for {age_s:.2} s")]
    NoReading {
        /// What is missing.
        kind: &'static str,
        /// Since when, seconds.
        age_s: f64,
    },
    /// A number that must not go on.
    #[error(transparent)]
    Message(#[from] MessageFault),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
