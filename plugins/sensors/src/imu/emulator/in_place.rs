//! The device in a simulated place, at a line that others hold.

use nalgebra::Rotation3;
use rumbo_core::frames::Pose3;
use rumbo_core::stages::{Answer, Probe};
use rumbo_core::time::Time;
use rumbo_kit::emulation::{DeviceModel, EmulatedDevice, Mounted, Surroundings};

use super::{Emulator, Settings};
use crate::imu::plugin::MODEL;

inventory::submit!(DeviceModel {
    name: MODEL,
    summary: "an inertial measurement unit that says yaw, pitch and roll in degrees",
    switch_on: |mounted| {
        let Mounted { base_from_sensor, mut surroundings, now, seed } = mounted;
        let attitude = move || attitude_rad(&base_from_sensor, surroundings.as_mut());
        Box::new(InPlace { emulator: Emulator::new(Box::new(attitude), Settings::default(), seed, now) })
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

/// Roll, pitch and yaw of the device; a place that does not answer gives none.
fn attitude_rad(base_from_sensor: &Pose3, surroundings: &mut dyn Surroundings) -> Option<[f64; 3]> {
    let mut base_rad = None;
    surroundings
        .look(&Probe::Attitude, &mut |answer| {
            if let Answer::Attitude(attitude) = answer {
                base_rad = Some(attitude.attitude_rad);
            }
        })
        .ok()?;
    let [roll, pitch, yaw] = base_rad?;
    let mount = base_from_sensor.rotation.to_rotation_matrix();
    let (roll, pitch, yaw) = (Rotation3::from_euler_angles(roll, pitch, yaw) * mount).euler_angles();
    Some([roll, pitch, yaw])
}
