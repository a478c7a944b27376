//! `ekf_landmarks`: an extended Kalman filter that follows a robot by known marks.
//!
//! The odometer moves the pose, ranges and bearings to marks of the map correct it: Thrun, Burgard, Fox, *Probabilistic
//! Robotics* (2005), section 7.4, with what a real robot needs beside that. Updates are in the form of Joseph (Bucy and
//! Joseph 1968), iterated where a mark is near (Bell and Cathey 1993) and gated; the scales of the odometer can be
//! estimated along (Martinelli and Siegwart 2003), since most errors of odometers are the same from meter to meter.

pub mod belief;
pub mod fix;
mod known_marks;
pub mod motion;
mod params;
mod plugin;
mod recent;
pub mod sighting;
mod sureness;
mod tracker;

#[cfg(test)]
mod tests;

pub use known_marks::{KnownMark, KnownMarks};
pub use params::EkfLandmarksParams;
pub use tracker::{Tracker, TrackerSettings};
