//! The pose that explains all related landmarks best, weighed against the odometry: a robust Gauss-Newton estimate. Not in
//! the source, which fuses pairs with weights made by hand; here each landmark weighs what its errors allow.

use super::correspondence::{Relation, predicted};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_kit::landmarks::{Landmark, LandmarkKind};

/// Errors of landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkErrors {
    /// Standard deviation of a range, meters.
    pub range_m: f64,
    /// What is related to was itself seen, with the same errors; else it comes from the map.
    pub known_is_seen: bool,
    /// Standard deviation of walls of the map, meters.
    pub map_m: f64,
    /// The same for their directions, radians.
    pub map_rad: f64,
}

/// A pose with its covariance of x, y, yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution {
    /// The later place seen from the earlier.
    pub a_from_b: Pose2,
    /// In the axes of the earlier place.
    pub covariance: Matrix3<f64>,
}

/// Steps of Gauss and Newton; walls are linear but for the heading, so that few are needed.
const N_STEPS: usize = 5;
/// Beyond this many standard deviations a landmark is something else.
const GATE: f64 = 4.0;
/// Beyond this many standard deviations the influence of a landmark grows no more (Huber 1964).
const HUBER: f64 = 2.0;

/// One landmark at a pose: how far off it is, how that changes with x, y, yaw, and its covariance.
struct Residual {
    off: Vector2<f64>,
    jacobian: Matrix2x3<f64>,
    covariance: Matrix2<f64>,
}

/// The best pose around `odometry` with the covariance given; the odometry itself where no landmark is related.
pub fn solve(relations: &[Relation], odometry: &Solution, errors: &LandmarkErrors) -> Option<Solution> {
    let prior = odometry.covariance.try_inverse()?;
    let is_possible = |relation: &&Relation| {
        let Residual { off, jacobian, covariance } = residual(relation, &odometry.a_from_b, errors);
        let spread = jacobian * odometry.covariance * jacobian.transpose() + covariance;
        spread.try_inverse().is_some_and(|inverse| off.dot(&(inverse * off)) <= GATE * GATE)
    };
    let related: Vec<&Relation> = relations.iter().filter(is_possible).collect();
    let start = vector(&odometry.a_from_b);
    let mut state = start;
    let mut covariance = odometry.covariance;
    for _ in 0..N_STEPS {
        let pose = pose2(state.x, state.y, state.z);
        let mut from_prior = start - state;
        from_prior.z = wrap_angle(from_prior.z);
        let (mut information, mut pull) = (prior, prior * from_prior);
        for relation in &related {
            let Residual { off, jacobian, covariance } = residual(relation, &pose, errors);
            let Some(inverse) = covariance.try_inverse() else { continue };
            let deviations = off.dot(&(inverse * off)).max(0.0).sqrt();
            let weight = if deviations > HUBER { HUBER / deviations } else { 1.0 };
            let weighed = jacobian.transpose() * inverse * weight;
            information += weighed * jacobian;
            pull += weighed * off;
        }
        covariance = information.try_inverse()?;
        let step = covariance * pull;
        state += step;
        if step.norm() < 1e-9 {
            break;
        }
    }
    let symmetric = (covariance + covariance.transpose()) / 2.0;
    Some(Solution { a_from_b: pose2(state.x, state.y, state.z), covariance: symmetric })
}

fn vector(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

/// What was seen less what the pose lets expect.
fn residual(relation: &Relation, a_from_b: &Pose2, errors: &LandmarkErrors) -> Residual {
    let expected = predicted(&relation.known, a_from_b);
    let covariance =
        spread(&relation.seen, errors, true) + spread(&relation.known, errors, errors.known_is_seen);
    let yaw = a_from_b.rotation.angle();
    if relation.known.is_wall() {
        let (sin, cos) = (expected.bearing_rad + yaw).sin_cos();
        let turn = wrap_angle(relation.seen.bearing_rad - expected.bearing_rad);
        let off = Vector2::new(relation.seen.distance_m - expected.distance_m, turn);
        return Residual { off, jacobian: Matrix2x3::new(-cos, -sin, 0.0, 0.0, 0.0, -1.0), covariance };
    }
    let (sin, cos) = yaw.sin_cos();
    let [x, y] = expected.position();
    let off = Vector2::from(relation.seen.position()) - Vector2::new(x, y);
    Residual { off, jacobian: Matrix2x3::new(-cos, -sin, y, sin, -cos, -x), covariance }
}

/// Covariance of a landmark: of a wall's distance and direction, of a point's place.
fn spread(mark: &Landmark, errors: &LandmarkErrors, is_seen: bool) -> Matrix2<f64> {
    let range_m = if is_seen { errors.range_m } else { 0.0 };
    match mark.kind {
        LandmarkKind::Wall { unit_covariance: [dd, da, aa], unevenness_m, length_m } => {
            // What does not fit a straight line (a door frame, the end of another wall) moves it as a whole.
            let excess = (unevenness_m.powi(2) - range_m.powi(2)).max(0.0);
            let uneven = Matrix2::new(excess, 0.0, 0.0, excess / length_m.powi(2));
            let (map_m, map_rad) = if is_seen { (0.0, 0.0) } else { (errors.map_m, errors.map_rad) };
            let map = Matrix2::new(map_m.powi(2), 0.0, 0.0, map_rad.powi(2));
            Matrix2::new(dd, da, da, aa) * range_m.powi(2) + uneven + map
        }
        // A corner may be the reading before or after it, and so may be the edge of a discontinuity.
        LandmarkKind::Corner { spacing_m } | LandmarkKind::Discontinuity { spacing_m, .. } => {
            let place_m = if is_seen { range_m } else { errors.map_m };
            Matrix2::identity() * (place_m.powi(2) + spacing_m.powi(2))
        }
    }
}
