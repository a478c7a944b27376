//! What happened, as a list that people and programs can read.

use super::order::State;
use crate::frames::Point2;
use crate::messages::Status;
use crate::time::{Span, Time};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Something that happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When.
    pub stamp: Time,
    /// What.
    pub kind: EventKind,
}

/// What can happen.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum EventKind {
    /// The mission's automaton changed its state.
    State {
        /// From.
        from: State,
        /// To.
        to: State,
    },
    /// The estimate's status changed.
    Status(Status),
    /// A command was refused; nothing changed.
    Refused {
        /// The command.
        command: &'static str,
        /// The state that refuses it.
        state: State,
    },
    /// A goal was taken on.
    GoalAccepted(Point2),
    /// A path was asked for.
    PlanRequested {
        /// New plans for this goal so far.
        replans: u32,
    },
    /// A path came.
    PlanFound {
        /// Its length, meters.
        length_m: f64,
    },
    /// No path came.
    PlanFailed {
        /// Why.
        reason: String,
    },
    /// The second planner was asked.
    FallbackAsked {
        /// What the first one said.
        reason: String,
    },
    /// The avoider cannot go on along the path.
    Blocked {
        /// How many obstacles it named.
        n_obstacles: usize,
    },
    /// Remembered obstacles were removed.
    Forgot {
        /// How many.
        n_obstacles: usize,
        /// Why.
        reason: &'static str,
    },
    /// A waypoint was reached.
    Arrived(Point2),
    /// A goal cannot be reached.
    Unreachable {
        /// Why.
        reason: String,
    },
    /// The robot should be on its way, and made none for `mission.stuck_after_s`.
    Stuck {
        /// Where it stands, in the map.
        position: Point2,
        /// What range sensors see nearest to its hull: where in the map, and meters from the hull.
        closest: Option<(Point2, f64)>,
    },
    /// A goal took too long.
    TimedOut,
    /// The first news of the person that the robot follows, or the first after a silence.
    PersonFound(Point2),
    /// There is no news of the person for `mission.follow.lost_after_s`: the robot waits.
    PersonLost {
        /// Where the person was last, in the map.
        last: Option<Point2>,
        /// How long ago that was heard, or the run began.
        silent_for: Span,
    },
    /// The robot is with the person, and waits.
    PersonReached(Point2),
    /// The lost robot was found.
    Relocalized,
    /// The relocalizer gave up: the robot is lost as before.
    NotFound,
    /// The guard changed a command.
    Guard(Intervention),
    /// A stage failed; the robot stops.
    StageFailed {
        /// Name of the stage.
        stage: String,
        /// What it said.
        error: String,
    },
    /// The world has something to tell.
    Notice(String),
    /// A stage was too slow for its observations: some were dropped before it saw them.
    Overflow {
        /// Name of the stage.
        stage: String,
        /// How many were lost.
        n_lost: u64,
    },
}

/// Why the guard changed a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Intervention {
    /// The command was not finite.
    NotFinite,
    /// It was faster than the robot may go.
    TooFast,
    /// The drive cannot move like that.
    Infeasible,
    /// A sensor or the estimate is too old.
    Stale,
    /// A stage failed in this step.
    StageFailed,
    /// An obstacle is inside the stopping distance.
    StopZone,
    /// The step began too late.
    Deadline,
}

impl Intervention {
    /// All of them.
    pub const ALL: [Intervention; 7] = [
        Intervention::NotFinite,
        Intervention::TooFast,
        Intervention::Infeasible,
        Intervention::Stale,
        Intervention::StageFailed,
        Intervention::StopZone,
        Intervention::Deadline,
    ];
}

impl fmt::Display for Intervention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Intervention::NotFinite => "the command was not finite",
            Intervention::TooFast => "the command was too fast",
            Intervention::Infeasible => "the drive cannot move like that",
            Intervention::Stale => "a sensor or the estimate is too old",
            Intervention::StageFailed => "a stage failed",
            Intervention::Deadline => "the step began too late",
            Intervention::StopZone => "an obstacle is inside the stopping distance",
        })
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EventKind::State { from, to } => write!(f, "{from} -> {to}"),
            EventKind::Status(status) => write!(f, "the localizer is {status:?}"),
            EventKind::Refused { command, state } => write!(f, "`{command}` refused while {state}"),
            EventKind::GoalAccepted(goal) => write!(f, "goal ({:.2}, {:.2}) m", goal.x, goal.y),
            EventKind::PlanRequested { replans: 0 } => write!(f, "asked for a path"),
            EventKind::PlanRequested { replans } => write!(f, "asked for a new path ({replans})"),
            EventKind::PlanFound { length_m } => write!(f, "path of {length_m:.2} m"),
            EventKind::PlanFailed { reason } => write!(f, "no path: {reason}"),
            EventKind::FallbackAsked { reason } => write!(f, "second planner asked, since {reason}"),
            EventKind::Blocked { n_obstacles } => write!(f, "blocked by {n_obstacles} obstacle points"),
            EventKind::Forgot { n_obstacles, reason } => {
                write!(f, "forgot {n_obstacles} obstacle points: {reason}")
            }
            EventKind::Arrived(goal) => write!(f, "arrived at ({:.2}, {:.2}) m", goal.x, goal.y),
            EventKind::Unreachable { reason } => write!(f, "unreachable: {reason}"),
            EventKind::Stuck { position, closest } => {
                write!(f, "stuck at ({:.2}, {:.2}) m", position.x, position.y)?;
                match closest {
                    Some((at, off_m)) => {
                        write!(
                            f,
                            ", closest obstacle at ({:.2}, {:.2}) m, {off_m:.2} m off the hull",
                            at.x, at.y
                        )
                    }
                    None => write!(f, ", no obstacle in view"),
                }
            }
            EventKind::TimedOut => write!(f, "the goal took too long"),
            EventKind::PersonFound(at) => write!(f, "the person is at ({:.2}, {:.2}) m", at.x, at.y),
            EventKind::PersonLost { last, silent_for } => {
                write!(f, "no news of the person for {:.1} s", silent_for.as_secs())?;
                match last {
                    Some(at) => write!(f, ", who was at ({:.2}, {:.2}) m", at.x, at.y),
                    None => write!(f, ", and never any"),
                }
            }
            EventKind::PersonReached(at) => write!(f, "with the person at ({:.2}, {:.2}) m", at.x, at.y),
            EventKind::Relocalized => write!(f, "the lost robot was found"),
            EventKind::NotFound => write!(f, "the robot was not found"),
            EventKind::Guard(intervention) => write!(f, "guard: {intervention}"),
            EventKind::StageFailed { stage, error } => write!(f, "{stage} failed: {error}"),
            EventKind::Notice(text) => f.write_str(text),
            EventKind::Overflow { stage, n_lost } => {
                write!(f, "{stage} was too slow: {n_lost} observations lost")
            }
        }
    }
}
