//! Time is an input: whole nanoseconds since the start of the run (virtual) or of the Unix epoch (real).

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::{Add, Sub};

/// A point in time, nanoseconds.
#[doc(alias = "stamp")]
#[doc(alias = "rclcpp::Time")]
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Time(pub i64);

/// A span of time, nanoseconds; negative where something lies in the past.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Span(pub i64);

impl Time {
    /// The start of a run.
    pub const ZERO: Time = Time(0);
    /// Later than everything.
    pub const MAX: Time = Time(i64::MAX);

    /// Seconds as a number, for formulas and people.
    pub fn as_secs(self) -> f64 {
        self.0 as f64 / 1e9
    }

    /// The nearest nanosecond to `seconds`; not-a-number becomes zero, infinities saturate.
    pub fn from_secs(seconds: f64) -> Time {
        Time((seconds * 1e9).round() as i64)
    }
}

impl Span {
    /// No time.
    pub const ZERO: Span = Span(0);

    /// Seconds as a number.
    pub fn as_secs(self) -> f64 {
        self.0 as f64 / 1e9
    }

    /// The nearest nanosecond to `seconds`; not-a-number becomes zero, infinities saturate.
    pub fn from_secs(seconds: f64) -> Span {
        Span((seconds * 1e9).round() as i64)
    }
}

impl Add<Span> for Time {
    type Output = Time;
    fn add(self, span: Span) -> Time {
        Time(self.0.saturating_add(span.0))
    }
}

impl Sub<Span> for Time {
    type Output = Time;
    fn sub(self, span: Span) -> Time {
        Time(self.0.saturating_sub(span.0))
    }
}

impl Sub for Time {
    type Output = Span;
    fn sub(self, earlier: Time) -> Span {
        Span(self.0.saturating_sub(earlier.0))
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s", self.as_secs())
    }
}
