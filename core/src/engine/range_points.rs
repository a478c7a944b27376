//! Where readings of range sensors and bumpers put something: points in the robot's own frame.

use crate::frames::{Point2, Point3};
use crate::messages::{Data, Observation};
use nalgebra::Vector3;

/// A reading of this kind says where something stands.
pub fn has_points(observation: &Observation) -> bool {
    matches!(observation.data, Data::LaserScan(_) | Data::RangeRing(_) | Data::Bumpers(_))
}

/// Every point of the reading that is no farther than `reach_m` from the base, in the base's frame. Points of a tilted
/// sensor are projected to the floor.
pub fn for_each_point(observation: &Observation, reach_m: f64, mut keep: impl FnMut(Point2)) {
    let base_from_sensor = observation.base_from_sensor;
    let mut keep_near = |bearing_rad: f64, range_m: f64| {
        let in_sensor = Point3::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0);
        let in_base = (base_from_sensor * in_sensor).xy();
        if in_base.coords.norm() <= reach_m {
            keep(in_base);
        }
    };
    // Spares the sines of what is too far in any case: on the floor a beam is at least this share of its length.
    let share = (base_from_sensor.rotation * Vector3::z()).z.abs().max(1e-3);
    let limit_m = (reach_m + base_from_sensor.translation.vector.norm()) / share;
    match &observation.data {
        Data::LaserScan(scan) => {
            scan.hits()
                .filter(|(_, range_m)| *range_m <= limit_m)
                .for_each(|(bearing_rad, range_m)| keep_near(bearing_rad, range_m));
        }
        Data::RangeRing(ring) => {
            ring.echoes()
                .for_each(|(bearing_rad, range_m)| keep_near(bearing_rad, ring.ring_radius_m + range_m));
        }
        Data::Bumpers(bumpers) => {
            bumpers.touching().for_each(|bearing_rad| keep_near(bearing_rad, bumpers.ring_radius_m));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Pose3;
    use crate::messages::{LaserScan, SensorId};
    use crate::time::Time;
    use nalgebra::UnitQuaternion;

    #[test]
    fn a_tilted_beam_ends_over_the_floor_where_its_length_on_the_floor_says() {
        let pitch = UnitQuaternion::from_euler_angles(0.0, std::f64::consts::FRAC_PI_3, 0.0);
        let scan = LaserScan { max_range_m: 8.0, ranges_m: vec![2.0f32].into(), ..LaserScan::default() };
        let base_from_sensor = Pose3::from_parts(nalgebra::Translation3::new(0.1, 0.0, 0.5), pitch);
        let data = Data::LaserScan(scan);
        let tilted =
            Observation { sensor: SensorId(0), stamp: Time::ZERO, base_from_sensor, valid: true, data };
        let mut points = Vec::new();
        for_each_point(&tilted, 1.2, |point| points.push(point));
        assert!(points.len() == 1 && (points[0] - Point2::new(1.1, 0.0)).norm() < 1e-12, "{points:?}");
    }
}
