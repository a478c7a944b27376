//! How sure the filter is of the pose.

use nalgebra::Matrix3;
use rumbo_core::messages::Status;

use crate::deviations::deviations;

/// When a robot counts as followed, and when as lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sureness {
    /// Position, standard deviation, meters.
    pub sure_m: f64,
    /// Heading, standard deviation, radians.
    pub sure_rad: f64,
    /// So many sightings in a row that do not fit.
    pub lost_after: u32,
}

impl Sureness {
    /// What to say of a belief with this covariance, after so many sightings in a row that did not fit.
    pub fn status(&self, covariance: &Matrix3<f64>, n_refused: u32) -> Status {
        let [position_m, heading_rad] = deviations(covariance);
        if n_refused >= self.lost_after {
            Status::Lost
        } else if position_m <= self.sure_m && heading_rad <= self.sure_rad {
            Status::Tracking
        } else {
            Status::Converging
        }
    }
}
