//! The stop zone: how far the hull may still go along the commanded motion.
//!
//! The way to a standstill at the present speed, `v²/(2·braking) + v·latency`, and a margin, counted from the hull. Only
//! motion toward what is that near is held back: a robot may always back out or turn away if its hull passes.

use super::cloud_cells::CloudCells;
use crate::frames::{Point2, Point3, Pose2, Pose3, Twist, flatten};
use crate::messages::{Data, Observation, ObservationKind, PointCloud, SensorId};
use crate::robot::{Hull, Robot};

/// What one sensor last saw nearby.
#[derive(Debug)]
struct Near {
    sensor: SensorId,
    /// A depth camera may give a scan and a cloud.
    kind: ObservationKind,
    odom_points: Vec<Point2>,
}

/// Everything near, and the hull that must stay clear of it.
#[derive(Debug)]
pub struct StopZone {
    hull: Hull,
    reach_m: f64,
    /// Heights over the floor at which points of a cloud are in the way, meters.
    heights_m: [f64; 2],
    near: Vec<Near>,
    cells: CloudCells,
    base_points: Vec<Point2>,
}

impl StopZone {
    /// Poses along the motion are tested this densely, meters (or radians times the hull's radius).
    const STEP_M: f64 = 0.02;
    /// A point that comes nearer by less than this does not count as closing, meters.
    const CLOSING_M: f64 = 1e-4;
    /// Points of a cloud that are not higher than this are on the floor, meters.
    const FLOOR_M: f64 = 0.05;
    /// Room for points that is taken up front; more is taken as it is needed, once.
    const ROOM: usize = 1024;

    /// Nothing seen yet.
    pub fn new(robot: &Robot) -> StopZone {
        let hull = robot.hull();
        // A second of the fastest motion beyond the longest stop covers the age of a reading.
        let reach_m = hull.outer_radius_m()
            + robot.stopping_m(robot.max_speed_m_s)
            + robot.guard.margin_m
            + robot.max_speed_m_s
            + Self::STEP_M;
        StopZone {
            hull,
            reach_m,
            heights_m: [Self::FLOOR_M, robot.height_m],
            near: Vec::with_capacity(64),
            cells: CloudCells::default(),
            base_points: Vec::with_capacity(Self::ROOM),
        }
    }

    /// Takes in a reading of a range sensor, depth camera or bumper; `odom_from_base` is where the base was then.
    pub fn see(&mut self, observation: &Observation, odom_from_base: &Pose2) {
        let reach_m = self.reach_m;
        let base_from_sensor = flatten(&observation.base_from_sensor);
        if let Data::PointCloud(cloud) = &observation.data {
            return self.see_cloud(cloud, observation, odom_from_base);
        }
        if !matches!(observation.data, Data::LaserScan(_) | Data::RangeRing(_) | Data::Bumpers(_)) {
            return;
        }
        let odom_points = self.points_of(observation);
        odom_points.clear();
        let mut keep = |in_sensor: Point2| {
            let in_base = base_from_sensor * in_sensor;
            if in_base.coords.norm() <= reach_m {
                odom_points.push(odom_from_base * in_base);
            }
        };
        let polar =
            |bearing: f64, range_m: f64| Point2::new(range_m * bearing.cos(), range_m * bearing.sin());
        let limit_m = reach_m + base_from_sensor.translation.vector.norm();
        match &observation.data {
            Data::LaserScan(scan) => {
                scan.hits()
                    .filter(|(_, range)| *range <= limit_m)
                    .for_each(|(b, range)| keep(polar(b, range)));
            }
            Data::RangeRing(ring) => {
                for (idx, range) in ring.ranges_m.iter().enumerate() {
                    if *range >= ring.min_range_m && *range <= ring.max_range_m {
                        let bearing = ring.first_bearing_rad + ring.bearing_step_rad * idx as f64;
                        keep(polar(bearing, ring.ring_radius_m + f64::from(*range)));
                    }
                }
            }
            Data::Bumpers(bumpers) => {
                bumpers.touching().for_each(|bearing| keep(polar(bearing, bumpers.ring_radius_m)));
            }
            _ => {}
        }
    }

