//! What draws the robot to its goal: equation (5).

/// How the attraction grows with the distance to the goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// ½ ξ d, as the source prints it: the same force everywhere.
    Conic,
    /// ½ ξ d², the usual form of textbooks: the force grows with the distance.
    Quadratic,
    /// Quadratic within this distance of the goal, conic outside, with one slope where they meet, meters.
    Combined {
        /// `d_c`.
        radius_m: f64,
    },
}

/// The attraction of a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attraction {
    /// How it grows.
    pub form: Form,
    /// `ξ`.
    pub strength: f64,
}

impl Attraction {
    /// The potential at a distance from the goal.
    pub fn potential(&self, distance_m: f64) -> f64 {
        let d = distance_m;
        let shape = match self.form {
            Form::Conic => d,
            Form::Quadratic => d * d,
            Form::Combined { radius_m } if d < radius_m => 0.5 * (d * d / radius_m + radius_m),
            Form::Combined { .. } => d,
        };
        0.5 * self.strength * shape
    }

    /// Derivative of the potential with the distance: the size of the force towards the goal.
    pub fn slope(&self, distance_m: f64) -> f64 {
        let shape = match self.form {
            Form::Conic => 1.0,
            Form::Quadratic => 2.0 * distance_m,
            Form::Combined { radius_m } => (distance_m / radius_m).min(1.0),
        };
        0.5 * self.strength * shape
    }
}
