//! What range sensors see nearest to the hull.

use super::range_points::{for_each_point, has_points};
use crate::frames::{Point2, Pose2};
use crate::messages::{Observation, SensorId};
use crate::robot::{Hull, Robot};
use crate::time::Time;

/// The nearest thing that one sensor saw last.
#[derive(Debug)]
struct Nearest {
    sensor: SensorId,
    stamp: Time,
    in_odom: Option<Point2>,
}

/// The nearest thing that each sensor saw last.
#[derive(Debug)]
pub struct Closest {
    hull: Hull,
    nearest: Vec<Nearest>,
}

impl Closest {
    /// A reading that is older than this says nothing of the present, seconds.
    const FRESH_S: f64 = 2.0;
    /// Sensors for which room is taken up front.
    const ROOM: usize = 16;

    /// Nothing seen yet.
    pub fn new(robot: &Robot) -> Closest {
        Closest { hull: robot.hull(), nearest: Vec::with_capacity(Self::ROOM) }
    }

    /// Takes in a reading; `odom_from_base` is where the base was then.
    pub fn see(&mut self, observation: &Observation, odom_from_base: &Pose2) {
        if !observation.valid || !has_points(observation) {
            return;
        }
        let (mut nearest, mut off_m) = (None, f64::INFINITY);
        for_each_point(observation, f64::INFINITY, |in_base| {
            let this_m = self.hull.distance_m(in_base);
            if this_m < off_m {
                (nearest, off_m) = (Some(odom_from_base * in_base), this_m);
            }
        });
        let (sensor, stamp) = (observation.sensor, observation.stamp);
        let seen = Nearest { sensor, stamp, in_odom: nearest };
        match self.nearest.iter_mut().find(|known| known.sensor == sensor) {
            Some(known) => *known = seen,
            None => self.nearest.push(seen),
        }
    }

    /// The nearest thing of all in the odometer's frame, and how far it is from the hull now, meters.
    pub fn now(&self, now: Time, odom_from_base: &Pose2) -> Option<(Point2, f64)> {
        let base_from_odom = odom_from_base.inverse();
        let fresh = self.nearest.iter().filter(|seen| (now - seen.stamp).as_secs() <= Self::FRESH_S);
        let off =
            fresh.filter_map(|seen| seen.in_odom).map(|at| (at, self.hull.distance_m(base_from_odom * at)));
        off.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::Buffer;
    use crate::frames::{lift, pose2};
    use crate::messages::{Bumpers, Data, LaserScan, RangeRing};

    fn seen(sensor: u16, stamp_s: f64, mount: &Pose2, data: Data) -> Observation {
        let (sensor, stamp, base_from_sensor) = (SensorId(sensor), Time::from_secs(stamp_s), lift(mount));
        Observation { sensor, stamp, base_from_sensor, valid: true, data }
    }

    fn scan(ranges_m: &[f32]) -> Data {
        let (bearing_step_rad, max_range_m) = (std::f64::consts::FRAC_PI_2, 8.0);
        let ranges_m = Buffer::from(ranges_m.to_vec());
        Data::LaserScan(LaserScan { bearing_step_rad, max_range_m, ranges_m, ..LaserScan::default() })
    }

    /// A hull of 0.2 m.
    fn closest() -> Closest {
        Closest::new(&Robot { radius_m: 0.2, ..Robot::default() })
    }

    fn assert_at(found: Option<(Point2, f64)>, x: f64, y: f64, off_m: f64) {
        let (at, found_m) = found.unwrap();
        assert!((at - Point2::new(x, y)).norm() < 1e-6 && (found_m - off_m).abs() < 1e-6, "{at} {found_m}");
    }

    #[test]
    fn the_nearest_of_all_sensors_is_told_from_where_the_robot_is_now() {
        let mut closest = closest();
        // Looks to the left, from 0.1 m ahead of the middle: left at 2 m, backwards at 1 m.
        let mount = pose2(0.1, 0.0, std::f64::consts::FRAC_PI_2);
        closest.see(&seen(0, 1.0, &mount, scan(&[2.0, 1.0, f32::INFINITY])), &pose2(5.0, 1.0, 0.0));
        assert_at(closest.now(Time::from_secs(1.0), &pose2(5.0, 1.0, 0.0)), 4.1, 1.0, 0.7);
        assert_at(closest.now(Time::from_secs(1.5), &pose2(5.1, 1.0, 0.0)), 4.1, 1.0, 0.8);
        let ring = RangeRing { cone_rad: 0.4, max_range_m: 4.0, ring_radius_m: 0.2, ..RangeRing::default() };
        let ranges_m = Buffer::from(vec![0.3]);
        let sonar = Data::RangeRing(RangeRing { ranges_m, ..ring });
        closest.see(&seen(1, 1.5, &Pose2::identity(), sonar), &pose2(5.1, 1.0, 0.0));
        assert_at(closest.now(Time::from_secs(1.5), &pose2(5.1, 1.0, 0.0)), 5.6, 1.0, 0.3);
        let bumpers = Bumpers { n_bumpers: 1, pressed: 1, ring_radius_m: 0.21, ..Bumpers::default() };
        closest.see(&seen(2, 1.5, &Pose2::identity(), Data::Bumpers(bumpers)), &pose2(5.1, 1.0, 0.0));
        assert_at(closest.now(Time::from_secs(1.5), &pose2(5.1, 1.0, 0.0)), 5.31, 1.0, 0.01);
    }

    #[test]
    fn what_is_gone_old_or_no_reading_is_not_told() {
        let here = Pose2::identity();
        let mut closest = closest();
        assert_eq!(closest.now(Time::ZERO, &here), None);
        closest.see(&seen(0, 1.0, &here, scan(&[1.0, 3.0])), &here);
        assert_eq!(closest.now(Time::from_secs(3.1), &here), None, "too old");
        let blind = Observation { valid: false, ..seen(0, 2.0, &here, scan(&[0.5])) };
        closest.see(&blind, &here);
        assert_at(closest.now(Time::from_secs(2.0), &here), 1.0, 0.0, 0.8);
        closest.see(&seen(0, 2.5, &here, scan(&[f32::NAN, f32::INFINITY])), &here);
        assert_eq!(closest.now(Time::from_secs(2.5), &here), None, "it left");
    }
}
