//! Corners of a path made into arcs.

use nalgebra::Vector2;
use rumbo_core::frames::Point2;

/// Chords of an arc turn by at most this, radians.
const CHORD_RAD: f64 = 0.2;
/// Turns below this are no corners, radians.
const STRAIGHT_RAD: f64 = 0.02;
/// Turns above this are turns back, radians.
const TURN_BACK_RAD: f64 = 3.0;
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

/// Rounds each corner with an arc that touches both legs, of `radius_m` or the larger of it and `least_radius_m`, where the
/// legs and the room allow it, and of less where they do not. Two corners that need more than the leg between them share it
/// as they need it.
pub(super) fn rounded(
    way: &[Point2],
    radius_m: f64,
    least_radius_m: f64,
    is_clear: &dyn Fn(Point2, Point2) -> bool,
) -> Rounded {
    let mut path = Rounded { points: way.first().copied().into_iter().collect(), n_tight_corners: 0 };
    let wanted_m = radius_m.max(least_radius_m);
    let bends: Vec<Bend> = way.windows(3).map(|corner| Bend::new(corner[0], corner[1], corner[2])).collect();
    let needs_m: Vec<f64> = bends.iter().map(|bend| bend.tangent_m(wanted_m)).collect();
    let need_of = |k: usize| needs_m.get(k).copied().unwrap_or(0.0);
    for (k, bend) in bends.iter().enumerate() {
        let before = if k > 0 { need_of(k - 1) } else { 0.0 };
        let most_m =
            share(bend.before_m, need_of(k), before).min(share(bend.after_m, need_of(k), need_of(k + 1)));
        let (arc, radius_m) = bend.arc_with_room(most_m, is_clear);
        let is_tight = bend.turn_rad.abs() > STRAIGHT_RAD && radius_m < least_radius_m - 1e-9;
        path.n_tight_corners += usize::from(is_tight);
        path.points.extend(arc);
    }
    path.points.extend(way.last().filter(|_| way.len() > 1));
    path
}

/// What a corner gets of a leg when it and the corner at the other end need so much, meters.
fn share(leg_m: f64, need_m: f64, other_m: f64) -> f64 {
    if need_m + other_m <= leg_m { need_m } else { leg_m * need_m / (need_m + other_m) }
}

struct Bend {
    corner: Point2,
    /// Directions of the legs.
    before: Vector2<f64>,
    after: Vector2<f64>,
    /// Their lengths, meters.
    before_m: f64,
    after_m: f64,
    turn_rad: f64,
}

impl Bend {
    fn new(from: Point2, corner: Point2, to: Point2) -> Bend {
        let (before, after) = (corner - from, to - corner);
        let (before_m, after_m) = (before.norm(), after.norm());
        let (before, after) = (before / before_m.max(1e-12), after / after_m.max(1e-12));
        let turn_rad = before.perp(&after).atan2(before.dot(&after));
        Bend { corner, before, after, before_m, after_m, turn_rad }
    }

    /// Length of the tangents of an arc of this radius for each meter of it.
    fn tangent_per_radius(&self) -> f64 {
        (0.5 * self.turn_rad.abs()).tan()
    }

    /// What an arc of this radius takes of each leg, meters; nothing where there is no corner, or a turn back.
    fn tangent_m(&self, radius_m: f64) -> f64 {
        let is_bend = self.turn_rad.abs() > STRAIGHT_RAD && self.turn_rad.abs() < TURN_BACK_RAD;
        if is_bend { radius_m * self.tangent_per_radius() } else { 0.0 }
    }

    /// Points of the widest arc that takes at most so much of each leg and has room, and its radius; the corner itself, of
    /// radius zero, where none has.
    fn arc_with_room(&self, most_m: f64, is_clear: &dyn Fn(Point2, Point2) -> bool) -> (Vec<Point2>, f64) {
        if most_m <= 0.0 {
            return (vec![self.corner], 0.0);
        }
        let mut tangent_m = most_m;
        for _ in 0..MOST_TRIES {
            let arc = self.arc(tangent_m);
            if arc.windows(2).all(|chord| is_clear(chord[0], chord[1])) {
                return (arc, tangent_m / self.tangent_per_radius());
            }
            tangent_m *= SMALLER;
        }
        (vec![self.corner], 0.0)
    }

    fn arc(&self, tangent_m: f64) -> Vec<Point2> {
        let begin = self.corner - self.before * tangent_m;
        let radius_m = tangent_m / self.tangent_per_radius();
        let inwards = Vector2::new(-self.before.y, self.before.x) * self.turn_rad.signum();
        let n = (self.turn_rad.abs() / CHORD_RAD).ceil().max(1.0) as usize;
        let at = |k: usize| {
            let turned = self.turn_rad.abs() * k as f64 / n as f64;
            begin + self.before * (radius_m * turned.sin()) + inwards * (radius_m * (1.0 - turned.cos()))
        };
        let mut points: Vec<Point2> = (0..n).map(at).collect();
        points.push(self.corner + self.after * tangent_m);
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
    fn legs_limit_arcs_and_too_small_arcs_are_counted() {
        let path = rounded(&corner(), 0.0, 5.0, &|_, _| true);
        assert!((path.points[1] - Point2::new(0.0, 0.0)).norm() < 1e-12);
        assert_eq!(path.n_tight_corners, 1);
        assert_eq!(rounded(&corner(), 0.5, 2.0, &|_, _| true).n_tight_corners, 0);
        // Two equal corners share the leg between them.
        let two = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [9.0, 2.0]].map(Point2::from);
        let path = rounded(&two, 3.0, 0.0, &|_, _| true);
        assert!(path.points.iter().any(|point| (point - Point2::new(4.0, 1.0)).norm() < 1e-12));
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
