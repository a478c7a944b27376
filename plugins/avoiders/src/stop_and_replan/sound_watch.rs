//! The watch by sound, fused over time: what only sonar hears, such as panes and what lies below the scanner's plane.

use super::cones::{Cone, cones_ahead};
use super::evidence::{EvidenceTuning, Heard, SonarEvidence};
use super::front_watch::Scene;
use crate::explained::{is_near_occupied, is_occupied_in_cone};
use crate::sightings::{Sightings, Source};
use rumbo_core::frames::{Point2, Pose2, wrap_angle};
use rumbo_core::map::Grid;
use rumbo_core::messages::{Data, Observation, Obstacle};
use rumbo_kit::moving_clusters::Mover;

/// Numbers of the watch by sound, radians and meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoundTuning {
    /// Axes within this of straight ahead are heard.
    pub within_rad: f64,
    /// Echoes from farther than this are of no interest.
    pub reach_m: f64,
    /// After so long without an echo the surest place is forgotten, seconds.
    pub decay_s: f64,
    /// An echo not shorter than what map or laser give by more than this is expected.
    pub expected_within_m: f64,
    /// Radius of the hull.
    pub hull_radius_m: f64,
    /// Half the width that the hull sweeps.
    pub half_hull_m: f64,
    /// Sure places in the hull's way are noticed this far ahead; zero for only at the stop distance.
    pub look_ahead_m: f64,
}

/// Evidence, and what follows from it.
#[derive(Debug)]
pub struct SoundWatch {
    tuning: SoundTuning,
    evidence: SonarEvidence,
    /// The nearest echo ahead of the last reading that nothing explains and that is not sure yet.
    doubtful_m: f64,
}

impl SoundWatch {
    /// The estimate may be off sideways by this much, meters: what stands just beside a cone on the map may be in it.
    const BESIDE_CONE_M: f64 = 0.05;
    /// But not by a larger angle than this, radians.
    const MOST_BESIDE_RAD: f64 = 0.2;
    /// What is farther than this from straight ahead is beside the robot, and near without being in its way, radians.
    const AHEAD_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
    /// Room beside the hull that an obstacle ahead must leave free, meters.
    const BESIDE_HULL_M: f64 = 0.05;

    /// Nothing heard yet.
    pub fn new(tuning: SoundTuning) -> SoundWatch {
        let evidence = EvidenceTuning { reach_m: tuning.reach_m, decay_s: tuning.decay_s };
        SoundWatch { tuning, evidence: SonarEvidence::new(evidence), doubtful_m: f64::INFINITY }
    }

    /// Takes in a reading of a sonar ring that was made at `map_from_base`; the sightings are those of that moment.
    pub fn listen(
        &mut self,
        observation: &Observation,
        map_from_base: Pose2,
        sightings: &Sightings,
        scene: &Scene<'_>,
        people: &[Mover],
    ) {
        let (Data::RangeRing(ring), true) = (&observation.data, observation.valid) else { return };
        self.doubtful_m = f64::INFINITY;
        let now = observation.stamp;
        for cone in cones_ahead(ring, observation.base_from_sensor, map_from_base, self.tuning.within_rad) {
            self.evidence.clear(now, &cone);
            let is_news = self.evidence.is_in_reach(&cone)
                && !self.evidence.is_before(now, &cone)
                && !self.is_expected(&cone, sightings, scene)
                && !is_somebody_in(&cone, scene, people);
            let off_rad = wrap_angle(cone.axis_rad - map_from_base.rotation.angle());
            if is_news && !self.evidence.hear(now, &cone) && off_rad.abs() <= Self::AHEAD_RAD {
                self.doubtful_m = self.doubtful_m.min(cone.range_m);
            }
        }
    }

    /// An echo nearer than this is not explained and not sure: the robot should stand and listen again.
    pub fn is_in_doubt(&self, stop_distance_m: f64) -> bool {
        self.doubtful_m < stop_distance_m
    }

