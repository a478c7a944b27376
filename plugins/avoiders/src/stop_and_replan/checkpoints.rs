//! Checkpoints: the points of a path where the robot must turn.
//!
//! A path of one point a cell would make the robot stop in every cell; points on a straight piece are left out.

use rumbo_core::frames::{Point2, wrap_angle};
use rumbo_core::messages::PathPoint;

/// Puts the first point, the last point and the corners between them into `corners`, so that no point left out is
/// farther than `within_m` from the straight piece that replaces it.
///
/// Cone intersection (Williams 1978, *An efficient algorithm for the piecewise linear approximation of planar curves*):
/// one pass, every point looked at once.
pub fn keep_corners(points: &[PathPoint], within_m: f64, corners: &mut Vec<Point2>) {
    corners.clear();
    let Some((first, rest)) = points.split_first() else { return };
    corners.push(first.position);
    let mut cone = Cone::at(first.position);
    let mut before = first.position;
    for point in rest {
        if !cone.accepts(point.position, within_m) {
            corners.push(before);
            cone = Cone::at(before);
            // The first point of a new piece always fits.
            cone.accepts(point.position, within_m);
        }
        before = point.position;
    }
    if rest.is_empty() || (before - cone.apex).norm() <= 0.0 {
        return;
    }
    corners.push(before);
}

/// Directions from a corner in which a straight piece passes all points seen so far closely enough.
struct Cone {
    apex: Point2,
    reference_rad: f64,
    /// Limits on both sides of the reference, once a point was far enough to give any.
    limits_rad: Option<(f64, f64)>,
    farthest_m: f64,
}

impl Cone {
    fn at(apex: Point2) -> Cone {
        Cone { apex, reference_rad: 0.0, limits_rad: None, farthest_m: 0.0 }
    }

    /// Whether a straight piece from the apex to `point` stays near every point accepted before; then narrows the cone.
    fn accepts(&mut self, point: Point2, within_m: f64) -> bool {
        let to_point = point - self.apex;
        let distance_m = to_point.norm();
        if distance_m < self.farthest_m - 1e-9 {
            return false;
        }
        if distance_m <= within_m.max(1e-9) {
            // Too near for a direction; it stays near every piece that begins here.
            self.farthest_m = self.farthest_m.max(distance_m);
            return self.limits_rad.is_none();
        }
        let direction_rad = to_point.y.atan2(to_point.x);
        // Rounding must not bend a straight piece.
        let slack_rad = (within_m / distance_m).asin() + 1e-9;
        let limits = match self.limits_rad {
            None => {
                self.reference_rad = direction_rad;
                (-slack_rad, slack_rad)
            }
            Some((low, high)) => {
                let off_rad = wrap_angle(direction_rad - self.reference_rad);
                if off_rad < low || off_rad > high {
                    return false;
                }
                (low.max(off_rad - slack_rad), high.min(off_rad + slack_rad))
            }
        };
        self.limits_rad = Some(limits);
        self.farthest_m = self.farthest_m.max(distance_m);
        true
    }
}

/// Which checkpoint to go to first: the second where the robot already stands on the way there, since a path begins
/// where the robot was when it was asked for.
pub fn first_target(corners: &[Point2], position: Point2, on_the_way_m: f64) -> usize {
    match corners {
        [from, to, ..] if distance_to_segment_m(position, *from, *to) <= on_the_way_m => 1,
        _ => 0,
    }
}

fn distance_to_segment_m(point: Point2, from: Point2, to: Point2) -> f64 {
    let (piece, to_point) = (to - from, point - from);
    let along = (to_point.dot(&piece) / piece.norm_squared().max(1e-18)).clamp(0.0, 1.0);
    (to_point - piece * along).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rumbo_core::rng;

    fn path(points: &[(f64, f64)]) -> Vec<PathPoint> {
        points.iter().map(|(x, y)| PathPoint { position: Point2::new(*x, *y), yaw_rad: None }).collect()
    }

    fn corners(points: &[(f64, f64)], within_m: f64) -> Vec<(f64, f64)> {
        let mut out = Vec::new();
        keep_corners(&path(points), within_m, &mut out);
        out.iter().map(|p| (p.x, p.y)).collect()
    }

    #[test]
    fn points_on_a_straight_piece_are_left_out_and_corners_stay() {
        let cells: Vec<(f64, f64)> = (0..10).map(|i| (0.1 * f64::from(i), 0.3)).collect();
        assert_eq!(corners(&cells, 0.0), [(0.0, 0.3), (0.9, 0.3)]);
        let bent = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 3.0), (1.0, 4.0), (0.0, 5.0)];
        assert_eq!(corners(&bent, 0.0), [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (0.0, 5.0)]);
    }

    #[test]
    fn a_way_back_is_a_corner_and_a_repeated_point_is_none() {
        assert_eq!(
            corners(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)], 0.02),
            [(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)]
        );
        assert_eq!(corners(&[(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (1.0, 0.0)], 0.0), [(0.0, 0.0), (1.0, 0.0)]);
        assert_eq!(corners(&[(3.0, 1.0)], 0.02), [(3.0, 1.0)]);
        assert_eq!(corners(&[(3.0, 1.0), (3.0, 1.0)], 0.02), [(3.0, 1.0)]);
        assert_eq!(corners(&[], 0.02), []);
    }

    #[test]
    fn a_straight_piece_along_the_half_turn_has_no_corners() {
        let wobbly: Vec<(f64, f64)> =
            (0..20).map(|i| (-0.1 * f64::from(i), 0.004 * f64::from(i % 2) - 0.002)).collect();
        assert_eq!(corners(&wobbly, 0.01).len(), 2);
    }

    #[test]
    fn no_point_left_out_is_farther_from_its_piece_than_allowed() {
        let mut rng = rng::stream(11, "corners");
        for _ in 0..300 {
            let (mut x, mut y, mut heading) = (0.0f64, 0.0f64, 0.0f64);
            let points: Vec<(f64, f64)> = (0..60)
                .map(|_| {
                    heading += rng.random_range(-0.4..0.4);
                    x += 0.05 * heading.cos();
                    y += 0.05 * heading.sin();
                    (x, y)
                })
                .collect();
            let kept: Vec<Point2> = corners(&points, 0.03).iter().map(|(x, y)| Point2::new(*x, *y)).collect();
            let mut piece = 0;
            for (x, y) in points {
                let point = Point2::new(x, y);
                while piece + 2 < kept.len() && point != kept[piece] && point == kept[piece + 1] {
                    piece += 1;
                }
                let off_m = distance_to_segment_m(point, kept[piece], kept[piece + 1]);
                assert!(off_m <= 0.0301, "{off_m}");
            }
        }
    }

    #[test]
    fn the_first_target_is_the_start_only_for_a_robot_that_stands_elsewhere() {
        let corners = [Point2::new(0.0, 0.0), Point2::new(2.0, 0.0)];
        assert_eq!(first_target(&corners, Point2::new(0.05, -0.02), 0.1), 1);
        assert_eq!(first_target(&corners, Point2::new(-0.05, 0.0), 0.1), 1);
        assert_eq!(first_target(&corners, Point2::new(0.5, 0.5), 0.1), 0);
        assert_eq!(first_target(&corners[..1], Point2::origin(), 0.1), 0);
    }
}
