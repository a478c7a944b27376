//! Where the robot is by two landmarks. Hernández Alamilla (2005), sections 5.3.1 and 5.3.2.

use super::correspondence::{Relation, is_point};
use rumbo_core::frames::{Point2, wrap_angle};

/// Landmarks nearer to each other than this fix no position, meters.
const LEAST_BASE_M: f64 = 0.10;
/// Walls whose normals enclose less than 10 degrees are parallel: sine of that.
const LEAST_SINE: f64 = 0.17;
/// Rounding may make the square of a distance this negative, to the fourth power of a meter.
const ROUNDING: f64 = -1e-9;

/// A position by two landmarks and what its quality depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairEstimate {
    /// In the frame of the earlier place, meters.
    pub position: [f64; 2],
    /// Angle between the landmarks as seen from the later place, radians from 0 to pi.
    pub separation_rad: f64,
    /// Distance to the farther one, meters.
    pub farthest_m: f64,
    /// One is to the left of the heading and one to the right.
    pub on_both_sides: bool,
}

/// Both places at given distances from two points: the circles around them meet there (equations 5.7 and 5.10, where the
/// printed 1/(2a) ± root must be a product). None if they do not meet or the points are too near to each other.
pub fn two_circles(points: [[f64; 2]; 2], ranges_m: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let ([[x0, y0], [x1, y1]], [d0, d1]) = (points, ranges_m);
    let a = (x1 - x0).hypot(y1 - y0);
    let along = a * a - d1 * d1 + d0 * d0;
    let square = 4.0 * a * a * d0 * d0 - along * along;
    if !(a >= LEAST_BASE_M && square >= ROUNDING) {
        return None;
    }
    let (x, y) = (along / (2.0 * a), square.max(0.0).sqrt() / (2.0 * a));
    let [ux, uy] = [(x1 - x0) / a, (y1 - y0) / a];
    Some([1.0, -1.0].map(|side| [x0 + x * ux - side * y * uy, y0 + x * uy + side * y * ux]))
}

/// Coefficients a, b, c of the line a x + b y = c through two points (equations 5.11 to 5.13, whose printed signs and order
/// put neither point on the line).
pub fn line_through([x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) -> [f64; 3] {
    let (a, b) = (y2 - y1, x1 - x2);
    [a, b, a * x1 + b * y1]
}

/// Where two lines a x + b y = c meet (equation 5.19); none if they are parallel.
pub fn intersection([a1, b1, c1]: [f64; 3], [a2, b2, c2]: [f64; 3]) -> Option<[f64; 2]> {
    let determinant = a1 * b2 - a2 * b1;
    let meet = [(b2 * c1 - b1 * c2) / determinant, (a1 * c2 - a2 * c1) / determinant];
    (determinant.abs() >= LEAST_SINE * a1.hypot(b1) * a2.hypot(b2)).then_some(meet)
}

/// The parallel to a wall on which the robot is: it came nearer by `known - seen`.
fn parallel(relation: &Relation) -> [f64; 3] {
    let (sin, cos) = relation.known.bearing_rad.sin_cos();
    [cos, sin, relation.known.distance_m - relation.seen.distance_m]
}

/// The estimate by two relations; of two places the one nearer to what the odometry says. A wall and a point give none.
pub fn pair_estimate(a: &Relation, b: &Relation, odometry: [f64; 2]) -> Option<PairEstimate> {
    let position = match (is_point(&a.known), is_point(&b.known)) {
        (true, true) => {
            let points = [a.known.position(), b.known.position()];
            let both = two_circles(points, [a.seen.distance_m, b.seen.distance_m])?;
            let off = |place: &[f64; 2]| (Point2::from(*place) - Point2::from(odometry)).norm();
            both.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)))?
        }
        (false, false) => intersection(parallel(a), parallel(b))?,
        _ => return None,
    };
    // Straight ahead counts as left.
    let is_left = |relation: &Relation| relation.seen.bearing_rad >= 0.0;
    Some(PairEstimate {
        position,
        separation_rad: wrap_angle(a.seen.bearing_rad - b.seen.bearing_rad).abs(),
        farthest_m: a.seen.distance_m.max(b.seen.distance_m),
        on_both_sides: is_left(a) != is_left(b),
    })
}
