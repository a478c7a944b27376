//! Numbers, words, arrays, and how a call ends.

use std::ffi::c_char;

/// The call did what it should.
pub const RUMBO_OK: i32 = 0;
/// It could not; `message` says why.
pub const RUMBO_ERROR: i32 = 1;
/// The plugin panicked (or threw): this instance is never called again but to destroy it.
pub const RUMBO_PANIC: i32 = 2;
/// A parameter is wrong: `path` names the key, `message` says what was found and expected.
pub const RUMBO_BAD_CONFIG: i32 = 3;
/// There is no such key, and no such thing.
pub const RUMBO_MISSING: i32 = 4;
/// The other side is too old for this.
pub const RUMBO_UNSUPPORTED: i32 = 5;
/// A message holds a number that must not go on.
pub const RUMBO_BAD_NUMBER: i32 = 6;
/// The map lacks a layer; `text` names it.
pub const RUMBO_MISSING_LAYER: i32 = 7;
/// Planner: the goal (`place`) lies outside the map.
pub const RUMBO_GOAL_OUTSIDE: i32 = 20;
/// Planner: the goal (`place`) is `text`: occupied or unknown.
pub const RUMBO_GOAL_OCCUPIED: i32 = 21;
/// Planner: the goal (`place`) is `values[0]` m from an obstacle, the planner keeps `values[1]` m.
pub const RUMBO_GOAL_TOO_CLOSE: i32 = 22;
/// Planner: the start (`place`) lies outside the map.
pub const RUMBO_START_OUTSIDE: i32 = 23;
/// Planner: the start (`place`) is `text`: occupied, unknown or too close.
pub const RUMBO_START_OCCUPIED: i32 = 24;
/// Planner: no way leads to the goal; `text` says what closes it.
pub const RUMBO_UNREACHABLE: i32 = 25;
/// Planner: its search ended at `place`; `text` says why.
pub const RUMBO_STUCK: i32 = 26;
/// Planner: `give_up` was raised.
pub const RUMBO_GIVEN_UP: i32 = 27;
/// Localizer and Slam: cannot start from what it is told; `text` says what it needs.
pub const RUMBO_BAD_PRIOR: i32 = 40;
/// Localizer: it was not started.
pub const RUMBO_NOT_STARTED: i32 = 41;
/// Localizer: it needs the robot to move; `text` says how.
pub const RUMBO_NEEDS_MOTION: i32 = 42;
/// Slam: it has no saved form.
pub const RUMBO_CANNOT_SAVE: i32 = 43;
/// Slam: it cannot be told where the robot is once it has begun (since 1.1).
pub const RUMBO_CANNOT_RELOCATE: i32 = 44;
/// Avoider: no reading of the kind `text` for `values[0]` s.
pub const RUMBO_NO_READING: i32 = 60;
/// Sensor: the device `path` does not answer; `text` says why.
pub const RUMBO_DEVICE: i32 = 80;
/// Sensor: it has inputs but derives nothing.
pub const RUMBO_NOT_VIRTUAL: i32 = 81;
/// Sensor: the world cannot answer the probe.
pub const RUMBO_NO_ANSWER: i32 = 82;
/// Map builder: the file `path` cannot be read; `text` says why.
pub const RUMBO_MAP_FILE: i32 = 100;

/// Text in UTF-8, not ended by a zero; `data` may be null where `len` is 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_str {
    /// First byte.
    pub data: *const c_char,
    /// Number of bytes.
    pub len: usize,
}

/// Why a call did not end with `RUMBO_OK`, filled in by the side that was called. Texts end with a zero; what does not
/// fit is cut off.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_error {
    /// Bytes of this struct.
    pub size: usize,
    /// A place in the map, where the status has one.
    pub place: rumbo_point,
    /// Numbers, where the status has some.
    pub values: [f64; 2],
    /// The key, device or file at fault, such as `weights[2]`; empty for none.
    pub path: [c_char; 256],
    /// The word or reason that the status asks for.
    pub text: [c_char; 512],
    /// What was found and what was expected, for people.
    pub message: [c_char; 1024],
    /// What to do; may be empty.
    pub help: [c_char; 512],
}

/// A point of the map, meters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct rumbo_point {
    /// x, meters.
    pub x_m: f64,
    /// y, meters.
    pub y_m: f64,
}

/// A pose in the plane. The heading as cosine and sine, so that nothing is rounded on the way.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct rumbo_pose2 {
    /// x, meters.
    pub x_m: f64,
    /// y, meters.
    pub y_m: f64,
    /// Cosine of the heading.
    pub cos_yaw: f64,
    /// Sine of the heading.
    pub sin_yaw: f64,
}

/// A pose in space: a position and a unit quaternion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct rumbo_pose3 {
    /// x, y, z, meters.
    pub position_m: [f64; 3],
    /// i, j, k, w of a unit quaternion.
    pub quaternion: [f64; 4],
}

/// Velocity of the base in its own frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct rumbo_twist {
    /// Ahead, m/s.
    pub forward_m_s: f64,
    /// To the left, m/s; zero for robots that cannot.
    pub left_m_s: f64,
    /// Counter-clockwise, rad/s.
    pub turn_rad_s: f64,
}

/// The header of a reference-counted array; its elements start 64 bytes further on. Only the host allocates blocks:
/// `retain` and `release` of the host table keep and drop one.
#[repr(C)]
pub struct rumbo_block {
    _private: [u8; 0],
}

/// A shared array of `float`. As an input it is lent: retain `block` to keep it longer than the call. As an output its
/// reference is given away; with a null `block` the host copies `len` elements from `data`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_f32_array {
    /// The block that holds the elements; null for none.
    pub block: *mut rumbo_block,
    /// Number of elements.
    pub len: usize,
    /// The elements.
    pub data: *const f32,
}

/// A shared array of `uint16_t`, as `rumbo_f32_array`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_u16_array {
    /// The block that holds the elements; null for none.
    pub block: *mut rumbo_block,
    /// Number of elements.
    pub len: usize,
    /// The elements.
    pub data: *const u16,
}

/// A shared array of bytes, as `rumbo_f32_array`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_u8_array {
    /// The block that holds the elements; null for none.
    pub block: *mut rumbo_block,
    /// Number of elements.
    pub len: usize,
    /// The elements.
    pub data: *const u8,
}

/// A shared array of points x, y, z in `float`, as `rumbo_f32_array`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_point3_array {
    /// The block that holds the elements; null for none.
    pub block: *mut rumbo_block,
    /// Number of points.
    pub len: usize,
    /// The points.
    pub data: *const [f32; 3],
}
