//! What a sensor of a library may ask and say: probes of the world, and observations.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    BadView, CArray, Hold, SeenLoan, intrinsics_from, observation_from, pose3_from, read, slice, str_from,
    text_of, twist_of, write_sized,
};
use crate::frames::Pose3;
use crate::messages::{Observations, SensorId};
use crate::stages::{Answer, Probe, World};
use std::ffi::c_void;

/// Storage for the views of an answer, kept from probe to probe.
#[derive(Default)]
pub(super) struct AnswerViews {
    loan: SeenLoan,
    marks: Option<rumbo_marks>,
    recorded: Option<rumbo_seen>,
}

// SAFETY: the raw pointers are read only until the next probe, on the thread that asked.
unsafe impl Send for AnswerViews {}

/// The world during one call.
pub(super) struct WorldHandle<'a> {
    world: &'a mut dyn World,
    views: &'a mut AnswerViews,
    why: String,
}

impl<'a> WorldHandle<'a> {
    /// For one call.
    pub fn new(world: &'a mut dyn World, views: &'a mut AnswerViews) -> WorldHandle<'a> {
        WorldHandle { world, views, why: String::new() }
    }

    /// The handle; holds as long as this is borrowed.
    pub fn lend(&mut self) -> *mut rumbo_world {
        std::ptr::from_mut(self).cast::<c_void>().cast()
    }
}

/// # Safety
/// `world` is null or came from `lend` of the present call.
unsafe fn of<'a>(world: *mut rumbo_world) -> Option<&'a mut WorldHandle<'a>> {
    // SAFETY: as promised by the caller.
    unsafe { world.cast::<c_void>().cast::<WorldHandle<'a>>().as_mut() }
}

pub(super) unsafe extern "C" fn now_ns(world: *const rumbo_world) -> i64 {
    // SAFETY: the world of the present call.
    unsafe { of(world.cast_mut()) }.map_or(0, |handle| handle.world.now().0)
}

pub(super) unsafe extern "C" fn is_real_time(world: *const rumbo_world) -> u32 {
    // SAFETY: the world of the present call.
    unsafe { of(world.cast_mut()) }.is_some_and(|handle| handle.world.is_real_time()).into()
}

pub(super) unsafe extern "C" fn probe(
    world: *mut rumbo_world,
    probe: *const rumbo_probe,
    answer: *mut rumbo_answer,
    why: *mut rumbo_str,
) -> i32 {
    // SAFETY: what the plugin hands over: the world of this call, its own probe and answer.
    unsafe {
        let (Some(handle), Some(probe)) = (of(world), read(probe)) else { return RUMBO_ERROR };
        if answer.is_null() {
            return RUMBO_ERROR;
        }
        let asked = match asked(&probe) {
            Ok(asked) => asked,
            Err(fault) => return handle.refuse(fault, why),
        };
        let mount = match &asked {
            Asked::Mounted(mount) => mount,
            Asked::Bare => &Pose3::identity(),
        };
        let camera = intrinsics_from(&probe.intrinsics);
        let Some(question) = question(&probe, mount, &camera) else {
            return handle
                .refuse(format!("probe.kind is {}, which this host does not know", probe.kind), why);
        };
        match handle.world.probe(&question) {
            Ok(found) => {
                let mut to = blank();
                fill(&mut to, &found, handle.views);
                write_sized(answer, &to);
                RUMBO_OK
            }
            Err(error) => {
                let error = error.to_string();
                handle.why = error;
                if let Some(why) = why.as_mut() {
                    *why = text_of(&handle.why);
                }
                RUMBO_NO_ANSWER
            }
        }
    }
}

impl WorldHandle<'_> {
    /// # Safety
    /// `why` is null or points to a variable of the plugin.
    unsafe fn refuse(&mut self, fault: String, why: *mut rumbo_str) -> i32 {
        self.why = fault;
        // SAFETY: as promised by the caller.
        if let Some(why) = unsafe { why.as_mut() } {
            *why = text_of(&self.why);
        }
        RUMBO_NO_ANSWER
    }
}

