//! What stages are given and what they answer.

use super::basic::{rumbo_point, rumbo_pose2, rumbo_pose3, rumbo_str, rumbo_twist};
use super::map::{rumbo_grid, rumbo_map};
use super::module::{rumbo_give_up, rumbo_robot};
use super::observation::{rumbo_intrinsics, rumbo_marks, rumbo_seen};
use std::ffi::c_void;

/// Debug drawings and counters of one call.
#[repr(C)]
pub struct rumbo_trace {
    _private: [u8; 0],
}

/// What every call gets.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_call {
    /// Bytes of this struct.
    pub size: usize,
    /// The time it is, nanoseconds: the only clock a plugin may read.
    pub now_ns: i64,
    /// Where to draw.
    pub trace: *mut rumbo_trace,
    /// 1 while somebody looks at drawings and counters.
    pub is_watched: u32,
    /// 0.
    pub reserved: u32,
}

/// Status of an estimate: no idea where the robot is.
pub const RUMBO_LOST: u32 = 0;
/// Status of an estimate: on the way to one answer.
pub const RUMBO_CONVERGING: u32 = 1;
/// Status of an estimate: one answer, kept up to date.
pub const RUMBO_TRACKING: u32 = 2;
/// Status of an estimate: several places fit.
pub const RUMBO_AMBIGUOUS: u32 = 3;
/// No wish.
pub const RUMBO_WISH_NONE: u32 = 0;
/// It would help to stand still.
pub const RUMBO_WISH_HOLD_STILL: u32 = 1;
/// It would help to turn by `wish` radians.
pub const RUMBO_WISH_TURN_BY: u32 = 2;
/// It would help to drive ahead by `wish` meters.
pub const RUMBO_WISH_MOVE_BY: u32 = 3;

/// A place that fits what was seen.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_candidate {
    /// The place.
    pub map_from_base: rumbo_pose2,
    /// How well it fits; all scores of one estimate sum to 1.
    pub score: f64,
}

/// Where the robot is.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_estimate {
    /// Bytes of this struct.
    pub size: usize,
    /// The time this is true for, nanoseconds.
    pub stamp_ns: i64,
    /// The correction of the odometer.
    pub map_from_odom: rumbo_pose3,
    /// The robot.
    pub map_from_base: rumbo_pose3,
    /// Covariance of x, y, z, roll, pitch, yaw in the map's axes, row by row.
    pub covariance: [f64; 36],
    /// `RUMBO_TRACKING`, ...
    pub status: u32,
    /// `RUMBO_WISH_NONE`, ...
    pub wish_kind: u32,
    /// How far, radians or meters.
    pub wish: f64,
    /// Number of candidates; an answer pushes its own into the `candidates` of the call.
    pub n_candidates: usize,
    /// Places that fit, best first.
    pub candidates: *const rumbo_candidate,
}

/// One point of a path.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_path_point {
    /// Where, in the map's frame.
    pub position: rumbo_point,
    /// Which way to look there, radians; not-a-number where that is free.
    pub yaw_rad: f64,
}

/// A way from start to goal.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_path {
    /// Bytes of this struct.
    pub size: usize,
    /// What the planner minimized.
    pub cost: f64,
    /// Number of points, at least 1.
    pub len: usize,
    /// The points.
    pub points: *const rumbo_path_point,
}

/// Something in the way that the map does not show.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_obstacle {
    /// Its middle in the map's frame.
    pub position: rumbo_point,
    /// Its radius, meters; zero for a single point.
    pub radius_m: f64,
    /// When it was last seen, nanoseconds.
    pub stamp_ns: i64,
}

/// What a planner gets.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_plan_request {
    /// Bytes of this struct.
    pub size: usize,
    /// The map, without obstacles.
    pub map: *const rumbo_map,
    /// The map's grid with all obstacles as occupied; null where the map has no grid.
    pub grid: *const rumbo_grid,
    /// The robot in the map.
    pub start: rumbo_pose2,
    /// Where to.
    pub goal: rumbo_point,
    /// Which way to look at the end, radians; not-a-number where that is free.
    pub goal_yaw_rad: f64,
    /// The robot.
    pub robot: *const rumbo_robot,
    /// Number of obstacles.
    pub n_obstacles: usize,
    /// What is in the way and not on the map.
    pub obstacles: *const rumbo_obstacle,
    /// Raised when nobody waits any more: ask `give_up_is_raised` at least every 1,000 expansions.
    pub give_up: *const rumbo_give_up,
}

