//! The robot.
#![allow(unsafe_code)]

use super::BadView;
use super::basic::read;
use super::observation::slice;
use crate::boundary::abi::*;
use crate::robot::{Drive, GuardParams, Robot, SteeredWheel};
use std::sync::Arc;

/// A robot with its view, made anew only when it is another one.
pub(crate) struct RobotLoan {
    robot: Arc<Robot>,
    corners: Vec<rumbo_point>,
    view: rumbo_robot,
}

// SAFETY: the raw pointer of the view goes into `corners`, which the loan owns.
unsafe impl Send for RobotLoan {}

impl RobotLoan {
    /// Of this robot.
    pub fn new(robot: &Arc<Robot>) -> RobotLoan {
        let corners: Vec<rumbo_point> =
            robot.footprint_m.iter().map(|[x, y]| rumbo_point { x_m: *x, y_m: *y }).collect();
        let view = view_of(robot, &corners);
        RobotLoan { robot: robot.clone(), corners, view }
    }

    /// A view that holds until the next call.
    pub fn lend(&mut self, robot: &Robot) -> *const rumbo_robot {
        if !std::ptr::eq(robot, self.robot.as_ref()) && *robot != *self.robot {
            *self = RobotLoan::new(&Arc::new(robot.clone()));
        }
        // The loan may have been moved since the view was made, its corners were not.
        self.view.corners = self.corners.as_ptr();
        &raw const self.view
    }
}

fn view_of(robot: &Robot, corners: &[rumbo_point]) -> rumbo_robot {
    let mut view = rumbo_robot {
        size: size_of::<rumbo_robot>(),
        drive: RUMBO_DIFFERENTIAL,
        guard_stop_zone: robot.guard.stop_zone.into(),
        track_m: 0.0,
        wheelbase_m: 0.0,
        max_steer_deg: 0.0,
        max_steer_rate_deg_s: 0.0,
        radius_m: robot.radius_m,
        n_corners: corners.len(),
        corners: corners.as_ptr(),
        height_m: robot.height_m,
        max_speed_m_s: robot.max_speed_m_s,
        max_turn_deg_s: robot.max_turn_deg_s,
        max_accel_m_s2: robot.max_accel_m_s2,
        max_turn_accel_deg_s2: robot.max_turn_accel_deg_s2,
        braking_m_s2: robot.braking_m_s2,
        guard_margin_m: robot.guard.margin_m,
        guard_latency_s: robot.guard.latency_s,
        guard_stale_after_s: robot.guard.stale_after_s,
        is_steered_behind: 0,
        reserved: 0,
    };
    match robot.drive {
        Drive::Differential { track_m } => view.track_m = track_m,
        Drive::Omnidirectional {} => view.drive = RUMBO_OMNIDIRECTIONAL,
        Drive::Tricycle { wheelbase_m, track_m, max_steer_deg, max_steer_rate_deg_s, steered } => {
            view.drive = RUMBO_TRICYCLE;
            view.wheelbase_m = wheelbase_m;
            view.track_m = track_m;
            view.max_steer_deg = max_steer_deg;
            view.max_steer_rate_deg_s = max_steer_rate_deg_s;
            view.is_steered_behind = u32::from(steered == SteeredWheel::Rear);
        }
    }
    view
}

/// The robot behind a view: `known` again where it is the same.
///
/// # Safety
/// `view` points to a view whose corners are alive.
pub(crate) unsafe fn robot_from(
    view: *const rumbo_robot,
    known: Option<&Arc<Robot>>,
) -> Result<Arc<Robot>, BadView> {
    // SAFETY: as promised by the caller.
    let view = unsafe { read(view) }.ok_or_else(|| BadView::new("the robot points nowhere"))?;
    let drive = match view.drive {
        RUMBO_DIFFERENTIAL => Drive::Differential { track_m: view.track_m },
        RUMBO_OMNIDIRECTIONAL => Drive::Omnidirectional {},
        RUMBO_TRICYCLE => Drive::Tricycle {
            wheelbase_m: view.wheelbase_m,
            track_m: view.track_m,
            max_steer_deg: view.max_steer_deg,
            max_steer_rate_deg_s: view.max_steer_rate_deg_s,
            steered: if view.is_steered_behind == 0 { SteeredWheel::Front } else { SteeredWheel::Rear },
        },
        other => {
            return Err(BadView::new(format!(
                "the robot's drive has the number {other}, which is unknown here"
            )));
        }
    };
    // SAFETY: as promised by the caller.
    let corners = unsafe { slice(view.corners, view.n_corners)? };
    let corner = |p: &rumbo_point| [p.x_m, p.y_m];
    if let Some(known) = known
        && known.drive == drive
        && known.radius_m == view.radius_m
        && known.max_speed_m_s == view.max_speed_m_s
        && corners.iter().map(corner).eq(known.footprint_m.iter().copied())
        && same_limits(known, &view)
    {
        return Ok(known.clone());
    }
    Ok(Arc::new(Robot {
        drive,
        radius_m: view.radius_m,
        footprint_m: corners.iter().map(corner).collect(),
        height_m: view.height_m,
        max_speed_m_s: view.max_speed_m_s,
        max_turn_deg_s: view.max_turn_deg_s,
        max_accel_m_s2: view.max_accel_m_s2,
        max_turn_accel_deg_s2: view.max_turn_accel_deg_s2,
        braking_m_s2: view.braking_m_s2,
        guard: guard_of(&view),
    }))
}

fn guard_of(view: &rumbo_robot) -> GuardParams {
    GuardParams {
        margin_m: view.guard_margin_m,
        latency_s: view.guard_latency_s,
        stale_after_s: view.guard_stale_after_s,
        stop_zone: view.guard_stop_zone != 0,
    }
}

fn same_limits(robot: &Robot, view: &rumbo_robot) -> bool {
    robot.height_m == view.height_m
        && robot.max_turn_deg_s == view.max_turn_deg_s
        && robot.max_accel_m_s2 == view.max_accel_m_s2
        && robot.max_turn_accel_deg_s2 == view.max_turn_accel_deg_s2
        && robot.braking_m_s2 == view.braking_m_s2
        && robot.guard == guard_of(view)
}
