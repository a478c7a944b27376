//! `imu`: attitude and turning rates from an inertial measurement unit: simulated, at a line that says them as text, or
//! from a recording.

mod device;
pub mod emulator;
mod noise;
mod params;
mod plugin;
pub mod text;

pub use noise::{AttitudeErrors, ImuNoise};
pub use params::{AngleUnit, ImuParams};
pub use plugin::ImuSensor;
