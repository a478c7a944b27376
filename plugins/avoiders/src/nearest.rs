//! The nearest thing, and the side that is away from it.

use crate::near_points::NearPoint;
use rumbo_core::frames::Point2;

/// The nearest thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stimulus {
    /// How far, meters.
    pub distance_m: f64,
    /// Where, counter-clockwise from straight ahead, radians.
    pub bearing_rad: f64,
}

/// A side of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Counter-clockwise.
    Left,
    /// Clockwise.
    Right,
}

impl Side {
    /// Away from a bearing; from dead ahead to the left.
    pub fn away_from(bearing_rad: f64) -> Side {
        if bearing_rad > 0.0 { Side::Right } else { Side::Left }
    }

    /// 1 counter-clockwise, -1 clockwise.
    pub fn sign(self) -> f64 {
        if self == Side::Left { 1.0 } else { -1.0 }
    }
}

/// The nearest of some points.
pub fn closest(points: &[NearPoint]) -> Option<Point2> {
    nearest_of(points.iter().map(|near| near.in_base))
}

fn nearest_of(points: impl Iterator<Item = Point2>) -> Option<Point2> {
    points.min_by(|a, b| a.coords.norm_squared().total_cmp(&b.coords.norm_squared()))
}

/// The nearest thing. Where it is dead ahead to within rounding, such as a wall that the robot meets squarely, it counts to
/// the side on which more is near, so that the robot turns to where there is room: the published rule turns left there.
/// Things farther than `half_view_rad` to the side are not met.
pub fn nearest(points: &[NearPoint], half_view_rad: f64) -> Option<Stimulus> {
    const DEAD_AHEAD_RAD: f64 = 1e-6;
    const BALANCED: f64 = 1e-6;
    let bearing_of = |point: &Point2| point.y.atan2(point.x);
    let in_base = points.iter().map(|near| near.in_base);
    let point = nearest_of(in_base.filter(|point| bearing_of(point).abs() <= half_view_rad))?;
    let (distance_m, bearing_rad) = (point.coords.norm(), bearing_of(&point));
    if bearing_rad.abs() > DEAD_AHEAD_RAD {
        return Some(Stimulus { distance_m, bearing_rad });
    }
    // Each thing weighs by how far it is to the side, and how near.
    let weigh = |near: &NearPoint| near.in_base.y / near.in_base.coords.norm_squared().max(1e-6);
    let crowd: f64 = points.iter().map(weigh).sum();
    let bearing_rad = if crowd.abs() <= BALANCED { 0.0 } else { DEAD_AHEAD_RAD * crowd.signum() };
    Some(Stimulus { distance_m, bearing_rad })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::time::Time;
    use std::f64::consts::PI;

    fn points(points: &[(f64, f64)]) -> Vec<NearPoint> {
        let near = |&(x, y): &(f64, f64)| NearPoint {
            in_base: Point2::new(x, y),
            stamp: Time::ZERO,
            is_remembered: false,
        };
        points.iter().map(near).collect()
    }

    #[test]
    fn a_wall_met_squarely_is_left_on_the_side_with_more_room() {
        let side = |xs: &[(f64, f64)]| Side::away_from(nearest(&points(xs), PI).unwrap().bearing_rad);
        assert_eq!(side(&[(0.7, 0.0), (0.7, 0.5), (0.7, -0.5)]), Side::Left);
        assert_eq!(side(&[(0.7, 0.0), (0.7, 0.5), (0.7, -0.5), (0.0, 2.0)]), Side::Right);
        assert_eq!(side(&[(0.7, 0.0), (0.7, 0.5), (0.7, -0.5), (0.0, -2.0)]), Side::Left);
        // Not dead ahead: its own side counts.
        assert_eq!(side(&[(0.7, 0.01), (0.0, -0.9)]), Side::Right);
        assert_eq!(nearest(&[], PI), None);
        let beside = points(&[(0.0, 0.4), (0.9, 0.1)]);
        assert!((nearest(&beside, PI).unwrap().distance_m - 0.4).abs() < 1e-12);
        assert!((nearest(&beside, 0.8).unwrap().distance_m - 0.82f64.sqrt()).abs() < 1e-12);
    }
}
