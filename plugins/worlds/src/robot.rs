//! The real robot: a base behind a serial port or a bridge, and sensors that read their own devices.
//!
//! [`RobotParams`] is the world as a pipeline names it. `protocol` is what goes over the line, `link` the connection
//! without a port or a clock, `worker` the thread that has both. `emulated` is the robot that is not there: its base and
//! its devices in a simulated place.

pub mod emulated;
mod fits;
pub mod link;
mod params;
mod plugin;
pub mod protocol;
pub mod readings;
mod worker;

pub use params::{EmulateParams, RobotParams};
pub use plugin::RobotWorld;
