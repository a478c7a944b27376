//! What every call gets: time, drawings, and the flag to give up.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{BadView, point_of, read, text_of};
use super::host;
use crate::stages::{Cx, GiveUp};
use crate::time::Time;
use crate::trace::{Drawing, Trace};
use std::sync::Arc;

/// A flag of the host, kept alive as long as somebody looks at it.
#[derive(Debug)]
pub(crate) struct HostFlag(*const rumbo_give_up);

// SAFETY: the host's flag is atomic and its functions may be called from any thread.
unsafe impl Send for HostFlag {}
// SAFETY: as above.
unsafe impl Sync for HostFlag {}

impl HostFlag {
    /// Somebody asked to stop.
    pub(crate) fn is_raised(&self) -> bool {
        // SAFETY: this flag holds a reference.
        host().is_some_and(|host| unsafe { (host.give_up_is_raised)(self.0) } != 0)
    }
}

impl Drop for HostFlag {
    fn drop(&mut self) {
        if let Some(host) = host() {
            // SAFETY: gives up the reference that was taken when it was made.
            unsafe { (host.give_up_release)(self.0) };
        }
    }
}

/// The host's flag as ours.
///
/// # Safety
/// `flag` is null or a flag of the present call.
pub(super) unsafe fn flag_from(flag: *const rumbo_give_up) -> GiveUp {
    let Some(host) = host().filter(|_| !flag.is_null()) else { return GiveUp::default() };
    // SAFETY: as promised by the caller.
    unsafe { (host.give_up_retain)(flag) };
    GiveUp::of_host(Arc::new(HostFlag(flag)))
}

/// A call with its own trace, whose drawings are handed on at the end.
pub(super) struct Call {
    now: Time,
    theirs: *mut rumbo_trace,
    trace: Trace,
}

impl Call {
    /// # Safety
    /// `view` points to the struct of the present call.
    pub unsafe fn from(view: *const rumbo_call) -> Result<Call, BadView> {
        // SAFETY: as promised by the caller.
        let view = unsafe { read(view) }.ok_or_else(|| BadView("the call points nowhere".to_owned()))?;
        let trace = if view.is_watched != 0 { Trace::watched() } else { Trace::unwatched() };
        Ok(Call { now: Time(view.now_ns), theirs: view.trace, trace })
    }

    /// The time it is.
    pub fn now(&self) -> Time {
        self.now
    }

    /// As stages get it.
    pub fn cx(&self) -> Cx<'_> {
        Cx { now: self.now, trace: &self.trace }
    }

    /// Another trace instead, which belongs to a request.
    pub fn take_trace(&mut self) -> Trace {
        std::mem::take(&mut self.trace)
    }

    /// Hands on what was drawn and counted.
    pub fn hand_on(&self) {
        hand_on(&self.trace, self.theirs);
    }

    /// The same for a trace that was taken.
    pub fn hand_on_from(&self, trace: &Trace) {
        hand_on(trace, self.theirs);
    }
}

fn hand_on(trace: &Trace, to: *mut rumbo_trace) {
    let Some(host) = host().filter(|_| trace.is_watched()) else { return };
    let (drawings, counters) = trace.take();
    for drawing in &drawings {
        let (draw, name, points) = match drawing {
            Drawing::Polyline { name, points } => (host.draw_polyline, name, points),
            Drawing::Points { name, points } => (host.draw_points, name, points),
        };
        let points: Vec<rumbo_point> = points.iter().map(point_of).collect();
        // SAFETY: the trace of the present call, and views that live until it returns.
        unsafe { draw(to, text_of(name), points.as_ptr(), points.len()) };
    }
    for (name, value) in counters {
        // SAFETY: as above.
        unsafe { (host.count)(to, text_of(name), value) };
    }
}

/// A view that does not hold together, as a status.
pub(super) fn bad(view: &BadView, error: &mut rumbo_error) -> i32 {
    error.clear();
    error.say(&format!("the host handed over something that does not hold together: {view}"));
    RUMBO_ERROR
}
