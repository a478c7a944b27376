//! How surely a landmark is known.

use nalgebra::Matrix2;
use rumbo_kit::landmarks::{Landmark, LandmarkKind};

/// Errors of landmarks and of the map that they are compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkErrors {
    /// Standard deviation of a range, meters.
    pub range_m: f64,
    /// Standard deviation of places on the map along each axis, meters.
    pub map_m: f64,
    /// The same for directions of walls, radians.
    pub map_rad: f64,
}

impl LandmarkErrors {
    /// On a grid a wall may begin anywhere in its cell, and each place is as likely: that has a variance of a twelfth of
    /// the square of the cell.
    pub fn on_cells_of(self, cell_m: f64) -> LandmarkErrors {
        LandmarkErrors { map_m: self.map_m.hypot(cell_m / 12.0_f64.sqrt()), ..self }
    }
}

/// What no wall is better than, meters and radians (0.15 degrees): a straight line is not what a wall is, and scans from
/// nearby places share this error.
const LEAST_WALL: (f64, f64) = (0.003, 0.0026);
/// Scans from nearby places find a corner at the same reading: so many of them know as much as one.
const SHARED: f64 = 3.0;

/// Covariance of a landmark, without the errors of a map: of a wall's distance and direction, of a point's place. Ranges
/// traced on a map have a deviation of zero.
pub fn spread(mark: &Landmark, range_m: f64) -> Matrix2<f64> {
    match mark.kind {
        LandmarkKind::Wall { unit_covariance: [dd, da, aa], unevenness_m, length_m } => {
            // What does not fit a straight line (a door frame, the end of another wall) moves it as a whole.
            let excess = (unevenness_m.powi(2) - range_m.powi(2)).max(0.0);
            let uneven = Matrix2::new(excess, 0.0, 0.0, excess / length_m.powi(2));
            let floor = Matrix2::new(LEAST_WALL.0.powi(2), 0.0, 0.0, LEAST_WALL.1.powi(2));
            Matrix2::new(dd, da, da, aa) * range_m.powi(2) + uneven + floor
        }
        // A corner may be the reading before or after it, and so may be the edge of a discontinuity.
        LandmarkKind::Corner { spacing_m } | LandmarkKind::Discontinuity { spacing_m, .. } => {
            Matrix2::identity() * (range_m.powi(2) + SHARED * spacing_m.powi(2))
        }
    }
}
