//! Where readings of range sensors and bumpers put something: points in the robot's own frame.

use crate::frames::{Point2, flatten};
use crate::messages::{Data, Observation};

/// A reading of this kind says where something stands.
pub fn has_points(observation: &Observation) -> bool {
    matches!(observation.data, Data::LaserScan(_) | Data::RangeRing(_) | Data::Bumpers(_))
}

/// Every point of the reading that is no farther than `reach_m` from the base, in the base's frame.
pub fn for_each_point(observation: &Observation, reach_m: f64, mut keep: impl FnMut(Point2)) {
    let base_from_sensor = flatten(&observation.base_from_sensor);
    let mut keep_near = |bearing_rad: f64, range_m: f64| {
        let in_sensor = Point2::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin());
        let in_base = base_from_sensor * in_sensor;
        if in_base.coords.norm() <= reach_m {
            keep(in_base);
        }
    };
    // Spares the sines of what is too far in any case.
    let limit_m = reach_m + base_from_sensor.translation.vector.norm();
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
