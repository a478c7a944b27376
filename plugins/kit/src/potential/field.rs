//! The sum of a goal's attraction and all obstacles' repulsion: equations (4) and (7).

use super::{Attraction, Nearest, Obstacles, Repulsion};
use nalgebra::{Point2, Vector2};

/// A goal among obstacles.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Where to, meters.
    pub goal: Point2<f64>,
    /// What it draws with.
    pub attraction: Attraction,
    /// What pushes.
    pub obstacles: &'a Obstacles,
    /// How.
    pub repulsion: Repulsion,
    /// Within this distance of the goal the repulsion fades with the square of the distance to it, so that the goal is a
    /// minimum wherever it lies (`d_s`), meters.
    pub goal_scaling_m: Option<f64>,
}

/// The field at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Potential of goal and obstacles.
    pub potential: f64,
    /// Minus its gradient.
    pub force: Vector2<f64>,
    /// The part of it that pushes away from obstacles.
    pub repulsion: Vector2<f64>,
    /// Distance to the nearest obstacle, meters; infinite where none is within reach.
    pub clearance_m: f64,
}

impl Field<'_> {
    /// Potential and force at a place.
    #[inline]
    pub fn sample(&self, at: Point2<f64>) -> Sample {
        let (mut potential, mut push) = (0.0, Vector2::zeros());
        let mut clearance_m = f64::INFINITY;
        let reach_m = self.repulsion.reach_m();
        self.obstacles.near(at, |Nearest { distance_m, away, .. }| {
            clearance_m = clearance_m.min(distance_m);
            if distance_m <= reach_m {
                potential += self.repulsion.potential(distance_m);
                push += away * self.repulsion.push(distance_m);
            }
        });
        let to_goal = self.goal - at;
        let distance_m = to_goal.norm();
        let mut drawn = if distance_m > 0.0 {
            to_goal * (self.attraction.slope(distance_m) / distance_m)
        } else {
            Vector2::zeros()
        };
        if let Some(fading_m) = self.goal_scaling_m
            && distance_m < fading_m
        {
            let share = (distance_m / fading_m).powi(2);
            // The gradient of the share draws, too.
            drawn += to_goal * (2.0 * potential / (fading_m * fading_m));
            potential *= share;
            push *= share;
        }
        potential += self.attraction.potential(distance_m);
        Sample { potential, force: drawn + push, repulsion: push, clearance_m }
    }
}