    /// Takes in what of a cloud is near and neither floor nor overhead.
    fn see_cloud(&mut self, cloud: &PointCloud, observation: &Observation, odom_from_base: &Pose2) {
        let (reach_m, [lowest_m, highest_m]) = (self.reach_m, self.heights_m);
        let base_from_sensor: &Pose3 = &observation.base_from_sensor;
        let mut cells = std::mem::take(&mut self.cells);
        cells.start(reach_m);
        let odom_points = self.points_of(observation);
        odom_points.clear();
        for point in cloud.points_m.iter() {
            let in_base = base_from_sensor * Point3::from(point.map(f64::from));
            let is_in_the_way = in_base.z > lowest_m && in_base.z <= highest_m;
            // Nothing of this holds for a point that is no number.
            if is_in_the_way && in_base.coords.xy().norm() <= reach_m && cells.take(in_base.xy()) {
                odom_points.push(odom_from_base * in_base.xy());
            }
        }
        self.cells = cells;
    }

    fn points_of(&mut self, observation: &Observation) -> &mut Vec<Point2> {
        let (sensor, kind) = (observation.sensor, observation.data.kind());
        let is_same = |near: &Near| near.sensor == sensor && near.kind == kind;
        let at = self.near.iter().position(is_same).unwrap_or_else(|| {
            self.near.push(Near { sensor, kind, odom_points: Vec::with_capacity(Self::ROOM) });
            self.near.len() - 1
        });
        &mut self.near[at].odom_points
    }

    /// The twist, scaled down until the robot can stop in front of everything that it sees.
    pub fn limit(&mut self, twist: Twist, robot: &Robot, odom_from_base: &Pose2) -> Twist {
        if twist == Twist::ZERO {
            return twist;
        }
        let base_from_odom = odom_from_base.inverse();
        self.base_points.clear();
        for point in self.near.iter().flat_map(|near| &near.odom_points) {
            self.base_points.push(base_from_odom * point);
        }
        // Speed of the fastest point of the hull: what brakes have to stop.
        let hull_m_s = twist.speed_m_s() + twist.turn_rad_s.abs() * self.swing_m(twist);
        let needed_m = robot.stopping_m(hull_m_s);
        let free_m = self.free_m(twist, hull_m_s, needed_m, robot.guard.margin_m);
        if free_m >= needed_m {
            return twist;
        }
        let factor = robot.stops_within_m_s(free_m) / hull_m_s;
        // Creeping at a fraction of a millimeter per second is standing.
        if factor * hull_m_s < 1e-3 { Twist::ZERO } else { twist.scaled(factor) }
    }

    /// Lever of the turn: a disc that turns in place sweeps nothing.
    fn swing_m(&self, twist: Twist) -> f64 {
        match self.hull {
            Hull::Disc { .. } if twist.speed_m_s() < 1e-9 => 0.0,
            _ => self.hull.outer_radius_m(),
        }
    }

    /// How far the fastest point of the hull can move before the margin around the hull meets a point.
    fn free_m(&self, twist: Twist, hull_m_s: f64, needed_m: f64, margin_m: f64) -> f64 {
        if hull_m_s < 1e-12 {
            return f64::INFINITY;
        }
        let n_steps = (needed_m / Self::STEP_M).ceil().max(1.0) as usize;
        let mut free_m = needed_m;
        for step in 1..=n_steps {
            let travel_m = needed_m * step as f64 / n_steps as f64;
            let then_from_base = twist.integrate(travel_m / hull_m_s).inverse();
            let hits = self.base_points.iter().any(|point| {
                let now_m = self.hull.distance_m(*point);
                let then_m = self.hull.distance_m(then_from_base * point);
                then_m < margin_m && then_m < now_m - Self::CLOSING_M
            });
            if hits {
                free_m = needed_m * (step - 1) as f64 / n_steps as f64;
                return free_m;
            }
        }
        free_m.max(needed_m)
    }
}
