//! An avoider of a library.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    EstimateLoan, MapLoan, RobotLoan, SeenLoan, grid_of, obstacle_of, obstacles_from, pointer_to, points_of,
    rumbo_pose2_of, twist_from, twist_of,
};
use super::call::{Instance, Pushed, lend_cx};
use crate::messages::Path;
use crate::robot::Robot;
use crate::stages::{AvoidError, AvoidInput, Avoider, Cx, Steering};
use std::sync::Arc;

/// An avoider of a library.
pub(super) struct DynAvoider {
    instance: Instance,
    table: rumbo_avoider_table,
    estimate: EstimateLoan,
    seen: SeenLoan,
    map: MapLoan,
    robot: RobotLoan,
    path: PathLoan,
    known: Vec<rumbo_obstacle>,
    found: Pushed<rumbo_obstacle>,
}

impl DynAvoider {
    /// Of an instance with its functions.
    pub fn new(instance: Instance, table: rumbo_avoider_table, robot: &Arc<Robot>) -> DynAvoider {
        DynAvoider {
            instance,
            table,
            estimate: EstimateLoan::default(),
            seen: SeenLoan::default(),
            map: MapLoan::default(),
            robot: RobotLoan::new(robot),
            path: PathLoan::default(),
            known: Vec::new(),
            found: Pushed::new(),
        }
    }
}

impl Avoider for DynAvoider {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        let Some(steer) = self.table.steer else {
            return Err(AvoidError::Other("the plugin has no function `steer`".to_owned()));
        };
        let call = lend_cx(cx);
        let estimate = self.estimate.lend(input.estimate);
        let seen = self.seen.lend(input.seen.iter());
        let map = self.map.lend(input.map);
        let grid = input.grid.map(grid_of);
        let path = input.path.map(|path| self.path.lend(path, input.path_number));
        self.known.clear();
        self.known.extend(input.obstacles.iter().map(obstacle_of));
        let view = rumbo_avoid_input {
            size: size_of::<rumbo_avoid_input>(),
            map_from_base: rumbo_pose2_of(&input.map_from_base),
            twist: twist_of(input.twist),
            estimate: &raw const estimate,
            seen: &raw const seen,
            map: &raw const map,
            grid: pointer_to(&grid),
            path: pointer_to(&path),
            path_number: input.path_number,
            arrival_radius_m: input.arrival_radius_m,
            n_obstacles: self.known.len(),
            obstacles: self.known.as_ptr(),
            robot: self.robot.lend(input.robot),
        };
        let mut steering = rumbo_steering {
            size: size_of::<rumbo_steering>(),
            kind: RUMBO_DRIVE,
            reserved: 0,
            twist: rumbo_twist::default(),
        };
        let mut out = rumbo_obstacle_out {
            size: size_of::<rumbo_obstacle_out>(),
            ctx: self.found.begin(),
            push: Some(Pushed::<rumbo_obstacle>::push),
        };
        self.instance.call::<AvoidError>(|this, error| {
            let (call, view) = (&raw const call, &raw const view);
            // SAFETY: a function of the instance's own table, with views that live until it returns.
            unsafe { steer(this, call, view, &raw mut steering, &raw mut out, error) }
        })?;
        self.answer(&steering)
    }
}

impl DynAvoider {
    fn answer(&self, steering: &rumbo_steering) -> Result<Steering, AvoidError> {
        match steering.kind {
            RUMBO_DRIVE => Ok(Steering::Drive(twist_from(&steering.twist))),
            RUMBO_ARRIVED => Ok(Steering::Arrived),
            RUMBO_BLOCKED => {
                if let Some(fault) = self.found.fault("a list of obstacles") {
                    return Err(AvoidError::Other(self.instance.nonsense(fault)));
                }
                let mut obstacles = Vec::new();
                let found = &self.found.items;
                // SAFETY: the list is our own.
                unsafe { obstacles_from(found.as_ptr(), found.len(), &mut obstacles) }
                    .map_err(|bad| AvoidError::Other(self.instance.nonsense(bad)))?;
                Ok(Steering::Blocked { obstacles })
            }
            other => Err(AvoidError::Other(self.instance.nonsense(format!("steering of the kind {other}")))),
        }
    }
}

/// The view of a path, made anew only when the path is another one: paths are long, and calls are many.
#[derive(Default)]
struct PathLoan {
    of: Option<(u64, usize, usize)>,
    points: Vec<rumbo_path_point>,
}

impl PathLoan {
    fn lend(&mut self, path: &Path, number: u64) -> rumbo_path {
        let which = (number, path.points().as_ptr().addr(), path.points().len());
        if self.of != Some(which) {
            self.points.clear();
            self.points.extend(points_of(path));
            self.of = Some(which);
        }
        rumbo_path {
            size: size_of::<rumbo_path>(),
            cost: path.cost,
            len: self.points.len(),
            points: self.points.as_ptr(),
        }
    }
}
