//! What a plugin may call back.

use super::basic::{
    rumbo_block, rumbo_f32_array, rumbo_point, rumbo_point3_array, rumbo_str, rumbo_u16_array,
};
use super::inputs::{rumbo_answer, rumbo_observations, rumbo_probe, rumbo_trace, rumbo_world};
use super::map::{rumbo_grid, rumbo_landmark_array, rumbo_line_array, rumbo_map_mut, rumbo_voxel_chunk};
use super::module::{rumbo_config, rumbo_give_up, rumbo_rng};
use super::observation::rumbo_observation;

/// Level of a message: something is wrong.
pub const RUMBO_LOG_ERROR: u32 = 1;
/// Level of a message: something is odd.
pub const RUMBO_LOG_WARN: u32 = 2;
/// Level of a message: worth knowing.
pub const RUMBO_LOG_INFO: u32 = 3;
/// Level of a message: for the author.
pub const RUMBO_LOG_DEBUG: u32 = 4;

/// The host's functions; they may be called from any thread unless they take what a call handed over. Lives as long as
/// the program.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_host {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_ABI_MAJOR` of the host.
    pub abi_major: u32,
    /// `RUMBO_ABI_MINOR` of the host.
    pub abi_minor: u32,
    /// Says something to people: level, who, what.
    pub log: unsafe extern "C" fn(level: u32, target: rumbo_str, message: rumbo_str),

    /// A fresh block for `bytes` bytes of elements, with one reference; null where there is no memory.
    pub block_new: unsafe extern "C" fn(bytes: usize) -> *mut rumbo_block,
    /// Keeps a block.
    pub block_retain: unsafe extern "C" fn(block: *mut rumbo_block),
    /// Drops a block.
    pub block_release: unsafe extern "C" fn(block: *mut rumbo_block),
    /// The array for writing; copied first if anybody else holds it. Null where there is no memory.
    pub make_mut_f32: unsafe extern "C" fn(array: *mut rumbo_f32_array) -> *mut f32,

    /// A number of the parameters (whole numbers too): `RUMBO_OK`, `RUMBO_MISSING` or `RUMBO_BAD_CONFIG`. Paths such as
    /// `weights[2]` or `limits.speed_m_s`.
    pub config_f64: unsafe extern "C" fn(config: *const rumbo_config, path: rumbo_str, out: *mut f64) -> i32,
    /// A whole number of the parameters.
    pub config_i64: unsafe extern "C" fn(config: *const rumbo_config, path: rumbo_str, out: *mut i64) -> i32,
    /// True (1) or false (0) of the parameters.
    pub config_bool: unsafe extern "C" fn(config: *const rumbo_config, path: rumbo_str, out: *mut u32) -> i32,
    /// A text of the parameters, valid as long as they are.
    pub config_str:
        unsafe extern "C" fn(config: *const rumbo_config, path: rumbo_str, out: *mut rumbo_str) -> i32,
    /// How many elements the array there has.
    pub config_len:
        unsafe extern "C" fn(config: *const rumbo_config, path: rumbo_str, out: *mut usize) -> i32,

    /// 64 random bits.
    pub random_u64: unsafe extern "C" fn(rng: *mut rumbo_rng) -> u64,
    /// A number from [0, 1).
    pub random_uniform: unsafe extern "C" fn(rng: *mut rumbo_rng) -> f64,
    /// A number of the standard normal distribution.
    pub random_normal: unsafe extern "C" fn(rng: *mut rumbo_rng) -> f64,

    /// 1 when somebody asked to stop.
    pub give_up_is_raised: unsafe extern "C" fn(flag: *const rumbo_give_up) -> u32,
    /// Keeps a flag longer than the call.
    pub give_up_retain: unsafe extern "C" fn(flag: *const rumbo_give_up),
    /// Drops a flag that was kept.
    pub give_up_release: unsafe extern "C" fn(flag: *const rumbo_give_up),

    /// Draws a chain of straight pieces.
    pub draw_polyline: unsafe extern "C" fn(
        trace: *mut rumbo_trace,
        name: rumbo_str,
        points: *const rumbo_point,
        len: usize,
    ),
    /// Draws points.
    pub draw_points: unsafe extern "C" fn(
        trace: *mut rumbo_trace,
        name: rumbo_str,
        points: *const rumbo_point,
        len: usize,
    ),
    /// Shows a number.
    pub count: unsafe extern "C" fn(trace: *mut rumbo_trace, name: rumbo_str, value: f64),

    /// The time of the world, nanoseconds.
    pub world_now_ns: unsafe extern "C" fn(world: *const rumbo_world) -> i64,
    /// 1 where time passes by itself.
    pub world_is_real_time: unsafe extern "C" fn(world: *const rumbo_world) -> u32,
    /// Asks the world: `RUMBO_OK` and the answer, or `RUMBO_NO_ANSWER` and a text in `why` that holds until the next
    /// probe.
    pub probe: unsafe extern "C" fn(
        world: *mut rumbo_world,
        probe: *const rumbo_probe,
        answer: *mut rumbo_answer,
        why: *mut rumbo_str,
    ) -> i32,

    /// A pooled array of zeros for ranges.
    pub lend_f32: unsafe extern "C" fn(out: *mut rumbo_observations, len: usize) -> rumbo_f32_array,
    /// A pooled array of zeros for depths.
    pub lend_u16: unsafe extern "C" fn(out: *mut rumbo_observations, len: usize) -> rumbo_u16_array,
    /// A pooled array of zeros for points.
    pub lend_point3: unsafe extern "C" fn(out: *mut rumbo_observations, len: usize) -> rumbo_point3_array,
    /// Adds an observation. References of its arrays are given away: `RUMBO_OK`, or `RUMBO_BAD_NUMBER` where the
    /// struct does not hold together, `RUMBO_UNSUPPORTED` where the host does not know its kind; the whole call fails
    /// then.
    pub observe:
        unsafe extern "C" fn(out: *mut rumbo_observations, observation: *const rumbo_observation) -> i32,

    /// Version of the map.
    pub map_version: unsafe extern "C" fn(map: *const rumbo_map_mut) -> u64,
    /// Says that a layer changed: sets the version.
    pub map_set_version: unsafe extern "C" fn(map: *mut rumbo_map_mut, version: u64),
    /// Number of coarser grids.
    pub map_n_coarse: unsafe extern "C" fn(map: *const rumbo_map_mut) -> usize,
    /// Takes the grid (level 0) or the last of the coarser ones (level 1) with its reference; `RUMBO_MISSING` where
    /// there is none.
    pub map_take_grid:
        unsafe extern "C" fn(map: *mut rumbo_map_mut, level: u32, grid: *mut rumbo_grid) -> i32,
    /// Puts the grid (level 0), or one more coarser grid (level 1) behind the others.
    pub map_put_grid:
        unsafe extern "C" fn(map: *mut rumbo_map_mut, level: u32, grid: *const rumbo_grid) -> i32,
    /// Takes the lines.
    pub map_take_lines: unsafe extern "C" fn(map: *mut rumbo_map_mut, lines: *mut rumbo_line_array) -> i32,
    /// Puts the lines.
    pub map_put_lines: unsafe extern "C" fn(map: *mut rumbo_map_mut, lines: *const rumbo_line_array) -> i32,
    /// Takes the landmarks.
    pub map_take_landmarks:
        unsafe extern "C" fn(map: *mut rumbo_map_mut, landmarks: *mut rumbo_landmark_array) -> i32,
    /// Puts the landmarks.
    pub map_put_landmarks:
        unsafe extern "C" fn(map: *mut rumbo_map_mut, landmarks: *const rumbo_landmark_array) -> i32,
    /// Resolution and origin (x, y, z) of the voxels.
    pub map_voxels: unsafe extern "C" fn(
        map: *const rumbo_map_mut,
        resolution_m: *mut f64,
        origin: *mut f64,
        n_chunks: *mut usize,
    ) -> i32,
    /// Takes the last cube of the voxels.
    pub map_take_chunk: unsafe extern "C" fn(map: *mut rumbo_map_mut, chunk: *mut rumbo_voxel_chunk) -> i32,
    /// Makes an empty voxel layer in place of the one that was there.
    pub map_new_voxels:
        unsafe extern "C" fn(map: *mut rumbo_map_mut, resolution_m: f64, origin: *const f64) -> i32,
    /// Puts one more cube behind the others.
    pub map_put_chunk: unsafe extern "C" fn(map: *mut rumbo_map_mut, chunk: *const rumbo_voxel_chunk) -> i32,
    /// Removes a layer (`RUMBO_LAYER_GRID`, ...).
    pub map_remove: unsafe extern "C" fn(map: *mut rumbo_map_mut, layer: u32),
}
