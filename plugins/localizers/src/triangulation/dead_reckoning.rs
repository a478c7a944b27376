//! What an odometer's errors do to a pose on its way, and how they change.
//!
//! Most errors of an odometer are the same from meter to meter (Borenstein and Feng 1996): a wheel that is larger than
//! the other bends every way to the same side. They are worth knowing: scans tell them, and where no landmark is seen
//! they are all that goes wrong.

pub use crate::odometry::propagation::Way;

use nalgebra::{Matrix3, Vector3};

/// An odometer is never taken to be better than this, whatever it claims: m/m, rad/m, rad/rad. One that boasts would
/// outvote landmarks; scans soon tell how good one really is.
const LEAST_NOISE: [f64; 3] = [0.01, 0.01, 0.02];
/// Share of each claimed deviation that is new on every way, beside the one that stays: wheels that slip in turns do so
/// each time anew.
const NEW_SHARE: [f64; 3] = [0.5, 0.5, 1.0];
/// Errors that stay do so for about this long a way, meters; a radian counts as a meter.
const STAYS_M: f64 = 10.0;

impl Way {
    /// Covariance that errors which are new on this way add; `noise` is what the odometer claims of itself.
    pub fn new_errors(&self, noise: [f64; 3]) -> Matrix3<f64> {
        let deviations = Vector3::from(sigmas(noise)).component_mul(&Vector3::from(NEW_SHARE));
        let effect = self.by_errors() * Matrix3::from_diagonal(&deviations);
        effect * effect.transpose()
    }

    /// What is left of errors after the way.
    pub fn keeps(&self) -> f64 {
        (-(self.along.norm() + self.turn_rad.abs()) / STAYS_M).exp()
    }
}

/// Standard deviations of errors that stay.
pub fn sigmas(noise: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| noise[k].abs().max(LEAST_NOISE[k]))
}
