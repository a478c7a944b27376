//! Natural landmarks of a planar scan: discontinuities, corners and walls. S. Hernández Alamilla, master's thesis (2005),
//! chapter 4.
//!
//! One pass in three levels: jumps of the range part the scan into segments, corners part the segments, and what is left
//! is straight: walls.

mod corners;
mod discontinuities;
mod extractor;
pub mod hough;
mod least_squares;
mod noise;
mod readings;

#[cfg(test)]
mod tests;

pub use extractor::{BeamFan, Extractor};
pub use noise::LandmarkNoise;
pub use readings::Reading;

use serde::{Deserialize, Serialize};

/// Something that can be recognized from another place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landmark {
    /// Distance, meters (D in the source); of a wall that of its line.
    pub distance_m: f64,
    /// Direction in the sensor's frame, radians in [-pi, pi) (theta); of a wall that of its normal, away from the sensor.
    pub bearing_rad: f64,
    /// What it is, with the attributes of its kind (T and P).
    pub kind: LandmarkKind,
    /// First and last reading it was made from, counted counter-clockwise.
    pub beams: [u32; 2],
}

/// Kinds of landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LandmarkKind {
    /// The range jumps: the nearer end of an edge behind which something is hidden.
    Discontinuity {
        /// Where the hidden region lies.
        hidden: Side,
        /// How far the range jumps, meters (P).
        jump_m: f64,
        /// To the next reading of the same surface, meters: the edge is known no better.
        spacing_m: f64,
    },
    /// Two straight pieces meet.
    Corner {
        /// To the farther of the readings beside it, meters: the corner is known no better.
        spacing_m: f64,
    },
    /// A straight piece.
    Wall {
        /// Distance of its ends, meters (P).
        length_m: f64,
        /// Covariance of distance and direction (distance², distance and direction, direction²) when the ranges have a
        /// variance of one: times the variance of a range it is that of the wall.
        unit_covariance: [f64; 3],
        /// Root of the mean square of how far readings are from the line, meters.
        unevenness_m: f64,
    },
}

/// A side of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Counter-clockwise.
    Left,
    /// Clockwise.
    Right,
}

impl Landmark {
    /// Its place, or the foot of its normal, in the sensor's frame, meters.
    pub fn position(&self) -> [f64; 2] {
        let (sin, cos) = self.bearing_rad.sin_cos();
        [self.distance_m * cos, self.distance_m * sin]
    }

    /// Jump of a discontinuity or length of a wall, meters (P in the source); corners have none.
    pub fn extent_m(&self) -> Option<f64> {
        match self.kind {
            LandmarkKind::Discontinuity { jump_m, .. } => Some(jump_m),
            LandmarkKind::Corner { .. } => None,
            LandmarkKind::Wall { length_m, .. } => Some(length_m),
        }
    }

    /// The source's letter: i and d for what hides its left or right, e for corners, p for walls (T).
    pub fn letter(&self) -> char {
        match self.kind {
            LandmarkKind::Discontinuity { hidden: Side::Left, .. } => 'i',
            LandmarkKind::Discontinuity { hidden: Side::Right, .. } => 'd',
            LandmarkKind::Corner { .. } => 'e',
            LandmarkKind::Wall { .. } => 'p',
        }
    }

    /// Whether it is a wall.
    pub fn is_wall(&self) -> bool {
        matches!(self.kind, LandmarkKind::Wall { .. })
    }
}

/// How walls are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WallFit {
    /// Least squares of the distances from the line.
    #[default]
    Tls,
    /// The source's local Hough transform, to the centimeter and the quarter of a degree.
    Hough,
}

/// When something is a landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkSettings {
    /// A jump of the range above this is a discontinuity, meters (mu_d).
    pub discontinuity_m: f64,
    /// A reading farther than this from the chord of its segment is a corner, meters (mu_e).
    pub corner_m: f64,
    /// A straight piece longer than this is a wall, meters (mu_p).
    pub wall_m: f64,
    /// And that has at least so many readings between its ends.
    pub least_readings: usize,
    /// How walls are fitted.
    pub wall_fit: WallFit,
    /// Jumps between readings of one wall that the beams graze are no discontinuities (not in the source).
    pub spares_grazed_walls: bool,
    /// Standard deviation of a range, meters; three of them are what one straight wall may be uneven.
    pub range_deviation_m: f64,
}

impl Default for LandmarkSettings {
    fn default() -> Self {
        LandmarkSettings {
            discontinuity_m: 0.20,
            corner_m: 0.15,
            wall_m: 0.30,
            least_readings: 5,
            wall_fit: WallFit::Tls,
            spares_grazed_walls: true,
            range_deviation_m: 0.015,
        }
    }
}

impl LandmarkSettings {
    /// How far a reading of a straight wall may lie from its line, meters.
    fn unevenness_m(&self) -> f64 {
        3.0 * self.range_deviation_m
    }
}
