//! What is in the way along an arc: how far the hull goes until something is too near.

use crate::explained::is_near_occupied;
use crate::sightings::Sightings;
use rumbo_core::frames::{Point2, Pose2, Twist};
use rumbo_core::map::Grid;
use rumbo_core::messages::Obstacle;
use rumbo_core::robot::Hull;
use rumbo_core::time::Time;

/// Numbers of the look ahead, meters.
#[derive(Debug, Clone, PartialEq)]
pub struct WayTuning {
    /// The robot's outline.
    pub hull: Hull,
    /// Room around the hull that stays free.
    pub clearance_m: f64,
    /// How far is looked along the arc.
    pub reach_m: f64,
    /// What lies beside the way by this much more is told with what is in it, so that one new path goes around all of it.
    pub beside_m: f64,
    /// A hit this near to an occupied cell of the map is no news.
    pub expected_within_m: f64,
}

/// Points near the robot, and the arc among them.
#[derive(Debug)]
pub struct WayAhead {
    tuning: WayTuning,
    outer_m: f64,
    near: Vec<(Point2, Time)>,
}

/// What the arc meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// The hull goes so far; the whole reach where nothing is in the way.
    pub along_m: f64,
    /// From the hull, as it stands, to the nearest point.
    pub beside_m: f64,
}

impl WayAhead {
    /// Places along the arc are this far apart, meters.
    const STEP_M: f64 = 0.04;
    /// A point that comes nearer by less than this is not approached, meters.
    const CLOSING_M: f64 = 1e-3;

    /// Nothing near.
    pub fn new(tuning: WayTuning) -> WayAhead {
        let outer_m = tuning.hull.outer_radius_m();
        WayAhead { tuning, outer_m, near: Vec::with_capacity(1024) }
    }

    /// Takes over what was seen last, in the base frame of now.
    pub fn look(&mut self, sightings: &Sightings, odom_from_base: &Pose2) {
        let base_from_odom = odom_from_base.inverse();
        let most_m = self.outer_m + self.tuning.reach_m + self.tuning.clearance_m + self.tuning.beside_m;
        self.near.clear();
        for sighting in sightings.iter() {
            let in_base = sighting.odom_points.iter().map(|point| base_from_odom * point);
            self.near.extend(
                in_base.filter(|point| point.coords.norm() <= most_m).map(|point| (point, sighting.stamp)),
            );
        }
    }

    /// How far the hull goes on the arc of this velocity.
    pub fn free(&self, twist: Twist) -> Free {
        let beside = self.near.iter().map(|(point, _)| self.tuning.hull.distance_m(*point));
        let beside_m = beside.fold(f64::INFINITY, f64::min);
        let along_m = self.along(twist).find(|(_, then)| self.is_met(then)).map(|(along_m, _)| along_m);
        let reach_m = self.tuning.reach_m;
        Free { along_m: along_m.map_or(reach_m, |along_m| (along_m - Self::STEP_M).max(0.0)), beside_m }
    }

    /// Places of the base along the arc: distance, and the base of now seen from there.
    fn along(&self, twist: Twist) -> impl Iterator<Item = (f64, Pose2)> + use<> {
        let speed_m_s = twist.forward_m_s.abs().max(1e-9);
        let n_steps = (self.tuning.reach_m / Self::STEP_M).ceil().clamp(1.0, 1000.0) as usize;
        (1..=n_steps).map(move |step| {
            let along_m = Self::STEP_M * step as f64;
            (along_m, twist.integrate(along_m / speed_m_s).inverse())
        })
    }

    fn is_met(&self, then_from_base: &Pose2) -> bool {
        let clearance_m = self.tuning.clearance_m;
        self.near.iter().any(|(point, _)| self.meets(then_from_base, *point, clearance_m))
    }

    /// A point comes nearer to the hull than this.
    fn meets(&self, then_from_base: &Pose2, point: Point2, within_m: f64) -> bool {
        let then = then_from_base * point;
        // Far from the disc around the hull is far from the hull.
        then.coords.norm() < self.outer_m + within_m && {
            let (then_m, now_m) = (self.tuning.hull.distance_m(then), self.tuning.hull.distance_m(point));
            then_m < within_m && then_m < now_m - Self::CLOSING_M
        }
    }

    /// What lies in or just beside the way and is not on the map.
    pub fn unexpected(&self, twist: Twist, map_from_base: &Pose2, grid: Option<&Grid>) -> Vec<Obstacle> {
        let within_m = self.tuning.clearance_m + self.tuning.beside_m;
        let places: Vec<Pose2> = self.along(twist).map(|(_, then)| then).collect();
        let is_in_the_way = |point: Point2| places.iter().any(|then| self.meets(then, point, within_m));
        let found = self.near.iter().filter(|(point, _)| is_in_the_way(*point));
        let on_map = found.map(|(point, stamp)| (map_from_base * point, *stamp));
        let is_known = |point: Point2| {
            grid.is_some_and(|grid| is_near_occupied(grid, point, self.tuning.expected_within_m))
        };
        on_map
            .filter(|(point, _)| !is_known(*point))
            .map(|(position, stamp)| Obstacle { position, radius_m: 0.0, stamp })
            .collect()
    }
}
