//! A map builder as functions.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{BadView, estimate_from, observations_from, read};
use super::super::status::Crosses as _;
use super::call::{Call, bad};
use super::guard::{destroy, guarded};
use super::map_taken::with_map;
use crate::map::Map;
use crate::messages::{Observation, Seen};
use crate::stages::{MapBuilder, MapError, MapInput};
use std::ffi::c_void;

/// Functions of every map builder.
pub(super) static TABLE: rumbo_map_builder_table = rumbo_map_builder_table {
    size: size_of::<rumbo_map_builder_table>(),
    destroy: Some(destroy::<Side>),
    start: Some(start),
    insert: Some(insert),
    save: Some(save),
};

struct Side {
    builder: Box<dyn MapBuilder>,
    seen: Vec<Observation>,
}

/// An instance as the host keeps it.
pub(super) fn this(builder: Box<dyn MapBuilder>) -> *mut c_void {
    Box::into_raw(Box::new(Side { builder, seen: Vec::new() })).cast()
}

fn status(result: Result<(), MapError>, error: &mut rumbo_error) -> i32 {
    match result {
        Ok(()) => RUMBO_OK,
        Err(why) => why.cross(error),
    }
}

unsafe extern "C" fn start(this: *mut c_void, map: *mut rumbo_map_mut, error: *mut rumbo_error) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        with_map(map, |map| {
            guarded(error, |error| match this.cast::<Side>().as_mut() {
                Some(side) => status(side.builder.start(map), error),
                None => RUMBO_ERROR,
            })
        })
    }
}

unsafe extern "C" fn insert(
    this: *mut c_void,
    call: *const rumbo_call,
    seen: *const rumbo_seen,
    estimate: *const rumbo_estimate,
    map: *mut rumbo_map_mut,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        with_map(map, |map| {
            guarded(error, |error| {
                let (Some(side), Ok(call)) = (this.cast::<Side>().as_mut(), Call::from(call)) else {
                    return RUMBO_ERROR;
                };
                let inserted = side.insert(&call, seen, estimate, map);
                side.seen.clear();
                call.hand_on();
                match inserted {
                    Ok(inserted) => status(inserted, error),
                    Err(view) => bad(&view, error),
                }
            })
        })
    }
}

unsafe extern "C" fn save(
    this: *const c_void,
    map: *mut rumbo_map_mut,
    bytes: *mut rumbo_bytes_out,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        with_map(map, |map| {
            guarded(error, |error| {
                let Some(side) = this.cast::<Side>().as_ref() else { return RUMBO_ERROR };
                match side.builder.save(map) {
                    Err(why) => why.cross(error),
                    Ok(None) => RUMBO_OK,
                    Ok(Some(kept)) => {
                        let Some((out, push)) = read(bytes).and_then(|out| Some((out, out.push?))) else {
                            return RUMBO_ERROR;
                        };
                        push(out.ctx, rumbo_str { data: kept.as_ptr().cast(), len: kept.len() });
                        RUMBO_OK
                    }
                }
            })
        })
    }
}

impl Side {
    /// # Safety
    /// Everything belongs to the present call.
    unsafe fn insert(
        &mut self,
        call: &Call,
        seen: *const rumbo_seen,
        estimate: *const rumbo_estimate,
        map: &mut Map,
    ) -> Result<Result<(), MapError>, BadView> {
        // SAFETY: for all blocks below: as promised by the caller.
        unsafe { observations_from(seen, &mut self.seen)? };
        let estimate = unsafe { estimate_from(estimate)? };
        let input = MapInput { seen: Seen::sorted(&self.seen), estimate: &estimate };
        Ok(self.builder.insert(&mut call.cx(), &input, map))
    }
}
