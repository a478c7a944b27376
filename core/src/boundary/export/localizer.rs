//! A localizer as functions.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    BadView, EstimateLoan, map_from, observations_from, prior_from, read, write_sized,
};
use super::super::status::Crosses as _;
use super::call::{Call, bad};
use super::guard::{destroy, guarded};
use crate::messages::{Estimate, Observation, Seen};
use crate::stages::Localizer;
use std::ffi::c_void;

/// Functions of every localizer.
pub(super) static TABLE: rumbo_localizer_table = rumbo_localizer_table {
    size: size_of::<rumbo_localizer_table>(),
    destroy: Some(destroy::<Side>),
    start: Some(start),
    update: Some(update),
};

struct Side {
    localizer: Box<dyn Localizer>,
    seen: Vec<Observation>,
    loan: EstimateLoan,
}

/// An instance as the host keeps it.
pub(super) fn this(localizer: Box<dyn Localizer>) -> *mut c_void {
    Box::into_raw(Box::new(Side { localizer, seen: Vec::new(), loan: EstimateLoan::default() })).cast()
}

unsafe extern "C" fn start(
    this: *mut c_void,
    prior: *const rumbo_prior,
    map: *const rumbo_map,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let Some(side) = this.cast::<Side>().as_mut() else { return RUMBO_ERROR };
            match prior_from(prior).and_then(|prior| Ok((prior, map_from(map)?))) {
                Ok((prior, map)) => match side.localizer.start(&prior, &map) {
                    Ok(()) => RUMBO_OK,
                    Err(why) => why.cross(error),
                },
                Err(view) => bad(&view, error),
            }
        })
    }
}

unsafe extern "C" fn update(
    this: *mut c_void,
    call: *const rumbo_call,
    seen: *const rumbo_seen,
    map: *const rumbo_map,
    estimate: *mut rumbo_estimate,
    candidates: *mut rumbo_candidate_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let (Some(side), Ok(call)) = (this.cast::<Side>().as_mut(), Call::from(call)) else {
                return RUMBO_ERROR;
            };
            let updated = side.update(&call, seen, map);
            // References to the host's arrays must not outlive the call: they would make the host copy.
            side.seen.clear();
            call.hand_on();
            match updated {
                Ok(Ok(updated)) => write_estimate(&mut side.loan, &updated, estimate, candidates),
                Ok(Err(why)) => why.cross(error),
                Err(view) => bad(&view, error),
            }
        })
    }
}

type Updated = Result<Estimate, crate::stages::LocalizeError>;

impl Side {
    /// # Safety
    /// Everything belongs to the present call.
    unsafe fn update(
        &mut self,
        call: &Call,
        seen: *const rumbo_seen,
        map: *const rumbo_map,
    ) -> Result<Updated, BadView> {
        // SAFETY: as promised by the caller.
        unsafe { observations_from(seen, &mut self.seen)? };
        // SAFETY: as promised by the caller.
        let map = unsafe { map_from(map)? };
        Ok(self.localizer.update(&mut call.cx(), Seen::sorted(&self.seen), &map))
    }
}

/// Fills in the host's estimate.
///
/// # Safety
/// `to` and `candidates` are the outputs of the present call.
pub(super) unsafe fn write_estimate(
    loan: &mut EstimateLoan,
    estimate: &Estimate,
    to: *mut rumbo_estimate,
    candidates: *mut rumbo_candidate_out,
) -> i32 {
    // SAFETY: for all blocks below: as promised by the caller.
    unsafe { write_sized(to, &loan.lend(estimate)) };
    let found = loan.candidates();
    if !found.is_empty() {
        let Some((out, push)) = unsafe { read(candidates) }.and_then(|out| Some((out, out.push?))) else {
            return RUMBO_ERROR;
        };
        unsafe { push(out.ctx, found.as_ptr(), found.len()) };
    }
    RUMBO_OK
}
