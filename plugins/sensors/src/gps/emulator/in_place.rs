//! The receiver in a simulated place, at a line that others hold.

use nalgebra::{Rotation3, Vector3};
use rumbo_core::stages::{Answer, Probe};
use rumbo_core::time::Time;
use rumbo_kit::emulation::{DeviceModel, EmulatedDevice, Mounted, Surroundings};

use super::{Emulator, Settings};
use crate::gps::local_frame::LocalFrame;
use crate::gps::plugin::MODEL;

/// Where on earth the origin of an emulated map lies, its x axis to the east: the place of the sample sentences of
/// Valverde Moreno (2015), figure 34.
pub const EMULATED_LATITUDE_DEG: f64 = -22.014_903_333;
/// See [`EMULATED_LATITUDE_DEG`].
pub const EMULATED_LONGITUDE_DEG: f64 = -47.895_735;

inventory::submit!(DeviceModel {
    name: MODEL,
    summary: "a satellite receiver that speaks NMEA 0183",
    switch_on: |mounted| {
        let Mounted { base_from_sensor, mut surroundings, now, seed } = mounted;
        let frame = LocalFrame::new(EMULATED_LATITUDE_DEG, EMULATED_LONGITUDE_DEG, 0.0);
        let position = move || antenna_m(&base_from_sensor.translation.vector, surroundings.as_mut());
        Box::new(InPlace {
            emulator: Emulator::new(Box::new(position), frame, Settings::default(), seed, now),
        })
    },
});

struct InPlace {
    emulator: Emulator,
}

impl EmulatedDevice for InPlace {
    /// It does not listen.
    fn receive(&mut self, _: Time, _: Option<u32>, _: &[u8]) {}

    fn transmit(&mut self, now: Time, baud: Option<u32>, out: &mut Vec<u8>) {
        self.emulator.transmit(now, baud, out);
    }
}

/// Where the antenna is; a place that does not answer is one without satellites.
fn antenna_m(lever_m: &Vector3<f64>, surroundings: &mut dyn Surroundings) -> Option<[f64; 3]> {
    let (mut base_m, mut attitude_rad) = (None, None);
    surroundings
        .look(&Probe::Position, &mut |answer| {
            if let Answer::Position(position_m) = answer {
                base_m = Some(*position_m);
            }
        })
        .ok()?;
    surroundings
        .look(&Probe::Attitude, &mut |answer| {
            if let Answer::Attitude(attitude) = answer {
                attitude_rad = Some(attitude.attitude_rad);
            }
        })
        .ok()?;
    let [roll, pitch, yaw] = attitude_rad?;
    Some((Vector3::from(base_m?) + Rotation3::from_euler_angles(roll, pitch, yaw) * lever_m).into())
}
