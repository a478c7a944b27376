//! The functions of each stage. Instances are used by one thread at a time, not always the same.

use super::basic::rumbo_error;
use super::inputs::{
    rumbo_avoid_input, rumbo_bytes_out, rumbo_call, rumbo_candidate_out, rumbo_estimate, rumbo_observations,
    rumbo_obstacle_out, rumbo_path_out, rumbo_plan_request, rumbo_prior, rumbo_steering,
    rumbo_trajectory_out, rumbo_world,
};
use super::map::{rumbo_map, rumbo_map_mut};
use super::observation::rumbo_seen;
use std::ffi::c_void;

/// Functions of a planner.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_planner_table {
    /// Bytes of this struct.
    pub size: usize,
    /// Ends an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Pushes a path from start to goal, or says why there is none.
    pub plan: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            request: *const rumbo_plan_request,
            path: *mut rumbo_path_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}

/// Functions of an avoider.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_avoider_table {
    /// Bytes of this struct.
    pub size: usize,
    /// Ends an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// What to do until the next call.
    pub steer: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            input: *const rumbo_avoid_input,
            steering: *mut rumbo_steering,
            obstacles: *mut rumbo_obstacle_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}

/// Functions of a localizer.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_localizer_table {
    /// Bytes of this struct.
    pub size: usize,
    /// Ends an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Begins anew from what is known now.
    pub start: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            prior: *const rumbo_prior,
            map: *const rumbo_map,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Takes in what was seen and fills `estimate`, which comes as that of a lost robot.
    pub update: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            seen: *const rumbo_seen,
            map: *const rumbo_map,
            estimate: *mut rumbo_estimate,
            candidates: *mut rumbo_candidate_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}

/// Functions of a map builder.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_map_builder_table {
    /// Bytes of this struct.
    pub size: usize,
    /// Ends an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Prepares its layers.
    pub start: Option<
        unsafe extern "C" fn(instance: *mut c_void, map: *mut rumbo_map_mut, error: *mut rumbo_error) -> i32,
    >,
    /// Adds what was seen.
    pub insert: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            seen: *const rumbo_seen,
            estimate: *const rumbo_estimate,
            map: *mut rumbo_map_mut,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Asked when somebody saves the map: brings what only a whole visit tells into `map`, which is what will be saved, and
    /// pushes what must be kept beside it until the next visit, or nothing; may be null. Since ABI 1.1.
    pub save: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            map: *mut rumbo_map_mut,
            bytes: *mut rumbo_bytes_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}

/// Functions of a plugin that builds the map and finds the robot in it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_slam_table {
    /// Bytes of this struct.
    pub size: usize,
    /// Ends an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Begins anew and prepares its layers.
    pub start: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            prior: *const rumbo_prior,
            map: *mut rumbo_map_mut,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Takes in what was seen, writes its layers and fills `estimate`.
    pub update: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            seen: *const rumbo_seen,
            map: *mut rumbo_map_mut,
            estimate: *mut rumbo_estimate,
            candidates: *mut rumbo_candidate_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Writes its whole state, to continue from later; may be null.
    pub save: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            bytes: *mut rumbo_bytes_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Pushes where the robot was at all scans, as it is known now, oldest first; null where it does not keep that.
    /// Since ABI 1.1.
    pub trajectory: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            poses: *mut rumbo_trajectory_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Is told where the robot is in the map that it has built (`RUMBO_PRIOR_POSE`), or that it may be anywhere in it
    /// (`RUMBO_PRIOR_UNKNOWN`). The map stays; a pose is where the next match begins. Null where it cannot be told.
    /// Since ABI 1.1.
    pub relocate: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            prior: *const rumbo_prior,
            map: *mut rumbo_map_mut,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Asked when somebody saves the map: brings its layers of `map`, which is what will be saved, to the poses of
    /// `trajectory`; null where its map is always so. Since ABI 1.1.
    pub save_map: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            map: *mut rumbo_map_mut,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}

/// Functions of a sensor.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_sensor_table {
    /// Bytes of this struct.
    pub size: usize,
    /// Ends an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Reads what is there now; never blocks.
    pub poll: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            world: *mut rumbo_world,
            out: *mut rumbo_observations,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// As `poll` for a virtual sensor: makes something of what its inputs saw; may be null.
    pub derive: Option<
        unsafe extern "C" fn(
            instance: *mut c_void,
            call: *const rumbo_call,
            inputs: *const rumbo_seen,
            out: *mut rumbo_observations,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}
