//! `gps`: positions in the map from a satellite receiver: simulated, at a line that speaks NMEA 0183, from a capture of
//! such a line, or from a recording.

mod capture;
mod device;
pub mod emulator;
pub mod local_frame;
pub mod nmea;
mod params;
mod plugin;
mod reception;

pub use params::{GpsParams, Origin, Outage};
pub use plugin::Gps;
pub use reception::{Reception, ReceptionModel};