/// What an avoider gets.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_avoid_input {
    /// Bytes of this struct.
    pub size: usize,
    /// The robot in the map, now.
    pub map_from_base: rumbo_pose2,
    /// Velocity of the base by the odometer.
    pub twist: rumbo_twist,
    /// The last estimate.
    pub estimate: *const rumbo_estimate,
    /// Observations since the last call.
    pub seen: *const rumbo_seen,
    /// The map.
    pub map: *const rumbo_map,
    /// The map's grid with the known obstacles; may be null.
    pub grid: *const rumbo_grid,
    /// The path; null while the robot wanders without a goal.
    pub path: *const rumbo_path,
    /// Goes up with every new path.
    pub path_number: u64,
    /// Distance at which the path's end counts as reached, meters.
    pub arrival_radius_m: f64,
    /// Number of obstacles.
    pub n_obstacles: usize,
    /// Obstacles that the navigator remembers.
    pub obstacles: *const rumbo_obstacle,
    /// The robot.
    pub robot: *const rumbo_robot,
}

/// Steering: drive with `twist`.
pub const RUMBO_DRIVE: u32 = 0;
/// Steering: stop, something is in the way; push what it is into the obstacles of the call.
pub const RUMBO_BLOCKED: u32 = 1;
/// Steering: the end of the path is reached.
pub const RUMBO_ARRIVED: u32 = 2;

/// What an avoider wants.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_steering {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_DRIVE`, `RUMBO_BLOCKED` or `RUMBO_ARRIVED`.
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// How to drive.
    pub twist: rumbo_twist,
}

/// The robot may be anywhere.
pub const RUMBO_PRIOR_UNKNOWN: u32 = 0;
/// The robot is about here.
pub const RUMBO_PRIOR_POSE: u32 = 1;
/// What the same plugin saved before.
pub const RUMBO_PRIOR_SAVED: u32 = 2;

/// What a localizer is told when it starts.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_prior {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_PRIOR_UNKNOWN`, ...
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// The robot in the map.
    pub map_from_base: rumbo_pose2,
    /// The odometer's reading at that time.
    pub odom_from_base: rumbo_pose2,
    /// Covariance of x, y, yaw, row by row.
    pub covariance: [f64; 9],
    /// What was saved.
    pub saved: super::basic::rumbo_u8_array,
}

/// Takes the points of a path, in order.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_path_out {
    /// Bytes of this struct.
    pub size: usize,
    /// For `push`.
    pub ctx: *mut c_void,
    /// Appends `len` points.
    pub push: Option<unsafe extern "C" fn(ctx: *mut c_void, points: *const rumbo_path_point, len: usize)>,
    /// What the planner minimized; write it here.
    pub cost: f64,
}

/// Takes obstacles.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_obstacle_out {
    /// Bytes of this struct.
    pub size: usize,
    /// For `push`.
    pub ctx: *mut c_void,
    /// Appends `len` obstacles.
    pub push: Option<unsafe extern "C" fn(ctx: *mut c_void, obstacles: *const rumbo_obstacle, len: usize)>,
}

/// Takes candidates, best first.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_candidate_out {
    /// Bytes of this struct.
    pub size: usize,
    /// For `push`.
    pub ctx: *mut c_void,
    /// Appends `len` candidates.
    pub push: Option<unsafe extern "C" fn(ctx: *mut c_void, candidates: *const rumbo_candidate, len: usize)>,
}

/// Where the robot was at a time.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_stamped_pose {
    /// When, nanoseconds.
    pub stamp_ns: i64,
    /// The robot in the map.
    pub map_from_base: rumbo_pose3,
}

/// Takes the poses of a trajectory, oldest first.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_trajectory_out {
    /// Bytes of this struct.
    pub size: usize,
    /// For `push`.
    pub ctx: *mut c_void,
    /// Appends `len` poses.
    pub push: Option<unsafe extern "C" fn(ctx: *mut c_void, poses: *const rumbo_stamped_pose, len: usize)>,
}

/// Takes text or bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_bytes_out {
    /// Bytes of this struct.
    pub size: usize,
    /// For `push`.
    pub ctx: *mut c_void,
    /// Appends bytes.
    pub push: Option<unsafe extern "C" fn(ctx: *mut c_void, bytes: rumbo_str)>,
}

/// The world as a sensor may ask it.
#[repr(C)]
pub struct rumbo_world {
    _private: [u8; 0],
}

/// Takes what a sensor sees, through `observe` of the host table.
#[repr(C)]
pub struct rumbo_observations {
    _private: [u8; 0],
}

