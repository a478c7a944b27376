//! A scan as the base sees it: one origin, some directions, a range along each.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::LaserScan;

/// The beams of one scan that are looked at, projected to the floor.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanBeams {
    /// The sensor in the base's frame, meters.
    pub origin: [f64; 2],
    /// Unit vectors in the base's frame.
    pub directions: Vec<[f64; 2]>,
    /// One range a beam, meters; infinite where nothing is within reach.
    pub ranges_m: Vec<f64>,
    /// Reach of the device, meters.
    pub max_range_m: f64,
}

/// A beam that rises or falls more steeply than this says nothing about walls: least horizontal part of its way.
const LEAST_HORIZONTAL: f64 = 0.5;

impl ScanBeams {
    /// At most `max_beams` of a scan's beams at equal distances. Beams without a reading and those below the device's
    /// least range are left out.
    pub fn of(scan: &LaserScan, base_from_sensor: &Pose3, max_beams: usize) -> ScanBeams {
        let origin = base_from_sensor.translation.vector;
        let mut beams = ScanBeams {
            origin: [origin.x, origin.y],
            directions: Vec::with_capacity(max_beams),
            ranges_m: Vec::with_capacity(max_beams),
            max_range_m: scan.max_range_m.into(),
        };
        let n_all = scan.ranges_m.len();
        let n = n_all.min(max_beams);
        for k in 0..n {
            let idx = k * n_all / n;
            let Some(range) = scan.ranges_m.get(idx).filter(|range| **range >= scan.min_range_m) else {
                continue;
            };
            let (sin, cos) = scan.bearing_rad(idx).sin_cos();
            let along = base_from_sensor.rotation * nalgebra::Vector3::new(cos, sin, 0.0);
            let horizontal = along.x.hypot(along.y);
            if horizontal < LEAST_HORIZONTAL {
                continue;
            }
            let is_hit = *range < scan.max_range_m;
            beams.directions.push([along.x / horizontal, along.y / horizontal]);
            beams.ranges_m.push(if is_hit { f64::from(*range) * horizontal } else { f64::INFINITY });
        }
        beams
    }

    /// Directions and ranges of the beams that hit something nearer than `reach_m` and the device's own reach.
    pub fn hits(&self, reach_m: f64) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        let beams = self.directions.iter().copied().zip(self.ranges_m.iter().copied());
        beams.filter(move |(_, range)| *range < reach_m)
    }

    /// End points of those beams in the base's frame, meters.
    pub fn end_points(&self, reach_m: f64) -> impl Iterator<Item = [f64; 2]> + '_ {
        let [x, y] = self.origin;
        self.hits(reach_m).map(move |([dx, dy], range)| [x + range * dx, y + range * dy])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};
    use std::f64::consts::{FRAC_PI_2, PI};

    fn scan(ranges: Vec<f32>) -> LaserScan {
        LaserScan {
            first_bearing_rad: -FRAC_PI_2,
            bearing_step_rad: FRAC_PI_2,
            min_range_m: 0.1,
            max_range_m: 10.0,
            ranges_m: ranges.into(),
            ..LaserScan::default()
        }
    }

    fn mount(roll: f64, yaw: f64) -> Pose3 {
        Pose3::from_parts(Translation3::new(0.5, 0.2, 0.3), UnitQuaternion::from_euler_angles(roll, 0.0, yaw))
    }

    fn rounded(beams: &ScanBeams) -> Vec<[f64; 2]> {
        beams.end_points(30.0).map(|p| p.map(|v| (v * 1e4).round() / 1e4)).collect()
    }

    #[test]
    fn end_points_follow_the_mount_also_when_it_is_turned_or_upside_down() {
        let scan = scan(vec![1.0, 2.0, 3.0]);
        let upright = ScanBeams::of(&scan, &mount(0.0, FRAC_PI_2), 60);
        assert_eq!(rounded(&upright), [[1.5, 0.2], [0.5, 2.2], [-2.5, 0.2]]);
        let hanging = ScanBeams::of(&scan, &mount(PI, 0.0), 60);
        assert_eq!(rounded(&hanging), [[0.5, 1.2], [2.5, 0.2], [0.5, -2.8]]);
    }

    #[test]
    fn beams_without_a_reading_are_left_out_and_those_that_hit_nothing_kept() {
        let scan = scan(vec![f32::NAN, 0.05, f32::INFINITY, 10.0, 11.0, 9.9]);
        let beams = ScanBeams::of(&scan, &Pose3::identity(), 60);
        assert_eq!(beams.ranges_m[..3], [f64::INFINITY; 3]);
        assert_eq!((beams.ranges_m.len(), beams.end_points(30.0).count()), (4, 1));
        assert_eq!(beams.end_points(9.0).count(), 0);
    }

    #[test]
    fn a_steep_sensor_sees_no_walls_and_a_leaning_one_shorter_ways() {
        let leaning = mount(PI / 3.0 - 0.01, 0.0);
        let sides = ScanBeams::of(&scan(vec![1.0, 2.0, 1.0]), &leaning, 60);
        assert!((sides.ranges_m[0] - 0.5).abs() < 0.01 && sides.ranges_m[1] == 2.0);
        let steep = ScanBeams::of(&scan(vec![1.0, 2.0, 1.0]), &mount(1.5, 0.0), 60);
        assert_eq!(steep.ranges_m, [2.0]);
    }

    #[test]
    fn of_many_beams_equally_distant_ones_are_taken() {
        let ranges: Vec<f32> = (0..181).map(|k| 1.0 + k as f32 * 0.01).collect();
        let beams = ScanBeams::of(&scan(ranges), &Pose3::identity(), 60);
        assert_eq!(beams.ranges_m.len(), 60);
        let last = beams.ranges_m[59];
        assert!((last - 2.77).abs() < 1e-6, "{last}");
        assert!(ScanBeams::of(&scan(vec![]), &Pose3::identity(), 60).ranges_m.is_empty());
    }
}
