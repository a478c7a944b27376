//! Observers see every step and can change nothing.

use super::events::Event;
use super::order::{Order, State};
use super::timing::StageTimes;
use crate::frames::{Pose2, Pose3};
use crate::map::Map;
use crate::messages::{Command, Estimate, Goal, Observation, Obstacle, Path};
use crate::stages::Truth;
use crate::time::Time;
use crate::trace::Drawing;

/// Somebody who watches: progress, metrics, recording, pictures.
pub trait Observer {
    /// Called at the end of every step.
    fn on_step(&mut self, view: &StepView<'_>);
}

/// One step, as it ended.
#[derive(Debug, Clone, Copy)]
pub struct StepView<'a> {
    /// The time it is.
    pub now: Time,
    /// When the run began.
    pub started: Time,
    /// How many steps there were before this one.
    pub step: u64,
    /// State of the mission's automaton.
    pub state: State,
    /// Observations that came in with this step.
    pub observations: &'a [Observation],
    /// The last estimate.
    pub estimate: &'a Estimate,
    /// The estimate is of this step.
    pub estimate_is_new: bool,
    /// The robot in the map: the last estimate moved on by the odometer.
    pub map_from_base: Pose2,
    /// The odometer.
    pub odom_from_base: Pose2,
    /// The body over its place on the floor, as the odometer seat said last: height, roll and pitch; none without that seat.
    #[doc(alias = "base_stabilized")]
    pub footprint_from_base: Option<Pose3>,
    /// Which sensors derive from others, in the order of their numbers: what they say may have been leveled.
    pub derived: &'a [bool],
    /// Where the robot really is, where the world knows.
    pub truth: Option<&'a Truth>,
    /// What went to the wheels last.
    pub command: &'a Command,
    /// The world did not take the last command: it is a recording.
    pub not_actuated: bool,
    /// Orders from outside that were obeyed or refused in this step.
    pub orders: &'a [Order],
    /// The path that is followed.
    pub path: Option<&'a Path>,
    /// Goes up with every new path.
    pub path_number: u64,
    /// Where the robot is going.
    pub goal: Option<&'a Goal>,
    /// Goals left, the present one included.
    pub n_goals_left: usize,
    /// Remembered obstacles.
    pub obstacles: &'a [Obstacle],
    /// The map.
    pub map: &'a Map,
    /// Debug drawings of the last plan, if anybody looks.
    pub drawings: &'a [Drawing],
    /// Debug drawings of the other stages in this step, if anybody looks.
    pub stage_drawings: &'a [Drawing],
    /// Counters of the stages in this step, if anybody looks.
    pub counters: &'a [(&'static str, f64)],
    /// What happened in this step.
    pub events: &'a [Event],
    /// Wall time that each stage has used so far.
    pub times: &'a StageTimes,
}
