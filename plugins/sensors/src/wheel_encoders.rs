//! `wheel_encoders`: dead reckoning from what the wheels rolled, in the steps that the device counts.

mod odometer;
mod params;
mod plugin;

pub use odometer::Odometer;
pub use params::WheelEncodersParams;
pub use plugin::WheelEncoders;
