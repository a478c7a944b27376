//! Contacts: what bumpers touch is an obstacle at the hull, at the bearing of the bumper.

use rumbo_core::frames::{Point2, Point3, Pose2};
use rumbo_core::messages::{Data, Observation, Obstacle};

/// What is touched this near to a known obstacle is that obstacle, meters: half the width of a bumper of the Super Scout
/// and a cell of the map to both sides.
const SAME_M: f64 = 0.15;

/// Adds what a bumper touches and none of the known obstacles explains.
pub fn add_touched(
    observation: &Observation,
    map_from_base: &Pose2,
    known: &[Obstacle],
    touched: &mut Vec<Obstacle>,
) {
    let (Data::Bumpers(bumpers), true) = (&observation.data, observation.valid) else { return };
    for bearing_rad in bumpers.touching() {
        let (sin, cos) = bearing_rad.sin_cos();
        let in_sensor = Point3::new(bumpers.ring_radius_m * cos, bumpers.ring_radius_m * sin, 0.0);
        let position: Point2 = map_from_base * (observation.base_from_sensor * in_sensor).xy();
        let is_known =
            known.iter().any(|obstacle| (obstacle.position - position).norm() - obstacle.radius_m <= SAME_M);
        if !is_known {
            touched.push(Obstacle { position, radius_m: 0.0, stamp: observation.stamp });
        }
    }
}
