//! The watch in front of the driving robot, and what it says is in the way (Hernández Alamilla 2005, section 6.2).

use crate::explained::{is_near_occupied, is_occupied_in_cone};
use crate::sightings::{Sighting, Sightings, Source};
use rumbo_core::frames::{Point2, Pose2, wrap_angle};
use rumbo_core::map::Grid;
use rumbo_core::messages::Obstacle;
use rumbo_core::time::Time;

/// Numbers of the watch, radians and meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchTuning {
    /// The source's M: nearer readings stop the robot.
    pub stop_distance_m: f64,
    /// The source's V: width of the strip ahead in which laser hits count.
    pub watched_width_m: f64,
    /// Axes of the front sonars are within this of straight ahead.
    pub front_sonar_within_rad: f64,
    /// A single echo stops the robot; else echoes are fused over time elsewhere.
    pub heeds_single_echoes: bool,
    /// Readings that the map explains stop the robot only below the hard limits.
    pub ignores_expected: bool,
    /// A hit this near to an occupied cell, or an echo not shorter than the map's by more, is expected.
    pub expected_within_m: f64,
    /// Hard limit of laser hits.
    pub hard_limit_laser_m: f64,
    /// Hard limit of sonar echoes.
    pub hard_limit_sonar_m: f64,
    /// Half the width that the hull sweeps.
    pub half_hull_m: f64,
    /// Unexpected hits up to this far in the hull's way stop the robot early; zero for never.
    pub look_ahead_m: f64,
    /// Unexpected hits up to this far are reported.
    pub insertion_range_m: f64,
    /// Width of the strip ahead in which unexpected hits are reported.
    pub insertion_width_m: f64,
}

/// Where the robot is, and what is known of its surroundings.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The time it is.
    pub now: Time,
    /// The robot in the odometer's frame.
    pub odom_from_base: Pose2,
    /// The robot in the map.
    pub map_from_base: Pose2,
    /// The map with all known obstacles.
    pub grid: Option<&'a Grid>,
}

/// A reading ahead of the robot.
#[derive(Debug, Clone, Copy)]
struct Ahead<'a> {
    sighting: &'a Sighting,
    /// The hit, or the echo on its cone's axis, in the base frame.
    in_base: Point2,
    /// From the laser's center or the sonar's transducer.
    reading_m: f64,
}

impl WatchTuning {
    /// So many unexpected hits make an obstacle beyond the stop distance: one may be noise.
    const HITS_OF_AN_OBSTACLE: usize = 2;
    /// Room beside the hull that an obstacle ahead must leave free.
    const BESIDE_HULL_M: f64 = 0.05;

    /// The smallest reading in the watched region; infinite where there is none.
    pub fn nearest_ahead_m(&self, sightings: &Sightings, scene: &Scene<'_>) -> f64 {
        let readings = self.watched(sightings, scene).map(|ahead| ahead.reading_m);
        readings.fold(f64::INFINITY, f64::min)
    }

    /// Something that nobody expects is in the watched region, nearer than it may be.
    pub fn meets_unexpected(&self, sightings: &Sightings, scene: &Scene<'_>, stop_distance_m: f64) -> bool {
        self.watched(sightings, scene).any(|ahead| {
            (self.heeds_single_echoes || ahead.sighting.source == Source::Laser)
                && ahead.reading_m < stop_distance_m
                && !self.is_expected(&ahead, scene)
        })
    }

    /// Something in the hull's way is nearer than even what the map explains may be. What stands beside the way does not
    /// count: it is the guard's to keep the robot from touching.
    pub fn is_too_near(&self, sightings: &Sightings, scene: &Scene<'_>) -> bool {
        self.ignores_expected
            && self.watched(sightings, scene).any(|ahead| {
                let hard_limit_m = match ahead.sighting.source {
                    Source::Laser => self.hard_limit_laser_m,
                    Source::Sonar { .. } => self.hard_limit_sonar_m,
                };
                ahead.in_base.y.abs() <= self.half_hull_m && ahead.reading_m < hard_limit_m
            })
    }

    /// An obstacle that nobody expects stands in the hull's way to a checkpoint that is `left_m` ahead.
    pub fn is_way_closed(&self, sightings: &Sightings, scene: &Scene<'_>, left_m: f64) -> bool {
        let half_way_m = self.half_hull_m + Self::BESIDE_HULL_M;
        let hits = lasers_ahead(sightings, scene).filter(|ahead| {
            ahead.reading_m <= self.look_ahead_m
                && ahead.in_base.x <= left_m + half_way_m
                && ahead.in_base.y.abs() <= half_way_m
                && !self.is_expected(ahead, scene)
        });
        self.look_ahead_m > 0.0 && hits.take(Self::HITS_OF_AN_OBSTACLE).count() == Self::HITS_OF_AN_OBSTACLE
    }

    /// What is in the way and not on the map: laser hits as points; the arcs of sonar echoes where only these say so.
    pub fn unexpected(
        &self,
        sightings: &Sightings,
        scene: &Scene<'_>,
        stop_distance_m: f64,
    ) -> Vec<Obstacle> {
        let half_width_m = self.insertion_width_m / 2.0;
        let mut found: Vec<Obstacle> = lasers_ahead(sightings, scene)
            .filter(|ahead| {
                ahead.reading_m <= self.insertion_range_m && ahead.in_base.y.abs() <= half_width_m
            })
            .filter(|ahead| !self.is_expected(ahead, scene))
            .map(|ahead| point_obstacle(scene.map_from_base * ahead.in_base, ahead.sighting))
            .collect();
        let lasers_say_so = lasers_ahead(sightings, scene).any(|ahead| {
            ahead.in_base.y.abs() <= self.watched_width_m / 2.0
                && ahead.reading_m < stop_distance_m.max(self.look_ahead_m)
                && !self.is_expected(&ahead, scene)
        });
        if self.heeds_single_echoes && !lasers_say_so {
            for ahead in self.sonars_ahead(sightings, scene) {
                if ahead.reading_m < stop_distance_m && !self.is_expected(&ahead, scene) {
                    found.extend(arc(&ahead, scene));
                }
            }
        }
        one_a_cell(&mut found, scene.grid);
        found
    }