/// Probe: exact distances along beams; the answer is `RUMBO_ANSWER_RANGES`.
pub const RUMBO_PROBE_BEAMS: u32 = 0;
/// Probe: nearest echo in cones; the answer is `RUMBO_ANSWER_RANGES`.
pub const RUMBO_PROBE_CONES: u32 = 1;
/// Probe: a depth picture; the answer is `RUMBO_ANSWER_RANGES`.
pub const RUMBO_PROBE_DEPTH: u32 = 2;
/// Probe: how far the wheels have turned.
pub const RUMBO_PROBE_WHEELS: u32 = 3;
/// Probe: attitude, rates, accelerations.
pub const RUMBO_PROBE_ATTITUDE: u32 = 4;
/// Probe: the position in the map's frame.
pub const RUMBO_PROBE_POSITION: u32 = 5;
/// Probe: where the hull touches something.
pub const RUMBO_PROBE_CONTACTS: u32 = 6;
/// Probe: marks in view.
pub const RUMBO_PROBE_MARKS: u32 = 7;
/// Probe: what was recorded under `name` since the last such probe.
pub const RUMBO_PROBE_CHANNEL: u32 = 8;
/// Probe: where the person called `name` is in the map's frame; the answer is `RUMBO_ANSWER_POSITION`.
pub const RUMBO_PROBE_PERSON: u32 = 9;

/// What a sensor asks the world; fields that the kind does not name are ignored.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_probe {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_PROBE_BEAMS`, ...
    pub kind: u32,
    /// Beams: how many.
    pub n_beams: u32,
    /// The mount (beams, cones, depth, marks).
    pub base_from_sensor: rumbo_pose3,
    /// Beams: bearing of the first, radians.
    pub first_bearing_rad: f64,
    /// Beams: from one to the next, radians.
    pub bearing_step_rad: f64,
    /// Beyond this nothing is seen, meters (beams, cones, depth, marks).
    pub max_range_m: f64,
    /// Cones: how many.
    pub n_cones: usize,
    /// Cones: bearing of each axis, radians.
    pub bearings_rad: *const f64,
    /// Cones: full opening, radians.
    pub cone_rad: f64,
    /// Cones: distance of the transducers from the mount, meters.
    pub ring_radius_m: f64,
    /// Depth: the camera.
    pub intrinsics: rumbo_intrinsics,
    /// Marks: full field of view, radians.
    pub field_of_view_rad: f64,
    /// Channel, person: its name.
    pub name: rumbo_str,
}

/// Answer: `ranges`.
pub const RUMBO_ANSWER_RANGES: u32 = 0;
/// Answer: `rolled_m` and what follows it.
pub const RUMBO_ANSWER_WHEELS: u32 = 1;
/// Answer: `attitude_rad`, `rates_rad_s`, `accelerations_m_s2`.
pub const RUMBO_ANSWER_ATTITUDE: u32 = 2;
/// Answer: `position_m`.
pub const RUMBO_ANSWER_POSITION: u32 = 3;
/// Answer: `contacts_rad`.
pub const RUMBO_ANSWER_CONTACTS: u32 = 4;
/// Answer: `marks`.
pub const RUMBO_ANSWER_MARKS: u32 = 5;
/// Answer: `recorded`.
pub const RUMBO_ANSWER_RECORDED: u32 = 6;
/// Answer: read your own device.
pub const RUMBO_ANSWER_LIVE: u32 = 7;

/// What the world answers. Pointers hold until the next probe or the end of the call.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_answer {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_ANSWER_RANGES`, ...
    pub kind: u32,
    /// Wheels: how many of `rolled_m` are used.
    pub n_wheels: u32,
    /// Number of ranges.
    pub n_ranges: usize,
    /// One distance each, meters; infinite where nothing is within reach.
    pub ranges_m: *const f32,
    /// Distance rolled by each wheel, meters.
    pub rolled_m: [f64; 4],
    /// Turn of an omnidirectional base, radians.
    pub turned_rad: f64,
    /// Steering angle, radians.
    pub steering_rad: f64,
    /// Velocity of the base as its wheels have it.
    pub twist: rumbo_twist,
    /// Roll, pitch, yaw, radians.
    pub attitude_rad: [f64; 3],
    /// Turning rates, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Specific force, m/s².
    pub accelerations_m_s2: [f64; 3],
    /// x, y, z in the map's frame, meters.
    pub position_m: [f64; 3],
    /// Number of contacts.
    pub n_contacts: usize,
    /// Bearings of contacts in the base frame, radians.
    pub contacts_rad: *const f64,
    /// Marks, exact; else null.
    pub marks: *const rumbo_marks,
    /// Recorded observations, oldest first; else null.
    pub recorded: *const rumbo_seen,
}
