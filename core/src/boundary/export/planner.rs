//! A planner as functions.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    BadView, map_from, obstacles_from, optional_grid_from, points_of, pose2_from, read, robot_from,
};
use super::super::status::Crosses as _;
use super::call::{Call, bad, flag_from};
use super::guard::{destroy, guarded};
use crate::frames::Point2;
use crate::messages::{Goal, Path};
use crate::robot::Robot;
use crate::stages::{PlanRequest, Planner};
use std::ffi::c_void;
use std::sync::Arc;

/// Functions of every planner.
pub(super) static TABLE: rumbo_planner_table = rumbo_planner_table {
    size: size_of::<rumbo_planner_table>(),
    destroy: Some(destroy::<Side>),
    plan: Some(plan),
};

struct Side {
    planner: Box<dyn Planner>,
    robot: Arc<Robot>,
    points: Vec<rumbo_path_point>,
}

/// An instance as the host keeps it.
pub(super) fn this(planner: Box<dyn Planner>, robot: Arc<Robot>) -> *mut c_void {
    Box::into_raw(Box::new(Side { planner, robot, points: Vec::new() })).cast()
}

/// # Safety
/// `request` is the one of the present call.
unsafe fn request_from(
    view: &rumbo_plan_request,
    robot: &Arc<Robot>,
    call: &mut Call,
) -> Result<PlanRequest, BadView> {
    // SAFETY: for all blocks below: as promised by the caller.
    let mut obstacles = Vec::new();
    unsafe { obstacles_from(view.obstacles, view.n_obstacles, &mut obstacles)? };
    let grid = unsafe { optional_grid_from(view.grid)? };
    Ok(PlanRequest {
        stamp: call.now(),
        map: unsafe { map_from(view.map)? },
        grid,
        start: pose2_from(&view.start, "start")?,
        goal: Goal {
            position: Point2::new(view.goal.x_m, view.goal.y_m),
            yaw_rad: (!view.goal_yaw_rad.is_nan()).then_some(view.goal_yaw_rad),
        },
        robot: unsafe { robot_from(view.robot, Some(robot))? },
        obstacles,
        give_up: unsafe { flag_from(view.give_up) },
        trace: call.take_trace(),
    })
}

unsafe extern "C" fn plan(
    this: *mut c_void,
    call: *const rumbo_call,
    request: *const rumbo_plan_request,
    path: *mut rumbo_path_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let (Some(side), Ok(mut call), Some(view)) =
                (this.cast::<Side>().as_mut(), Call::from(call), read(request))
            else {
                return RUMBO_ERROR;
            };
            let request = match request_from(&view, &side.robot, &mut call) {
                Ok(request) => request,
                Err(view) => return bad(&view, error),
            };
            side.robot = request.robot.clone();
            let planned = side.planner.plan(&request);
            call.hand_on_from(&request.trace);
            match planned {
                Ok(planned) => side.push(&planned, path),
                Err(why) => why.cross(error),
            }
        })
    }
}

impl Side {
    /// # Safety
    /// `path` is the output of the present call.
    unsafe fn push(&mut self, planned: &Path, path: *mut rumbo_path_out) -> i32 {
        // SAFETY: as promised by the caller.
        let Some((out, push)) =
            (unsafe { path.as_mut() }).and_then(|out| Some((out.push?, out)).map(|(p, o)| (o, p)))
        else {
            return RUMBO_ERROR;
        };
        self.points.clear();
        self.points.extend(points_of(planned));
        out.cost = planned.cost;
        // SAFETY: as promised by the caller.
        unsafe { push(out.ctx, self.points.as_ptr(), self.points.len()) };
        RUMBO_OK
    }
}
