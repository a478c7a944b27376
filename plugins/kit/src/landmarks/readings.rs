//! Readings with their places, from the right to the left.

/// One reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Place in the sensor's frame, meters; zeros where there is no reading.
    pub place: [f64; 2],
    /// Range, meters; not-a-number where there is no reading.
    pub range_m: f64,
}

impl Reading {
    /// A beam that met something.
    pub fn at(bearing_rad: f64, range_m: f64) -> Reading {
        let (sin, cos) = bearing_rad.sin_cos();
        Reading::along([cos, sin], range_m)
    }

    /// The same along a unit vector.
    pub(super) fn along([x, y]: [f64; 2], range_m: f64) -> Reading {
        Reading { place: [range_m * x, range_m * y], range_m }
    }

    /// A beam that says nothing.
    pub(super) const NONE: Reading = Reading { place: [0.0; 2], range_m: f64::NAN };

    /// There is a reading.
    pub fn is_valid(&self) -> bool {
        !self.range_m.is_nan()
    }
}

/// From one place to another.
pub(super) fn way(from: &Reading, to: &Reading) -> [f64; 2] {
    [to.place[0] - from.place[0], to.place[1] - from.place[1]]
}

/// The third component of the cross product of two ways.
pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
