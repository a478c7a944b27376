//! What the robot is to do, and what a pipeline's own tests expect of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A place to pass or to reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Waypoint {
    /// In the map's frame, meters.
    pub x_m: f64,
    /// In the map's frame, meters.
    pub y_m: f64,
    /// Which way to look there, degrees; free where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_deg: Option<f64>,
}

/// What the localizer is told at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InitialPose {
    /// A word.
    WellKnown(WellKnownPose),
    /// A place that an operator would point at.
    Pose {
        /// In the map's frame, meters.
        x_m: f64,
        /// In the map's frame, meters.
        y_m: f64,
        /// Which way the robot looks, degrees.
        #[serde(default)]
        yaw_deg: f64,
    },
}

/// Words for an initial pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WellKnownPose {
    /// Where the world puts the robot, if it says so.
    #[default]
    World,
    /// The robot may be anywhere.
    Unknown,
}

/// The table `[mission]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mission {
    /// Where to go, one after the other.
    pub waypoints: Vec<Waypoint>,
    /// A scripted drive instead of waypoints: a table (CSV) with the columns `t_s`, `forward_m_s`, `turn_deg_s` and, for
    /// robots that can, `left_m_s`, relative to the pipeline's folder. Each velocity holds until the next, as far as the
    /// guard lets it; the drive ends at the last `t_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commands: Option<PathBuf>,
    /// A person to follow instead of waypoints: `{ sensor = "phone" }` with the name of a sensor that says where somebody
    /// is. The run lasts for `[world] duration_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub follow: Option<Follow>,
    /// Within this distance of a waypoint that is not the last one the robot goes on to the next, meters; 0 means that
    /// it arrives at each.
    pub switch_radius_m: f64,
    /// Within this distance a goal counts as reached, meters.
    pub arrival_radius_m: f64,
    /// A goal that takes longer is given up, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal_timeout_s: Option<f64>,
    /// The whole mission may take this long, seconds of the world's time.
    pub time_limit_s: f64,
    /// What the localizer is told at the start: `"world"`, `"unknown"`, or a pose.
    pub initial_pose: InitialPose,
    /// Standard deviation of the initial position, meters.
    pub initial_deviation_m: f64,
    /// Standard deviation of the initial yaw, degrees.
    pub initial_deviation_deg: f64,
    /// An obstacle that nothing has seen for this long may be forgotten when no way is left, seconds.
    pub obstacle_memory_s: f64,
    /// When what was found on the way leaves no way, the robot stands and asks again for so long, seconds: somebody may
    /// be walking by.
    pub patience_s: f64,
    /// Remove remembered obstacles that a range sensor now sees through.
    pub forget_seen_through: bool,
    /// New plans for one goal at the most; absent for no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_replans: Option<u32>,
    /// A robot that is on its way and makes less than `stuck_within_m` of it in so long is stuck, seconds: that is an event
    /// with its place and the closest obstacle. With a planner it asks for a new path, and ends as `stuck` after the
    /// sixth time in one place; without one it ends as `stuck` at once. A turn is no progress: take more time than the
    /// robot needs to turn round. Absent: nobody watches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stuck_after_s: Option<f64>,
    /// Less than this is no progress, by the map and by the odometer, meters.
    pub stuck_within_m: f64,
}

/// A person to follow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Follow {
    /// Name of the sensor that says where the person is, such as one with `plugin = "person_tracker"`. Absent: the positions
    /// come as orders (`person_at`) of the program that runs the engine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
    /// This near the robot stops, from its middle to the person's position, meters; `arrival_radius_m` where that is more.
    pub stop_distance_m: f64,
    /// A person who is ahead leaves a position to pass behind after each so many meters.
    pub spacing_m: f64,
    /// Within this distance such a position is passed, and the robot goes on to the next, meters.
    pub pass_radius_m: f64,
    /// Without news for so long the person is lost, and the robot waits, seconds.
    pub lost_after_s: f64,
}

impl Default for Follow {
    fn default() -> Self {
        Follow { sensor: None, stop_distance_m: 0.5, spacing_m: 0.7, pass_radius_m: 0.7, lost_after_s: 5.0 }
    }
}

impl Mission {
    /// There is somewhere to go.
    pub fn has_goals(&self) -> bool {
        !self.waypoints.is_empty() || self.follow.is_some()
    }
}

impl Default for Mission {
    fn default() -> Self {
        Mission {
            waypoints: Vec::new(),
            commands: None,
            follow: None,
            switch_radius_m: 0.0,
            arrival_radius_m: 0.10,
            goal_timeout_s: None,
            time_limit_s: 3600.0,
            initial_pose: InitialPose::WellKnown(WellKnownPose::World),
            initial_deviation_m: 0.05,
            initial_deviation_deg: 2.0,
            obstacle_memory_s: 60.0,
            patience_s: 10.0,
            forget_seen_through: true,
            max_replans: None,
            stuck_after_s: None,
            stuck_within_m: 0.2,
        }
    }
}

/// One `[[test]]` of a pipeline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PipelineTest {
    /// What it shows, as a sentence.
    pub name: String,
    /// Seed in place of the pipeline's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// What must be true at the end.
    pub expect: Expect,
}

/// What must be true at the end of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Expect {
    /// All waypoints are reached within this time, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arrives_within_s: Option<f64>,
    /// The run ends for this reason (`arrived`, `unreachable`, `timeout`, `ended`, ...).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Distance from the true end to the goal at the most, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal_error_m: Option<f64>,
    /// Distance from the last estimate to the truth at the most, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_error_m: Option<f64>,
    /// Angle from the last estimate's heading to the true one at the most, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_heading_error_deg: Option<f64>,
    /// Root mean square of the distance from estimate to truth at the most, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_error_m: Option<f64>,
    /// 95 % of the distances from estimate to truth are at most this, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p95_error_m: Option<f64>,
    /// Free space on the map at the end at the least, m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_free_at_least_m2: Option<f64>,
    /// Free space on the map at the end at the most, m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_free_at_most_m2: Option<f64>,
    /// The hull touches nothing.
    pub no_contact: bool,
    /// Hull to obstacle at the least, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_clearance_m: Option<f64>,
    /// New plans at the least.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replans_at_least: Option<u32>,
    /// New plans at the most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replans_at_most: Option<u32>,
}
