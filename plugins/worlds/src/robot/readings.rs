//! What a base measured and nobody has taken yet.

use rumbo_core::stages::WheelMotion;
use rumbo_core::time::Time;

/// A reading and when it arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamped<T> {
    /// The reading.
    pub value: T,
    /// When it arrived, on the clock of the connection.
    pub at: Time,
}

/// The newest of each kind; a reading is taken once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readings {
    /// Rolling of the wheels.
    pub wheels: Option<Stamped<WheelMotion>>,
    /// Ranges of the sonars, meters.
    pub ranges_m: Option<Stamped<Vec<f32>>>,
    /// Bumpers that are pressed, one bit each.
    pub touch: Option<Stamped<u64>>,
}