    fn watched<'a>(
        &'a self,
        sightings: &'a Sightings,
        scene: &Scene<'_>,
    ) -> impl Iterator<Item = Ahead<'a>> + use<'a> {
        let half_width_m = self.watched_width_m / 2.0;
        let lasers =
            lasers_ahead(sightings, scene).filter(move |ahead| ahead.in_base.y.abs() <= half_width_m + 1e-12);
        lasers.chain(self.sonars_ahead(sightings, scene))
    }

    /// Echoes that the front sonars have, or would have by now.
    fn sonars_ahead<'a>(
        &self,
        sightings: &'a Sightings,
        scene: &Scene<'_>,
    ) -> impl Iterator<Item = Ahead<'a>> + use<'a> {
        let (base_from_odom, within_rad) = (scene.odom_from_base.inverse(), self.front_sonar_within_rad);
        sightings.iter().flat_map(move |sighting| {
            let (ring_radius_m, widest_rad) = match sighting.source {
                Source::Laser => (0.0, -1.0),
                // An echo that moved with the robot belongs to the front while no other axis is nearer to it.
                Source::Sonar { ring_radius_m, axis_step_rad, .. } => {
                    (ring_radius_m, within_rad + axis_step_rad / 2.0)
                }
            };
            sighting.odom_points.iter().filter_map(move |point| {
                let in_base = base_from_odom * point;
                let from_center = in_base - sighting.base_from_center;
                let bearing_rad = from_center.y.atan2(from_center.x);
                let reading_m = (from_center.norm() - ring_radius_m).max(0.0);
                (bearing_rad.abs() < widest_rad).then_some(Ahead { sighting, in_base, reading_m })
            })
        })
    }

    fn is_expected(&self, ahead: &Ahead<'_>, scene: &Scene<'_>) -> bool {
        let (Some(grid), true) = (scene.grid, self.ignores_expected) else { return false };
        match ahead.sighting.source {
            Source::Laser => {
                is_near_occupied(grid, scene.map_from_base * ahead.in_base, self.expected_within_m)
            }
            Source::Sonar { half_cone_rad, .. } => {
                let (tip, axis_rad) = cone_of(ahead, scene);
                let reach_m = ahead.reading_m + self.expected_within_m;
                is_occupied_in_cone(grid, tip, axis_rad, half_cone_rad, reach_m)
            }
        }
    }
}

/// Laser hits ahead of their sensor.
fn lasers_ahead<'a>(
    sightings: &'a Sightings,
    scene: &Scene<'_>,
) -> impl Iterator<Item = Ahead<'a>> + use<'a> {
    let base_from_odom = scene.odom_from_base.inverse();
    sightings.iter().filter(|sighting| sighting.source == Source::Laser).flat_map(move |sighting| {
        sighting.odom_points.iter().filter_map(move |point| {
            let in_base = base_from_odom * point;
            let from_center = in_base - sighting.base_from_center;
            (from_center.x > 0.0).then(|| Ahead { sighting, in_base, reading_m: from_center.norm() })
        })
    })
}

/// Transducer and axis of an echo in the map.
fn cone_of(ahead: &Ahead<'_>, scene: &Scene<'_>) -> (Point2, f64) {
    let from_center = ahead.in_base - ahead.sighting.base_from_center;
    let tip = ahead.in_base - from_center.normalize() * ahead.reading_m;
    let axis_rad = from_center.y.atan2(from_center.x) + scene.map_from_base.rotation.angle();
    (scene.map_from_base * tip, wrap_angle(axis_rad))
}

/// Points at the echo's distance from the transducer, over the whole cone: it may come from any of them.
fn arc<'a>(ahead: &Ahead<'a>, scene: &Scene<'_>) -> impl Iterator<Item = Obstacle> + use<'a> {
    let half_cone_rad = match ahead.sighting.source {
        Source::Sonar { half_cone_rad, .. } => half_cone_rad,
        Source::Laser => 0.0,
    };
    let (tip, axis_rad) = cone_of(ahead, scene);
    let (sighting, reading_m) = (ahead.sighting, ahead.reading_m);
    // Close enough that no cell between two points is left out.
    let spacing_m = scene.grid.map_or(0.05, Grid::resolution_m) / 2.0;
    let n_steps = (half_cone_rad * reading_m / spacing_m).ceil().clamp(1.0, 1000.0) as i32;
    (-n_steps..=n_steps).map(move |step| {
        let angle_rad = axis_rad + half_cone_rad * f64::from(step) / f64::from(n_steps);
        point_obstacle(tip + nalgebra::Vector2::new(angle_rad.cos(), angle_rad.sin()) * reading_m, sighting)
    })
}

fn point_obstacle(position: Point2, sighting: &Sighting) -> Obstacle {
    Obstacle { position, radius_m: 0.0, stamp: sighting.stamp }
}

/// Leaves one obstacle in each cell of the grid.
fn one_a_cell(found: &mut Vec<Obstacle>, grid: Option<&Grid>) {
    let Some(grid) = grid else { return };
    found.sort_by_key(|obstacle| grid.cell_at(obstacle.position));
    found.dedup_by(|a, b| {
        let cell = grid.cell_at(a.position);
        cell.is_some() && cell == grid.cell_at(b.position)
    });
}
