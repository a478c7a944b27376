//! Corners of a path made into arcs.

use rumbo_core::frames::Point2;

/// Chords of an arc turn by at most this, radians.
const CHORD_RAD: f64 = 0.2;
/// Turns below this are no corners, radians.
const STRAIGHT_RAD: f64 = 0.02;
/// An arc that finds no room is tried again with this share of its radius, so many times.
const SMALLER: f64 = 0.7;
const MOST_TRIES: usize = 8;

/// A path with rounded corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Rounded {
    /// Its points.
    pub points: Vec<Point2>,
    /// Corners that turn on a smaller radius than the robot can.
    pub n_tight_corners: usize,
}

/// Rounds each corner with an arc that touches both legs, of `radius_m` or the larger of it and `least_radius_m`, where half
/// of each leg and the room allow it, and of less where they do not.
pub(super) fn rounded(
    way: &[Point2],
    radius_m: f64,
    least_radius_m: f64,
    is_clear: &dyn Fn(Point2, Point2) -> bool,
) -> Rounded {
    let mut path = Rounded { points: way.first().copied().into_iter().collect(), n_tight_corners: 0 };
    for corner in way.windows(3) {
        let bend = Bend::new(corner[0], corner[1], corner[2]);
        let wanted_m = radius_m.max(least_radius_m);
        let (arc, radius_m) = bend.arc_with_room(wanted_m, is_clear);
        let is_tight = bend.turn_rad.abs() > STRAIGHT_RAD && radius_m < least_radius_m - 1e-9;
        path.n_tight_corners += usize::from(is_tight);
        path.points.extend(arc);
    }
    path.points.extend(way.last().filter(|_| way.len() > 1));
    path
}

struct Bend {
    corner: Point2,
    /// Directions of the legs.
    before: nalgebra::Vector2<f64>,
    after: nalgebra::Vector2<f64>,
    turn_rad: f64,
    /// Half of the shorter leg, meters.
    half_leg_m: f64,
}

impl Bend {
    fn new(from: Point2, corner: Point2, to: Point2) -> Bend {
        let (before, after) = (corner - from, to - corner);
        let (b, a) = (before.norm(), after.norm());
        let (before, after) = (before / b.max(1e-12), after / a.max(1e-12));
        let turn_rad = before.perp(&after).atan2(before.dot(&after));
        Bend { corner, before, after, turn_rad, half_leg_m: 0.5 * b.min(a) }
    }

    /// Points of the arc and its radius; the corner itself, of radius zero, where no arc has room.
    fn arc_with_room(&self, wanted_m: f64, is_clear: &dyn Fn(Point2, Point2) -> bool) -> (Vec<Point2>, f64) {
        let per_radius = (0.5 * self.turn_rad.abs()).tan();
        let is_bend = self.turn_rad.abs() > STRAIGHT_RAD && self.turn_rad.abs() < 3.0;
        if !is_bend || wanted_m <= 0.0 {
            return (vec![self.corner], 0.0);
        }
        let mut radius_m = wanted_m.min(self.half_leg_m / per_radius);
        for _ in 0..MOST_TRIES {
            let arc = self.arc(radius_m, per_radius);
            if arc.windows(2).all(|chord| is_clear(chord[0], chord[1])) {
                return (arc, radius_m);
            }
            radius_m *= SMALLER;
        }
        (vec![self.corner], 0.0)
    }

    fn arc(&self, radius_m: f64, per_radius: f64) -> Vec<Point2> {
        let begin = self.corner - self.before * (radius_m * per_radius);
        let side = self.turn_rad.signum();
        let inwards = nalgebra::Vector2::new(-self.before.y, self.before.x) * side;
        let n = (self.turn_rad.abs() / CHORD_RAD).ceil().max(1.0) as usize;
        let at = |k: usize| {
            let turned = self.turn_rad.abs() * k as f64 / n as f64;
            begin + self.before * (radius_m * turned.sin()) + inwards * (radius_m * (1.0 - turned.cos()))
        };
        let mut points: Vec<Point2> = (0..n).map(at).collect();
        points.push(self.corner + self.after * (radius_m * per_radius));
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [[f64; 2]; 3] = [[0.0, 0.0], [4.0, 0.0], [4.0, -6.0]];

    fn corner() -> Vec<Point2> {
        CORNER.map(Point2::from).to_vec()
    }

    #[test]
    fn an_arc_lies_on_its_circle_and_joins_its_legs() {
        let path = rounded(&corner(), 1.0, 0.0, &|_, _| true);
        let middle = Point2::new(3.0, -1.0);
        let n = path.points.len();
        assert!(n > 8);
        for point in &path.points[1..n - 1] {
            assert!(((point - middle).norm() - 1.0).abs() < 1e-12, "{point}");
        }
        assert!((path.points[1] - Point2::new(3.0, 0.0)).norm() < 1e-12);
        assert!((path.points[n - 2] - Point2::new(4.0, -1.0)).norm() < 1e-12);
        assert_eq!((path.points[0], path.points[n - 1]), (corner()[0], corner()[2]));
    }

    #[test]
    fn half_a_leg_limits_an_arc_and_too_small_arcs_are_counted() {
        let path = rounded(&corner(), 0.0, 3.0, &|_, _| true);
        assert!((path.points[1] - Point2::new(2.0, 0.0)).norm() < 1e-12);
        assert_eq!(path.n_tight_corners, 1);
        assert_eq!(rounded(&corner(), 0.5, 2.0, &|_, _| true).n_tight_corners, 0);
    }

    #[test]
    fn an_arc_without_room_is_smaller_or_stays_a_corner() {
        let none = rounded(&corner(), 1.0, 0.2, &|_, _| false);
        assert_eq!((none.points, none.n_tight_corners), (corner(), 1));
        let outside = |a: Point2, b: Point2| a.x.min(b.x) > 3.4;
        let small = rounded(&corner(), 1.0, 0.2, &outside);
        assert!(small.points.len() > 5 && small.points[1].x > 3.4 && small.n_tight_corners == 0);
        let straight = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]].map(Point2::from);
        assert_eq!(rounded(&straight, 1.0, 0.0, &|_, _| true).points, straight);
    }
}
