//! A planner of a library.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    MapLoan, RobotLoan, grid_of, obstacle_of, path_from, point_of, pointer_to, rumbo_pose2_of,
};
use super::call::{Instance, Pushed, lend_call};
use super::callbacks::lend_flag;
use crate::messages::Path;
use crate::robot::Robot;
use crate::stages::{PlanError, PlanRequest, Planner};
use std::sync::Arc;

/// A planner of a library.
pub(super) struct DynPlanner {
    instance: Instance,
    table: rumbo_planner_table,
    map: MapLoan,
    robot: RobotLoan,
    obstacles: Vec<rumbo_obstacle>,
    points: Pushed<rumbo_path_point>,
}

impl DynPlanner {
    /// Of an instance with its functions.
    pub fn new(instance: Instance, table: rumbo_planner_table, robot: &Arc<Robot>) -> DynPlanner {
        DynPlanner {
            instance,
            table,
            map: MapLoan::default(),
            robot: RobotLoan::new(robot),
            obstacles: Vec::new(),
            points: Pushed::new(),
        }
    }
}

impl Planner for DynPlanner {
    fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
        let Some(plan) = self.table.plan else {
            return Err(PlanError::Other("the plugin has no function `plan`".to_owned()));
        };
        let map = self.map.lend(&request.map);
        let grid = request.grid.as_ref().map(grid_of);
        self.obstacles.clear();
        self.obstacles.extend(request.obstacles.iter().map(obstacle_of));
        let flag = Arc::new(request.give_up.clone());
        let call = lend_call(request.stamp, &request.trace);
        let view = rumbo_plan_request {
            size: size_of::<rumbo_plan_request>(),
            map: &raw const map,
            grid: pointer_to(&grid),
            start: rumbo_pose2_of(&request.start),
            goal: point_of(&request.goal.position),
            goal_yaw_rad: request.goal.yaw_rad.unwrap_or(f64::NAN),
            robot: self.robot.lend(&request.robot),
            n_obstacles: self.obstacles.len(),
            obstacles: self.obstacles.as_ptr(),
            give_up: lend_flag(&flag),
        };
        let mut out = rumbo_path_out {
            size: size_of::<rumbo_path_out>(),
            ctx: self.points.begin(),
            push: Some(Pushed::<rumbo_path_point>::push),
            cost: 0.0,
        };
        self.instance.call::<PlanError>(|this, error| {
            let (call, view) = (&raw const call, &raw const view);
            // SAFETY: a function of the instance's own table, with views that live until it returns.
            unsafe { plan(this, call, view, &raw mut out, error) }
        })?;
        if let Some(fault) = self.points.fault("a path") {
            return Err(PlanError::Other(self.instance.nonsense(fault)));
        }
        path_from(&self.points.items, out.cost)
            .ok_or_else(|| PlanError::Other(self.instance.nonsense("a path without points")))
    }
}