enum Asked {
    Mounted(Pose3),
    Bare,
}

fn asked(probe: &rumbo_probe) -> Result<Asked, String> {
    match probe.kind {
        RUMBO_PROBE_BEAMS | RUMBO_PROBE_CONES | RUMBO_PROBE_DEPTH | RUMBO_PROBE_MARKS => {
            let mount = pose3_from(&probe.base_from_sensor, "probe.base_from_sensor");
            mount.map(Asked::Mounted).map_err(|bad| bad.0)
        }
        _ => Ok(Asked::Bare),
    }
}

/// # Safety
/// The lists and names of the probe are alive.
unsafe fn question<'p>(
    probe: &'p rumbo_probe,
    base_from_sensor: &'p Pose3,
    intrinsics: &'p crate::messages::Intrinsics,
) -> Option<Probe<'p>> {
    let max_range_m = probe.max_range_m;
    Some(match probe.kind {
        RUMBO_PROBE_BEAMS => Probe::Beams {
            base_from_sensor,
            first_bearing_rad: probe.first_bearing_rad,
            bearing_step_rad: probe.bearing_step_rad,
            n_beams: probe.n_beams as usize,
            max_range_m,
        },
        RUMBO_PROBE_CONES => Probe::Cones {
            base_from_sensor,
            // SAFETY: as promised by the caller.
            bearings_rad: unsafe { slice(probe.bearings_rad, probe.n_cones) }.ok()?,
            cone_rad: probe.cone_rad,
            ring_radius_m: probe.ring_radius_m,
            max_range_m,
        },
        RUMBO_PROBE_DEPTH => Probe::Depth { base_from_sensor, intrinsics, max_range_m },
        RUMBO_PROBE_WHEELS => Probe::Wheels,
        RUMBO_PROBE_ATTITUDE => Probe::Attitude,
        RUMBO_PROBE_POSITION => Probe::Position,
        RUMBO_PROBE_CONTACTS => Probe::Contacts,
        RUMBO_PROBE_MARKS => {
            Probe::Marks { base_from_sensor, field_of_view_rad: probe.field_of_view_rad, max_range_m }
        }
        // SAFETY: as promised by the caller.
        RUMBO_PROBE_PERSON => Probe::Person { name: unsafe { str_from(probe.name) }? },
        RUMBO_PROBE_CHANNEL => Probe::Channel { name: unsafe { str_from(probe.name) }? },
        _ => return None,
    })
}

/// An answer with nothing in it.
pub(in super::super) fn blank() -> rumbo_answer {
    rumbo_answer {
        size: size_of::<rumbo_answer>(),
        kind: RUMBO_ANSWER_LIVE,
        n_wheels: 0,
        n_ranges: 0,
        ranges_m: std::ptr::null(),
        rolled_m: [0.0; 4],
        turned_rad: 0.0,
        steering_rad: 0.0,
        twist: rumbo_twist::default(),
        attitude_rad: [0.0; 3],
        rates_rad_s: [0.0; 3],
        accelerations_m_s2: [0.0; 3],
        position_m: [0.0; 3],
        n_contacts: 0,
        contacts_rad: std::ptr::null(),
        marks: std::ptr::null(),
        recorded: std::ptr::null(),
    }
}

