//! `lms200`: the SICK LMS 200 as its data sheet and its telegrams have it.

mod device;
pub mod driver;
pub mod emulator;
mod live;
mod params;
mod plugin;
pub mod protocol;
mod tilt;

pub use device::{Lms200Mode, Lms200Unit};
pub use params::Lms200Params;
pub use plugin::Lms200;