    /// Something that only sound knows of is nearer ahead than `stop_distance_m` to the hull, or stands in the hull's way
    /// to a checkpoint that is `left_m` ahead.
    pub fn meets_unexpected(
        &self,
        sightings: &Sightings,
        scene: &Scene<'_>,
        stop_distance_m: f64,
        left_m: f64,
    ) -> bool {
        let (t, base_from_map) = (&self.tuning, scene.map_from_base.inverse());
        let half_way_m = t.half_hull_m + Self::BESIDE_HULL_M;
        self.news(sightings, scene).any(|heard| {
            let in_base = base_from_map * heard.point;
            let is_ahead = in_base.y.atan2(in_base.x).abs() <= t.within_rad.min(Self::AHEAD_RAD);
            let is_near = is_ahead && in_base.coords.norm() - t.hull_radius_m < stop_distance_m;
            let is_in_way = in_base.x > 0.0
                && in_base.y.abs() <= half_way_m
                && in_base.x <= t.look_ahead_m.min(left_m + half_way_m);
            is_near || is_in_way
        })
    }

    /// All that only sound knows of.
    pub fn obstacles(&self, sightings: &Sightings, scene: &Scene<'_>) -> Vec<Obstacle> {
        let as_obstacle =
            |heard: Heard| Obstacle { position: heard.point, radius_m: 0.0, stamp: heard.stamp };
        self.news(sightings, scene).map(as_obstacle).collect()
    }

    /// Sure places that are neither on the map, nor known by now, nor seen by a laser.
    fn news<'a>(
        &'a self,
        sightings: &'a Sightings,
        scene: &Scene<'a>,
    ) -> impl Iterator<Item = Heard> + use<'a> {
        let (grid, within_m) = (scene.grid, self.tuning.expected_within_m);
        let odom_from_map = scene.odom_from_base * scene.map_from_base.inverse();
        self.evidence.sure(scene.now).filter(move |heard| {
            let is_known = grid.is_some_and(|grid| is_near_occupied(grid, heard.point, within_m));
            let in_odom = odom_from_map * heard.point;
            !is_known && !laser_hits(sightings).any(|hit| (hit - in_odom).norm() <= within_m)
        })
    }

    /// The map with all known obstacles, or a laser, has something in the cone that the echo may come from.
    fn is_expected(&self, cone: &Cone, sightings: &Sightings, scene: &Scene<'_>) -> bool {
        let widened_rad =
            (Self::BESIDE_CONE_M / cone.range_m.max(Self::BESIDE_CONE_M)).atan().min(Self::MOST_BESIDE_RAD);
        let reach_m = cone.range_m + self.tuning.expected_within_m;
        let on_map = |grid: &Grid| {
            is_occupied_in_cone(grid, cone.tip, cone.axis_rad, cone.half_rad + widened_rad, reach_m)
        };
        let map_from_odom = scene.map_from_base * scene.odom_from_base.inverse();
        let is_met = |hit: Point2| {
            let to_hit = map_from_odom * hit - cone.tip;
            to_hit.norm() <= reach_m && cone.covers(to_hit.y.atan2(to_hit.x), widened_rad)
        };
        scene.grid.is_some_and(on_map) || laser_hits(sightings).any(is_met)
    }
}

/// Somebody who walks may be what answers, and is elsewhere than in the last scan. Of his echoes no place would ever be
/// forgotten: light goes through where he is no more, as it goes through glass.
fn is_somebody_in(cone: &Cone, scene: &Scene<'_>, people: &[Mover]) -> bool {
    const BODY_M: f64 = 0.45;
    let map_from_odom = scene.map_from_base * scene.odom_from_base.inverse();
    people.iter().any(|walker| {
        let to_walker = map_from_odom * walker.position - cone.tip;
        let around_rad = (BODY_M / to_walker.norm().max(BODY_M)).asin();
        to_walker.norm() <= cone.range_m + BODY_M && cone.covers(to_walker.y.atan2(to_walker.x), around_rad)
    })
}

fn laser_hits(sightings: &Sightings) -> impl Iterator<Item = Point2> + '_ {
    sightings
        .iter()
        .filter(|sighting| sighting.source == Source::Laser)
        .flat_map(|sighting| sighting.odom_points.iter().chain(&sighting.walker_points).copied())
}