fn fill(to: &mut rumbo_answer, found: &Answer<'_>, views: &mut AnswerViews) {
    match found {
        Answer::Ranges(ranges) => {
            (to.kind, to.n_ranges, to.ranges_m) = (RUMBO_ANSWER_RANGES, ranges.len(), ranges.as_ptr());
        }
        Answer::Wheels(wheels) => {
            to.kind = RUMBO_ANSWER_WHEELS;
            to.n_wheels = wheels.n_wheels;
            to.rolled_m = wheels.rolled_m;
            to.turned_rad = wheels.turned_rad;
            to.steering_rad = wheels.steering_rad;
            to.twist = twist_of(wheels.twist);
        }
        Answer::Attitude(attitude) => {
            to.kind = RUMBO_ANSWER_ATTITUDE;
            to.attitude_rad = attitude.attitude_rad;
            to.rates_rad_s = attitude.rates_rad_s;
            to.accelerations_m_s2 = attitude.accelerations_m_s2;
        }
        Answer::Position(position) => (to.kind, to.position_m) = (RUMBO_ANSWER_POSITION, *position),
        Answer::Contacts(contacts) => {
            to.kind = RUMBO_ANSWER_CONTACTS;
            (to.n_contacts, to.contacts_rad) = (contacts.len(), contacts.as_ptr());
        }
        Answer::Marks(marks) => {
            to.kind = RUMBO_ANSWER_MARKS;
            to.marks = std::ptr::from_ref(views.marks.insert(views.loan.lend_marks(marks)));
        }
        Answer::Recorded(recorded) => {
            to.kind = RUMBO_ANSWER_RECORDED;
            to.recorded = std::ptr::from_ref(views.recorded.insert(views.loan.lend(recorded.iter())));
        }
        Answer::Live => to.kind = RUMBO_ANSWER_LIVE,
    }
}

/// Where a sensor's observations go during one call.
pub(super) struct OutHandle<'a> {
    out: &'a mut Observations,
    sensor: SensorId,
    /// The first observation that was refused: a plugin may overlook the status.
    refused: Option<BadView>,
}

impl<'a> OutHandle<'a> {
    /// For one call of one sensor.
    pub fn new(out: &'a mut Observations, sensor: SensorId) -> OutHandle<'a> {
        OutHandle { out, sensor, refused: None }
    }

    /// The handle; holds as long as this is borrowed.
    pub fn lend(&mut self) -> *mut rumbo_observations {
        std::ptr::from_mut(self).cast::<c_void>().cast()
    }

    /// Whether everything that was pushed held together.
    pub fn end(self) -> Result<(), BadView> {
        self.refused.map_or(Ok(()), Err)
    }
}

/// # Safety
/// `out` is null or came from `lend` of the present call.
unsafe fn out_of<'a>(out: *mut rumbo_observations) -> Option<&'a mut OutHandle<'a>> {
    // SAFETY: as promised by the caller.
    unsafe { out.cast::<c_void>().cast::<OutHandle<'a>>().as_mut() }
}

pub(super) unsafe extern "C" fn lend_f32(out: *mut rumbo_observations, len: usize) -> rumbo_f32_array {
    // SAFETY: the output of the present call.
    unsafe { out_of(out) }.map_or_else(CArray::nothing, |out| CArray::give(out.out.buffer(len)))
}

pub(super) unsafe extern "C" fn lend_u16(out: *mut rumbo_observations, len: usize) -> rumbo_u16_array {
    // SAFETY: the output of the present call.
    unsafe { out_of(out) }.map_or_else(CArray::nothing, |out| CArray::give(out.out.depth_buffer(len)))
}

pub(super) unsafe extern "C" fn lend_point3(out: *mut rumbo_observations, len: usize) -> rumbo_point3_array {
    // SAFETY: the output of the present call.
    unsafe { out_of(out) }.map_or_else(CArray::nothing, |out| CArray::give(out.out.point_buffer(len)))
}

pub(super) unsafe extern "C" fn observe(
    out: *mut rumbo_observations,
    observation: *const rumbo_observation,
) -> i32 {
    // SAFETY: the output of the present call, and an observation whose references are given.
    unsafe {
        let Some(handle) = out_of(out) else { return RUMBO_ERROR };
        match observation_from(observation, Hold::Given) {
            Ok(Some(mut observation)) => {
                observation.sensor = handle.sensor;
                handle.out.push(observation);
                RUMBO_OK
            }
            Ok(None) => {
                handle.refused.get_or_insert_with(|| BadView::new("an observation of an unknown kind"));
                RUMBO_UNSUPPORTED
            }
            Err(bad) => {
                handle.refused.get_or_insert(bad);
                RUMBO_BAD_NUMBER
            }
        }
    }
}
