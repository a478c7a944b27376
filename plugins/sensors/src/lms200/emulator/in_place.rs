//! The device in a simulated place, at a line that others hold.

use rumbo_core::frames::Pose3;
use rumbo_core::rng;
use rumbo_core::stages::{Answer, Probe};
use rumbo_core::time::Time;
use rumbo_kit::emulation::{DeviceModel, EmulatedDevice, Mounted, Surroundings};

use super::{Emulator, Faults, Ranges};
use crate::lms200::device::error_m;
use crate::lms200::plugin::MODEL;
use crate::lms200::protocol::LineSpeed;

inventory::submit!(DeviceModel {
    name: MODEL,
    summary: "the SICK LMS 200, byte for byte",
    switch_on: |mounted| Box::new(InPlace::new(mounted)),
});

/// The beams of all variants: a quarter of a degree apart over 180 degrees.
const N_BEAMS: usize = 721;
const BEAMS_A_DEGREE: f64 = 4.0;
const FIRST_DEG: f64 = -90.0;
/// More than the device can say in centimeters.
const REACH_M: f64 = 100.0;

struct InPlace {
    emulator: Emulator,
}

impl InPlace {
    fn new(mounted: Mounted) -> Self {
        let (seed, now) = (mounted.seed, mounted.now);
        Self { emulator: Emulator::new(seen(mounted), Faults::none(seed), now) }
    }

    /// A bridge follows the device.
    fn speed(&self, baud: Option<u32>) -> Option<LineSpeed> {
        baud.map_or(Some(self.emulator.speed()), LineSpeed::of_baud)
    }
}

impl EmulatedDevice for InPlace {
    fn receive(&mut self, now: Time, baud: Option<u32>, bytes: &[u8]) {
        // At a speed that the device does not have it understands nothing.
        if let Some(speed) = self.speed(baud) {
            self.emulator.receive(now, speed, bytes);
        }
    }

    fn transmit(&mut self, now: Time, baud: Option<u32>, out: &mut Vec<u8>) {
        let n_before = out.len();
        self.emulator.transmit(now, self.speed(baud).unwrap_or(LineSpeed::Baud9600), out);
        if self.speed(baud).is_none() {
            out.truncate(n_before);
        }
    }
}

/// Ranges with the device's own error; things reflect diffusely, so there is no reflector level. All values of a scan are
/// of one moment: the place is asked once a scan.
fn seen(mounted: Mounted) -> Ranges {
    let Mounted { base_from_sensor, mut surroundings, seed, .. } = mounted;
    let mut rng = rng::stream(seed, "lms200_error");
    let (mut fan_m, mut seen_at) = (Vec::new(), None);
    Box::new(move |bearing_rad, at| {
        if seen_at != Some(at) {
            look(surroundings.as_mut(), &base_from_sensor, &mut fan_m);
            seen_at = Some(at);
        }
        let idx = ((bearing_rad.to_degrees() - FIRST_DEG) * BEAMS_A_DEGREE).round() as usize;
        let range_m = fan_m.get(idx).copied().map(f64::from).filter(|range_m| range_m.is_finite())?;
        Some(((range_m + error_m(&mut rng)).max(0.0), 0))
    })
}

/// A place that does not answer is one in which nothing is seen.
fn look(surroundings: &mut dyn Surroundings, base_from_sensor: &Pose3, fan_m: &mut Vec<f32>) {
    fan_m.clear();
    let probe = Probe::Beams {
        base_from_sensor,
        first_bearing_rad: FIRST_DEG.to_radians(),
        bearing_step_rad: (1.0 / BEAMS_A_DEGREE).to_radians(),
        n_beams: N_BEAMS,
        max_range_m: REACH_M,
    };
    let answered = surroundings.look(&probe, &mut |answer| {
        if let Answer::Ranges(ranges_m) = answer {
            fan_m.extend_from_slice(ranges_m);
        }
    });
    if answered.is_err() {
        fan_m.clear();
    }
}
