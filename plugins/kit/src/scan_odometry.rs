//! Odometry from scans alone: each scan is registered to a key scan, point to line.
//!
//! Censi, *An ICP variant using a point-to-line metric* (2008), for the metric and for a nearest point that is found by
//! bearing; Lu and Milios 1997 for the key scan. Beyond the published method, and each of it can be turned off:
//!
//! - [`LineKind::Fitted`]: the line at a point of the key scan is fitted to all its neighbors within reach, on the side of a
//!   corner that is straight. A line through two points half a degree apart has the noise of both in its direction: at 3 m
//!   and 1 cm of noise more than 20 degrees.
//! - What the noise of those directions pretends to tell is taken off before a direction counts as observed: two parallel
//!   walls with rough surfaces would else seem to hold the robot along the corridor.
//! - The reach of matches shrinks as soon as the steps have become small, not only after each third step.
//! - Where the match fails, it is tried again from other directions, and the one that most points support is taken.

mod alignment;
mod degeneracy;
mod equations;
mod key_lines;
mod key_scan;
mod matches;
mod odometer;
mod points;
mod registration;
mod settings;
mod slice;

pub use alignment::align;
pub use degeneracy::{DegeneracyRule, Split};
pub use equations::{Equations, Line};
pub use key_scan::KeyScan;
pub use odometer::{ScanOdometer, ScanStep};
pub use points::ScanPoints;
pub use registration::{MatchStatus, PosePrior, Registrar, Registration};
pub use settings::{LineKind, ScanOdometrySettings};
pub use slice::SlicePitch;

#[cfg(test)]
pub(crate) mod tests;
