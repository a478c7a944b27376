//! Devices that are not there: the far side of a line, in a simulated place and in real time.
//!
//! A crate that speaks the protocol of a device adds the device with one [`DeviceModel`]; a world that is simulated
//! behind real lines starts it where a sensor asks for it.

mod faults;
mod outlet;
mod serve;

use rumbo_core::frames::Pose3;
use rumbo_core::stages::{Answer, Probe, WorldError};
use rumbo_core::time::Time;

pub use faults::{LineFaultParams, LineFaults};
pub use outlet::Outlet;
pub use serve::{Clock, Served};

/// The device's side of a line, on a clock that is given.
pub trait EmulatedDevice: Send {
    /// The host's bytes have come. Its line runs at `baud`, where it has a speed: behind a bridge it has none.
    fn receive(&mut self, now: Time, baud: Option<u32>, bytes: &[u8]);

    /// What is through the line by now.
    fn transmit(&mut self, now: Time, baud: Option<u32>, out: &mut Vec<u8>);
}

/// What stands around a device.
pub trait Surroundings: Send {
    /// Asks what a sensor would ask its world, as things are now.
    fn look(&mut self, probe: &Probe<'_>, take: &mut dyn FnMut(&Answer<'_>)) -> Result<(), WorldError>;
}

/// A device at its place on the robot.
pub struct Mounted {
    /// The mount.
    pub base_from_sensor: Pose3,
    /// What it sees.
    pub surroundings: Box<dyn Surroundings>,
    /// When it is switched on.
    pub now: Time,
    /// For its own errors.
    pub seed: u64,
}

/// A kind of device that can be emulated.
pub struct DeviceModel {
    /// As sensors call it, such as `lms200`.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// Switches one on.
    pub switch_on: fn(Mounted) -> Box<dyn EmulatedDevice>,
}

rumbo_core::macro_support::inventory::collect!(DeviceModel);

/// Every model that this program knows.
pub fn models() -> impl Iterator<Item = &'static DeviceModel> {
    rumbo_core::macro_support::inventory::iter::<DeviceModel>()
}

/// The model of this name.
pub fn model(name: &str) -> Option<&'static DeviceModel> {
    models().find(|model| model.name == name)
}
