//! A SLAM plugin as functions.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{EstimateLoan, observations_from, prior_from, read, stamped_pose_of};
use super::super::status::Crosses as _;
use super::call::{Call, bad};
use super::guard::{destroy, guarded};
use super::localizer::write_estimate;
use super::map_taken::with_map;
use crate::map::Map;
use crate::messages::{Observation, Prior, Seen};
use crate::stages::{Slam, SlamError};
use std::ffi::c_void;

/// Functions of every SLAM plugin.
pub(super) static TABLE: rumbo_slam_table = rumbo_slam_table {
    size: size_of::<rumbo_slam_table>(),
    destroy: Some(destroy::<Side>),
    start: Some(start),
    update: Some(update),
    save: Some(save),
    trajectory: Some(trajectory),
    relocate: Some(relocate),
    save_map: Some(save_map),
};

struct Side {
    slam: Box<dyn Slam>,
    seen: Vec<Observation>,
    loan: EstimateLoan,
}

/// An instance as the host keeps it.
pub(super) fn this(slam: Box<dyn Slam>) -> *mut c_void {
    Box::into_raw(Box::new(Side { slam, seen: Vec::new(), loan: EstimateLoan::default() })).cast()
}

/// Hands what is known of the robot, and the map, to one of the plugin's functions.
///
/// # Safety
/// All of it is what the host hands over for this call, and `this` is an instance that [`this`] gave.
unsafe fn tell(
    this: *mut c_void,
    prior: *const rumbo_prior,
    map: *mut rumbo_map_mut,
    error: *mut rumbo_error,
    told: impl FnOnce(&mut dyn Slam, &Prior, &mut Map) -> Result<(), SlamError>,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        with_map(map, |map| {
            guarded(error, |error| {
                let Some(side) = this.cast::<Side>().as_mut() else { return RUMBO_ERROR };
                match prior_from(prior).map(|prior| told(&mut *side.slam, &prior, map)) {
                    Ok(Ok(())) => RUMBO_OK,
                    Ok(Err(why)) => why.cross(error),
                    Err(view) => bad(&view, error),
                }
            })
        })
    }
}

unsafe extern "C" fn start(
    this: *mut c_void,
    prior: *const rumbo_prior,
    map: *mut rumbo_map_mut,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: the caller's own contract.
    unsafe { tell(this, prior, map, error, |slam, prior, map| slam.start(prior, map)) }
}

unsafe extern "C" fn update(
    this: *mut c_void,
    call: *const rumbo_call,
    seen: *const rumbo_seen,
    map: *mut rumbo_map_mut,
    estimate: *mut rumbo_estimate,
    candidates: *mut rumbo_candidate_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        with_map(map, |map| {
            guarded(error, |error| {
                let (Some(side), Ok(call)) = (this.cast::<Side>().as_mut(), Call::from(call)) else {
                    return RUMBO_ERROR;
                };
                if let Err(view) = observations_from(seen, &mut side.seen) {
                    return bad(&view, error);
                }
                let updated = side.slam.update(&mut call.cx(), Seen::sorted(&side.seen), map);
                side.seen.clear();
                call.hand_on();
                match updated {
                    Ok(updated) => write_estimate(&mut side.loan, &updated, estimate, candidates),
                    Err(why) => why.cross(error),
                }
            })
        })
    }
}

unsafe extern "C" fn relocate(
    this: *mut c_void,
    prior: *const rumbo_prior,
    map: *mut rumbo_map_mut,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: the caller's own contract.
    unsafe { tell(this, prior, map, error, |slam, prior, map| slam.relocate(prior, map)) }
}

unsafe extern "C" fn trajectory(
    this: *const c_void,
    poses: *mut rumbo_trajectory_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let Some(side) = this.cast::<Side>().as_ref() else { return RUMBO_ERROR };
            let found = match side.slam.trajectory() {
                Err(why) => return why.cross(error),
                Ok(found) => found,
            };
            let Some((out, push)) = read(poses).and_then(|out| Some((out, out.push?))) else {
                return RUMBO_ERROR;
            };
            let found: Vec<_> = found.iter().map(stamped_pose_of).collect();
            push(out.ctx, found.as_ptr(), found.len());
            RUMBO_OK
        })
    }
}

unsafe extern "C" fn save_map(this: *const c_void, map: *mut rumbo_map_mut, error: *mut rumbo_error) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        with_map(map, |map| {
            guarded(error, |error| {
                let Some(side) = this.cast::<Side>().as_ref() else { return RUMBO_ERROR };
                match side.slam.save_map(map) {
                    Err(why) => why.cross(error),
                    Ok(()) => RUMBO_OK,
                }
            })
        })
    }
}

unsafe extern "C" fn save(this: *const c_void, bytes: *mut rumbo_bytes_out, error: *mut rumbo_error) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let Some(side) = this.cast::<Side>().as_ref() else { return RUMBO_ERROR };
            match side.slam.save() {
                Err(why) => why.cross(error),
                Ok(state) => {
                    let Some((out, push)) = read(bytes).and_then(|out| Some((out, out.push?))) else {
                        return RUMBO_ERROR;
                    };
                    push(out.ctx, rumbo_str { data: state.as_ptr().cast(), len: state.len() });
                    RUMBO_OK
                }
            }
        })
    }
}
