//! The host's world and buffers, as a sensor sees them.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    CArray, Hold, intrinsics_of, marks_from, observations_from, read, rumbo_pose3_of, slice, string_from,
    text_of, twist_from,
};
use super::host;
use crate::boundary::Buffer;
use crate::boundary::host::blank_answer;
use crate::frames::Pose3;
use crate::messages::{Command, Marks, Observation};
use crate::stages::{Advance, Answer, Attitude, Drove, Probe, WheelMotion, World, WorldError};
use crate::time::Time;

/// Buffers of the host's pools, for one call.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HostLender {
    out: *mut rumbo_observations,
}

// SAFETY: used only during the call that it was made for, on its thread.
unsafe impl Send for HostLender {}

impl HostLender {
    /// For one call; none where there is no host.
    pub fn new(out: *mut rumbo_observations) -> Option<HostLender> {
        host().filter(|_| !out.is_null()).map(|_| HostLender { out })
    }

    /// A buffer of zeros.
    pub fn f32(self, len: usize) -> Buffer<f32> {
        // SAFETY: a function of the host, with the output of the present call.
        self.lend(|host, out| unsafe { (host.lend_f32)(out, len) }, len)
    }

    /// A buffer of zeros.
    pub fn u16(self, len: usize) -> Buffer<u16> {
        // SAFETY: as above.
        self.lend(|host, out| unsafe { (host.lend_u16)(out, len) }, len)
    }

    /// A buffer of zeros.
    pub fn point3(self, len: usize) -> Buffer<[f32; 3]> {
        // SAFETY: as above.
        self.lend(|host, out| unsafe { (host.lend_point3)(out, len) }, len)
    }

    fn lend<A: CArray>(
        self,
        lend: impl FnOnce(&rumbo_host, *mut rumbo_observations) -> A,
        len: usize,
    ) -> Buffer<A::Item> {
        // SAFETY: the host gives an array with its reference.
        let lent = host().and_then(|host| unsafe { lend(host, self.out).take(Hold::Given) }.ok());
        lent.filter(|lent| lent.len() == len).unwrap_or_else(|| Buffer::zeroed(len))
    }
}

/// The host's world.
pub(super) struct HostWorld {
    world: *mut rumbo_world,
    answer: rumbo_answer,
    marks: Marks,
    recorded: Vec<Observation>,
}

// SAFETY: the pointers are used only during the call that they were made for, on its thread.
unsafe impl Send for HostWorld {}

impl Default for HostWorld {
    fn default() -> Self {
        HostWorld {
            world: std::ptr::null_mut(),
            answer: blank_answer(),
            marks: Marks::default(),
            recorded: Vec::new(),
        }
    }
}

impl HostWorld {
    /// For one call.
    pub fn begin(&mut self, world: *mut rumbo_world) {
        self.world = world;
    }

    /// References to the host's arrays must not outlive the call.
    pub fn end(&mut self) {
        self.world = std::ptr::null_mut();
        self.recorded.clear();
    }

    fn ask(&mut self, probe: &Probe<'_>) -> Result<(), WorldError> {
        let question = question_of(probe);
        let Some(host) = host().filter(|_| !self.world.is_null()) else {
            return Err(WorldError::Other("asked outside of a call".to_owned()));
        };
        self.answer = blank_answer();
        let mut why = text_of("");
        // SAFETY: the world of the present call, and structs of our own.
        let code =
            unsafe { (host.probe)(self.world, &raw const question, &raw mut self.answer, &raw mut why) };
        if code == RUMBO_OK {
            return Ok(());
        }
        // SAFETY: the host's text holds until the next probe.
        let why = unsafe { string_from(why) };
        let unsupported = WorldError::Unsupported { probe: probe.name() };
        Err(if why == unsupported.to_string() { unsupported } else { WorldError::Other(why) })
    }
}

impl World for HostWorld {
    fn now(&self) -> Time {
        // SAFETY: the world of the present call.
        Time(host().map_or(0, |host| unsafe { (host.world_now_ns)(self.world) }))
    }

    fn advance(&mut self, _: Time) -> Result<Advance, WorldError> {
        Err(WorldError::Other("a sensor cannot let time pass".to_owned()))
    }

    fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
        Err(WorldError::Other("a sensor cannot drive".to_owned()))
    }

    fn is_real_time(&self) -> bool {
        // SAFETY: the world of the present call.
        host().is_some_and(|host| unsafe { (host.world_is_real_time)(self.world) } != 0)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        self.ask(probe)?;
        let a = &self.answer;
        let odd = |what: &str| WorldError::Other(format!("the host's answer does not hold together: {what}"));
        Ok(match a.kind {
            // SAFETY: for all blocks below: the host's answer holds until the next probe.
            RUMBO_ANSWER_RANGES => {
                Answer::Ranges(unsafe { slice(a.ranges_m, a.n_ranges) }.map_err(|b| odd(&b.0))?)
            }
            RUMBO_ANSWER_CONTACTS => {
                Answer::Contacts(unsafe { slice(a.contacts_rad, a.n_contacts) }.map_err(|b| odd(&b.0))?)
            }
            RUMBO_ANSWER_WHEELS => Answer::Wheels(WheelMotion {
                rolled_m: a.rolled_m,
                n_wheels: a.n_wheels,
                turned_rad: a.turned_rad,
                steering_rad: a.steering_rad,
                twist: twist_from(&a.twist),
            }),
            RUMBO_ANSWER_ATTITUDE => Answer::Attitude(Attitude {
                attitude_rad: a.attitude_rad,
                rates_rad_s: a.rates_rad_s,
                accelerations_m_s2: a.accelerations_m_s2,
            }),
            RUMBO_ANSWER_POSITION => Answer::Position(a.position_m),
            RUMBO_ANSWER_MARKS => {
                let marks = unsafe { read(a.marks) }.ok_or_else(|| odd("no marks"))?;
                self.marks = unsafe { marks_from(&marks) }.map_err(|b| odd(&b.0))?;
                Answer::Marks(&self.marks)
            }
            RUMBO_ANSWER_RECORDED => {
                unsafe { observations_from(a.recorded, &mut self.recorded) }.map_err(|b| odd(&b.0))?;
                Answer::Recorded(&self.recorded)
            }
            RUMBO_ANSWER_LIVE => Answer::Live,
            _ => return Err(odd("a kind of answer that this plugin is too old for")),
        })
    }
}

/// A probe as a struct.
fn question_of(probe: &Probe<'_>) -> rumbo_probe {
    let mut q = rumbo_probe {
        size: size_of::<rumbo_probe>(),
        kind: RUMBO_PROBE_WHEELS,
        n_beams: 0,
        base_from_sensor: rumbo_pose3_of(&Pose3::identity()),
        first_bearing_rad: 0.0,
        bearing_step_rad: 0.0,
        max_range_m: 0.0,
        n_cones: 0,
        bearings_rad: std::ptr::null(),
        cone_rad: 0.0,
        ring_radius_m: 0.0,
        intrinsics: rumbo_intrinsics { width: 0, height: 0, focal_px: [0.0; 2], center_px: [0.0; 2] },
        field_of_view_rad: 0.0,
        name: text_of(""),
    };
    match *probe {
        Probe::Beams { base_from_sensor, first_bearing_rad, bearing_step_rad, n_beams, max_range_m } => {
            (q.kind, q.base_from_sensor) = (RUMBO_PROBE_BEAMS, rumbo_pose3_of(base_from_sensor));
            (q.first_bearing_rad, q.bearing_step_rad) = (first_bearing_rad, bearing_step_rad);
            (q.n_beams, q.max_range_m) = (u32::try_from(n_beams).unwrap_or(u32::MAX), max_range_m);
        }
        Probe::Cones { base_from_sensor, bearings_rad, cone_rad, ring_radius_m, max_range_m } => {
            (q.kind, q.base_from_sensor) = (RUMBO_PROBE_CONES, rumbo_pose3_of(base_from_sensor));
            (q.n_cones, q.bearings_rad) = (bearings_rad.len(), bearings_rad.as_ptr());
            (q.cone_rad, q.ring_radius_m, q.max_range_m) = (cone_rad, ring_radius_m, max_range_m);
        }
        Probe::Depth { base_from_sensor, intrinsics, max_range_m } => {
            (q.kind, q.base_from_sensor) = (RUMBO_PROBE_DEPTH, rumbo_pose3_of(base_from_sensor));
            (q.intrinsics, q.max_range_m) = (intrinsics_of(intrinsics), max_range_m);
        }
        Probe::Marks { base_from_sensor, field_of_view_rad, max_range_m } => {
            (q.kind, q.base_from_sensor) = (RUMBO_PROBE_MARKS, rumbo_pose3_of(base_from_sensor));
            (q.field_of_view_rad, q.max_range_m) = (field_of_view_rad, max_range_m);
        }
        Probe::Person { name } => (q.kind, q.name) = (RUMBO_PROBE_PERSON, text_of(name)),
        Probe::Channel { name } => (q.kind, q.name) = (RUMBO_PROBE_CHANNEL, text_of(name)),
        Probe::Wheels => q.kind = RUMBO_PROBE_WHEELS,
        Probe::Attitude => q.kind = RUMBO_PROBE_ATTITUDE,
        Probe::Position => q.kind = RUMBO_PROBE_POSITION,
        Probe::Contacts => q.kind = RUMBO_PROBE_CONTACTS,
    }
    q
}
