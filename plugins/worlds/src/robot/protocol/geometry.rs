//! What a base is and what it measures.

use rumbo_core::robot::DriveKind;
use rumbo_core::stages::WheelMotion;

/// Who answers.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseIdentity {
    /// The version that it speaks.
    pub version: u16,
    /// Differs after each start of the base: its wheels are counted anew then.
    pub boot: u32,
    /// How it moves.
    pub drive: DriveKind,
    /// Distance between the wheels of an axle, meters; 0 where that means nothing.
    pub track_m: f64,
    /// It stops by itself after so long without a command, seconds.
    pub watchdog_s: f64,
    /// Its name.
    pub name: String,
}

/// A ring of sonars in the frame of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SonarGeometry {
    /// How many; 0 where there are none.
    pub n_sonars: u32,
    /// Bearing of the first, radians.
    pub first_bearing_rad: f64,
    /// From one to the next, radians.
    pub bearing_step_rad: f64,
    /// Full opening of a cone, radians.
    pub cone_rad: f64,
    /// Distance of the transducers from the middle, meters.
    pub ring_radius_m: f64,
    /// Nearer echoes are not heard, meters.
    pub min_range_m: f64,
    /// Reach, meters.
    pub max_range_m: f64,
}

/// A ring of bumpers in the frame of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BumperGeometry {
    /// How many; 0 where there are none.
    pub n_bumpers: u32,
    /// Bearing of the first, radians.
    pub first_bearing_rad: f64,
    /// From one to the next, radians.
    pub bearing_step_rad: f64,
}

/// What a sonar says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SonarReading {
    /// An echo, millimeters.
    Echo(u32),
    /// No echo within reach.
    Nothing,
    /// No reading.
    Lost,
}

/// How far the wheels have turned since the base was started.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelReport {
    /// The base's own clock, milliseconds.
    pub at_ms: u32,
    /// As sensors are told.
    pub wheels: WheelMotion,
}
