//! An avoider as functions.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    BadView, estimate_from, map_from, observations_from, obstacle_of, obstacles_from, optional_grid_from,
    path_from, pose2_from, read, robot_from, slice, twist_from, twist_of,
};
use super::super::status::Crosses as _;
use super::call::{Call, bad};
use super::guard::{destroy, guarded};
use crate::messages::{Observation, Obstacle, Path, Seen};
use crate::robot::Robot;
use crate::stages::{AvoidInput, Avoider, Steering};
use std::ffi::c_void;
use std::sync::Arc;

/// Functions of every avoider.
pub(super) static TABLE: rumbo_avoider_table = rumbo_avoider_table {
    size: size_of::<rumbo_avoider_table>(),
    destroy: Some(destroy::<Side>),
    steer: Some(steer),
};

struct Side {
    avoider: Box<dyn Avoider>,
    robot: Arc<Robot>,
    seen: Vec<Observation>,
    obstacles: Vec<Obstacle>,
    path: Option<(u64, usize, Path)>,
}

/// An instance as the host keeps it.
pub(super) fn this(avoider: Box<dyn Avoider>, robot: Arc<Robot>) -> *mut c_void {
    let (seen, obstacles) = (Vec::new(), Vec::new());
    Box::into_raw(Box::new(Side { avoider, robot, seen, obstacles, path: None })).cast()
}

unsafe extern "C" fn steer(
    this: *mut c_void,
    call: *const rumbo_call,
    input: *const rumbo_avoid_input,
    steering: *mut rumbo_steering,
    obstacles: *mut rumbo_obstacle_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let (Some(side), Ok(call), Some(input)) =
                (this.cast::<Side>().as_mut(), Call::from(call), read(input))
            else {
                return RUMBO_ERROR;
            };
            let steered = side.steer(&call, &input);
            // References to the host's arrays must not outlive the call: they would make the host copy.
            side.seen.clear();
            call.hand_on();
            match steered {
                Ok(Ok(steered)) => answer(&steered, steering, obstacles),
                Ok(Err(why)) => why.cross(error),
                Err(view) => bad(&view, error),
            }
        })
    }
}

type Steered = Result<Steering, crate::stages::AvoidError>;

impl Side {
    /// # Safety
    /// `input` is the one of the present call.
    unsafe fn steer(&mut self, call: &Call, input: &rumbo_avoid_input) -> Result<Steered, BadView> {
        // SAFETY: for all blocks below: as promised by the caller.
        unsafe { observations_from(input.seen, &mut self.seen)? };
        self.obstacles.clear();
        unsafe { obstacles_from(input.obstacles, input.n_obstacles, &mut self.obstacles)? };
        self.robot = unsafe { robot_from(input.robot, Some(&self.robot))? };
        unsafe { self.take_path(input)? };
        let estimate = unsafe { estimate_from(input.estimate)? };
        let map = unsafe { map_from(input.map)? };
        let grid = unsafe { optional_grid_from(input.grid)? };
        let input = AvoidInput {
            map_from_base: pose2_from(&input.map_from_base, "map_from_base")?,
            estimate: &estimate,
            twist: twist_from(&input.twist),
            seen: Seen::sorted(&self.seen),
            map: &map,
            grid: grid.as_ref(),
            path: self.path.as_ref().map(|(.., path)| path).filter(|_| !input.path.is_null()),
            path_number: input.path_number,
            arrival_radius_m: input.arrival_radius_m,
            obstacles: &self.obstacles,
            robot: &self.robot,
        };
        Ok(self.avoider.steer(&mut call.cx(), &input))
    }

    /// Keeps the path until another one comes: paths are long, and calls are many.
    ///
    /// # Safety
    /// `input` is the one of the present call.
    unsafe fn take_path(&mut self, input: &rumbo_avoid_input) -> Result<(), BadView> {
        // SAFETY: as promised by the caller.
        let Some(view) = (unsafe { read(input.path) }) else { return Ok(()) };
        let which = (input.path_number, view.points.addr());
        let is_known = |(number, at, path): &(u64, usize, Path)| {
            (*number, *at) == which && path.points().len() == view.len && path.cost == view.cost
        };
        if !self.path.as_ref().is_some_and(is_known) {
            // SAFETY: as promised by the caller.
            let path = path_from(unsafe { slice(view.points, view.len)? }, view.cost);
            self.path = path.map(|path| (which.0, which.1, path));
        }
        Ok(())
    }
}

/// # Safety
/// `steering` and `obstacles` are the outputs of the present call.
unsafe fn answer(
    steered: &Steering,
    steering: *mut rumbo_steering,
    obstacles: *mut rumbo_obstacle_out,
) -> i32 {
    // SAFETY: for all blocks below: as promised by the caller.
    let Some(to) = (unsafe { steering.as_mut() }) else { return RUMBO_ERROR };
    match steered {
        Steering::Drive(twist) => (to.kind, to.twist) = (RUMBO_DRIVE, twist_of(*twist)),
        Steering::Arrived => to.kind = RUMBO_ARRIVED,
        Steering::Blocked { obstacles: found } => {
            to.kind = RUMBO_BLOCKED;
            let Some((out, push)) = unsafe { read(obstacles) }.and_then(|out| Some((out, out.push?))) else {
                return RUMBO_ERROR;
            };
            for obstacle in found {
                let obstacle = obstacle_of(obstacle);
                unsafe { push(out.ctx, &raw const obstacle, 1) };
            }
        }
    }
    RUMBO_OK
}
