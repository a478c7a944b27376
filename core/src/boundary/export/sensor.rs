//! A sensor as functions.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{SeenLoan, observations_from};
use super::super::status::Crosses as _;
use super::call::{Call, bad};
use super::guard::{destroy, guarded};
use super::host;
use super::world::{HostLender, HostWorld};
use crate::messages::{Data, Observation, Observations, Seen};
use crate::stages::{Sensor, SensorError};
use std::ffi::c_void;

/// Functions of every sensor.
pub(super) static TABLE: rumbo_sensor_table = rumbo_sensor_table {
    size: size_of::<rumbo_sensor_table>(),
    destroy: Some(destroy::<Side>),
    poll: Some(poll),
    derive: Some(derive),
};

struct Side {
    sensor: Box<dyn Sensor>,
    world: HostWorld,
    inputs: Vec<Observation>,
    out: Observations,
    loan: SeenLoan,
}

/// An instance as the host keeps it.
pub(super) fn this(sensor: Box<dyn Sensor>) -> *mut c_void {
    let side = Side {
        sensor,
        world: HostWorld::default(),
        inputs: Vec::new(),
        out: Observations::default(),
        loan: SeenLoan::default(),
    };
    Box::into_raw(Box::new(side)).cast()
}

unsafe extern "C" fn poll(
    this: *mut c_void,
    call: *const rumbo_call,
    world: *mut rumbo_world,
    out: *mut rumbo_observations,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let (Some(side), Ok(call)) = (this.cast::<Side>().as_mut(), Call::from(call)) else {
                return RUMBO_ERROR;
            };
            side.out.lend_from(HostLender::new(out));
            side.world.begin(world);
            let polled = side.sensor.poll(&mut call.cx(), &mut side.world, &mut side.out);
            side.world.end();
            side.hand_on(polled, out, &call, error)
        })
    }
}

unsafe extern "C" fn derive(
    this: *mut c_void,
    call: *const rumbo_call,
    inputs: *const rumbo_seen,
    out: *mut rumbo_observations,
    error: *mut rumbo_error,
) -> i32 {
    // SAFETY: what the host hands over for this call, and an instance that `this` gave.
    unsafe {
        guarded(error, |error| {
            let (Some(side), Ok(call)) = (this.cast::<Side>().as_mut(), Call::from(call)) else {
                return RUMBO_ERROR;
            };
            if let Err(view) = observations_from(inputs, &mut side.inputs) {
                return bad(&view, error);
            }
            side.out.lend_from(HostLender::new(out));
            let derived = side.sensor.derive(&mut call.cx(), Seen::sorted(&side.inputs), &mut side.out);
            side.inputs.clear();
            side.hand_on(derived, out, &call, error)
        })
    }
}

impl Side {
    /// Hands on what was seen, and the result.
    ///
    /// # Safety
    /// `out` is the output of the present call.
    unsafe fn hand_on(
        &mut self,
        result: Result<(), SensorError>,
        out: *mut rumbo_observations,
        call: &Call,
        error: &mut rumbo_error,
    ) -> i32 {
        let Some(host) = host() else { return RUMBO_ERROR };
        self.out.lend_from(None);
        call.hand_on();
        let mut code = RUMBO_OK;
        while let Some(observation) = self.out.pop_front() {
            let view = self.loan.lend(std::iter::once(&observation));
            // SAFETY: as promised by the caller. The host takes the references of the arrays over.
            let taken = unsafe { (host.observe)(out, view.first) };
            if taken == RUMBO_OK {
                give_arrays(observation);
            } else {
                error.clear();
                error.say("the host refuses an observation that does not hold together");
                code = taken;
            }
        }
        match result {
            Ok(()) => code,
            Err(why) => why.cross(error),
        }
    }
}

/// Gives up the arrays of an observation without dropping their references, which somebody else has now.
fn give_arrays(observation: Observation) {
    match observation.data {
        Data::LaserScan(scan) => std::mem::forget((scan.ranges_m, scan.intensities)),
        Data::RangeRing(ring) => std::mem::forget(ring.ranges_m),
        Data::DepthImage(image) => std::mem::forget(image.depth),
        Data::PointCloud(cloud) => std::mem::forget(cloud.points_m),
        Data::Custom(custom) => std::mem::forget(custom.bytes),
        Data::Odometry(_)
        | Data::WheelSpeeds(_)
        | Data::SteeringAngle(_)
        | Data::Bumpers(_)
        | Data::Imu(_)
        | Data::PositionFix(_)
        | Data::Marks(_) => {}
    }
}
