//! Where a charge goes: equation (8) as it can be meant, and on which side.

use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use rumbo_core::rng::{Rng, RngExt};

/// Headings that differ by less than this cosine are a tie.
const SAME_COSINE: f64 = 1e-9;
/// A vector shorter than this has no direction.
const NO_DIRECTION: f64 = 1e-12;

/// On which side of the way to the goal charges go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideRule {
    /// The side from which the robot is pushed the way that it is heading, to the left on a tie.
    LeastTurn,
    /// Left.
    Left,
    /// Right.
    Right,
    /// By chance.
    Random,
}

/// A side of the way to the goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Turned by +90 degrees.
    Left,
    /// Turned by -90 degrees.
    Right,
}

/// How equation (8) is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// `q + ψ n(-n(F_r) + u)`: exactly the distance from the robot.
    Unit,
    /// `q + ψ (-F_r + u)`: the push of the obstacles as it is.
    Literal,
}

/// What a charge is placed by.
#[derive(Clone, Copy, Debug)]
pub struct Minimum {
    /// Where the robot is.
    pub at: Point2,
    /// Where it wants to.
    pub goal: Point2,
    /// The push of the real obstacles there (`F_r`).
    pub repulsion: Vector2<f64>,
    /// The way it is heading, of length one; none before the first step.
    pub heading: Option<Vector2<f64>>,
}

impl Side {
    /// Right for left.
    pub fn other(self) -> Side {
        match self {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        }
    }
}

impl SideRule {
    /// The side at this minimum.
    pub fn side(self, minimum: &Minimum, rng: &mut Rng) -> Side {
        match self {
            SideRule::Left => Side::Left,
            SideRule::Right => Side::Right,
            SideRule::Random => {
                if rng.random_bool(0.5) {
                    Side::Left
                } else {
                    Side::Right
                }
            }
            SideRule::LeastTurn => {
                let to_goal = minimum.to_goal();
                let heading = minimum.heading.unwrap_or(to_goal);
                // A charge on the right pushes to the left.
                if heading.dot(&left_of(to_goal)) >= -SAME_COSINE { Side::Right } else { Side::Left }
            }
        }
    }
}

impl Minimum {
    /// Place of a charge on this side at the distance `ψ`.
    pub fn charge(&self, side: Side, placement: Placement, distance_m: f64) -> Point2 {
        let to_goal = self.to_goal();
        let sideways = match side {
            Side::Left => left_of(to_goal),
            Side::Right => -left_of(to_goal),
        };
        let size = self.repulsion.norm();
        let offset = match placement {
            Placement::Literal => -self.repulsion + sideways,
            Placement::Unit => {
                let ahead = if size > NO_DIRECTION { -self.repulsion / size } else { to_goal };
                let both = ahead + sideways;
                if both.norm() > 1e-9 { both.normalize() } else { (to_goal + sideways).normalize() }
            }
        };
        self.at + offset * distance_m
    }

    fn to_goal(self) -> Vector2<f64> {
        (self.goal - self.at).try_normalize(NO_DIRECTION).unwrap_or_else(Vector2::x)
    }
}

fn left_of(way: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-way.y, way.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::rng::stream;

    fn frontal(heading: Option<Vector2<f64>>) -> Minimum {
        let (at, goal) = (Point2::new(20.0, 15.0), Point2::new(20.0, 25.0));
        Minimum { at, goal, repulsion: Vector2::new(0.0, -0.5), heading }
    }

    #[test]
    fn in_a_frontal_minimum_the_charge_is_ahead_to_one_side() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let at = frontal(None).charge(Side::Right, Placement::Unit, 1.0);
        assert!((at - Point2::new(20.0 + half, 15.0 + half)).norm() < 1e-12);
        let at = frontal(None).charge(Side::Left, Placement::Unit, 2.0);
        assert!((at - Point2::new(20.0 - 2.0 * half, 15.0 + 2.0 * half)).norm() < 1e-12);
        // 1.12 m away where both parts are as they are.
        let at = frontal(None).charge(Side::Right, Placement::Literal, 1.0);
        assert!((at - Point2::new(21.0, 15.5)).norm() < 1e-12);
    }

    #[test]
    fn without_a_push_the_way_to_the_goal_counts_and_opposites_do_not_cancel() {
        let free = Minimum { repulsion: Vector2::zeros(), ..frontal(None) };
        let at = free.charge(Side::Right, Placement::Unit, 1.0);
        assert!((at - frontal(None).charge(Side::Right, Placement::Unit, 1.0)).norm() < 1e-12);
        let opposite = Minimum { repulsion: Vector2::new(1.0, 0.0), ..frontal(None) };
        let at = opposite.charge(Side::Right, Placement::Unit, 1.0);
        assert!(((at - opposite.at).norm() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_robot_is_pushed_the_way_that_it_is_heading() {
        let mut rng = stream(1, "test");
        let mut side = |rule: SideRule, heading| rule.side(&frontal(heading), &mut rng);
        let (west, east) = (Vector2::new(-1.0, 0.0), Vector2::new(1.0, 0.0));
        assert_eq!(side(SideRule::LeastTurn, Some(west)), Side::Right);
        assert_eq!(side(SideRule::LeastTurn, Some(east)), Side::Left);
        assert_eq!(side(SideRule::LeastTurn, None), Side::Right);
        assert_eq!(side(SideRule::Left, Some(west)), Side::Left);
        assert_eq!(side(SideRule::Right, Some(east)), Side::Right);
        let drawn: Vec<Side> = (0..40).map(|_| side(SideRule::Random, None)).collect();
        assert!(drawn.contains(&Side::Left) && drawn.contains(&Side::Right));
    }
}
