//! What goes over the line to a base: lines of text with a number and a checksum. `docs/base-protocol.md` is for those
//! who build one.

mod checksum;
mod decoder;
mod fields;
mod from_base;
mod geometry;
mod to_base;

pub use checksum::checksum;
pub use decoder::{Decoder, Frame, MOST_LINE, Tally, encode};
pub use fields::BadLine;
pub use from_base::{BaseStatus, FromBase};
pub use geometry::{BaseIdentity, BumperGeometry, SonarGeometry, SonarReading, WheelReport};
pub use to_base::ToBase;

/// The version spoken here.
pub const VERSION: u16 = 1;

#[cfg(test)]
mod tests;
