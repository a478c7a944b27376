//! People in front of the robot: followed by the scanner, met with a look ahead in time.
//!
//! Hernández Alamilla (2005) takes everybody for an obstacle that stands, and names this among the limits of his system.

pub mod encounter;
mod params;
pub mod waiting;

pub use params::PeopleParams;

use super::front_watch::Scene;
use crate::explained::is_near_occupied;
use encounter::{Encounter, Manner, Person, Ways};
use rumbo_core::frames::{Point2, Pose2, Pose3, flatten};
use rumbo_core::map::Grid;
use rumbo_core::messages::{Data, LaserScan, Observation, SensorId};
use rumbo_core::time::{Span, Time};
use rumbo_kit::moving_clusters::{Mover, MoverTuning, MovingClusters};
use waiting::Waiting;

/// Numbers of the watch for people, meters and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeopleTuning {
    /// How near they may come, and how far ahead that is looked at.
    pub encounter: Encounter,
    /// After waiting so long a new path is asked for, or less of the future is looked at.
    pub patience_s: f64,
    /// A hit this near to an occupied cell of the map is no person.
    pub expected_within_m: f64,
}

/// Everybody who moves.
#[derive(Debug)]
pub struct People {
    tuning: PeopleTuning,
    /// One for each scanner.
    followed: Vec<(SensorId, MovingClusters)>,
    walkers: Vec<Mover>,
    /// Who walks, or did and has stopped.
    known: Vec<Mover>,
    /// The same in the map.
    persons: Vec<Person>,
    waiting: Waiting,
    /// When somebody was last known.
    last_known: Option<Time>,
}

impl People {
    /// A scanner that is tilted more than this does not see a level plane: cosine of the angle.
    const LEVEL: f64 = 0.98;
    /// Who was known within this time may be behind the robot now.
    const ABOUT: Span = Span(30_000_000_000);

    /// Nobody seen yet.
    pub fn new(tuning: PeopleTuning) -> People {
        let waiting = Waiting::new(tuning.patience_s);
        People {
            tuning,
            followed: Vec::new(),
            walkers: Vec::new(),
            known: Vec::new(),
            persons: Vec::new(),
            waiting,
            last_known: None,
        }
    }

    /// Takes in a scan that was made with the base at `odom_from_base`. `map` shows what does not move.
    pub fn see(
        &mut self,
        observation: &Observation,
        odom_from_base: &Pose2,
        map_from_odom: &Pose2,
        map: Option<&Grid>,
    ) {
        let (Data::LaserScan(scan), true) = (&observation.data, observation.valid) else { return };
        let Some(scan) = as_upright(scan, &observation.base_from_sensor) else { return };
        let within_m = self.tuning.expected_within_m;
        let is_static =
            |point: Point2| map.is_some_and(|grid| is_near_occupied(grid, map_from_odom * point, within_m));
        let odom_from_sensor = odom_from_base * flatten(&observation.base_from_sensor);
        let known = self.followed.iter().position(|(sensor, _)| *sensor == observation.sensor);
        let idx = known.unwrap_or_else(|| {
            let moving = MovingClusters::new(MoverTuning::default());
            self.followed.push((observation.sensor, moving));
            self.followed.len() - 1
        });
        if let Some((_, moving)) = self.followed.get_mut(idx) {
            moving.see(observation.stamp, &scan, &odom_from_sensor, is_static);
        }
        self.look(observation.stamp);
    }

    /// Carries everybody on to `now`.
    pub fn look(&mut self, now: Time) {
        self.known.clear();
        self.known.extend(self.followed.iter().flat_map(|(_, moving)| moving.everybody(now)));
        self.walkers.clear();
        self.walkers.extend(self.known.iter().filter(|mover| mover.is_moving));
        if !self.known.is_empty() {
            self.last_known = Some(now);
        }
    }

    /// Somebody walked here lately.
    pub fn are_about(&self, now: Time) -> bool {
        self.last_known.is_some_and(|last| now - last <= Self::ABOUT)
    }

    /// Who moves, in the odometer's frame.
    pub fn walkers(&self) -> &[Mover] {
        &self.walkers
    }

    /// Who walks, or did and has stopped, in the odometer's frame.
    pub fn known(&self) -> &[Mover] {
        &self.known
    }

    /// What to do about them, with the robot's ways to go on from here.
    pub fn meet(&mut self, scene: &Scene<'_>, ways: &Ways<'_>) -> Manner {
        let map_from_odom = scene.map_from_base * scene.odom_from_base.inverse();
        self.persons.clear();
        self.persons.extend(self.walkers.iter().map(|walker| Person {
            position: map_from_odom * walker.position,
            velocity: map_from_odom.rotation * walker.velocity,
        }));
        let here = Point2::from(scene.map_from_base.translation.vector);
        let horizon_s = self.waiting.horizon_s(self.tuning.encounter.horizon_s, scene.now);
        let encounter = Encounter { horizon_s, ..self.tuning.encounter };
        let manner = encounter.choose(&self.persons, ways, here, self.waiting.is_waiting());
        self.waiting.note(scene.now, manner != Manner::Go && manner != Manner::Slow);
        manner
    }

    /// The robot has waited long enough here for another path; true once for each place.
    pub fn is_tired(&mut self, scene: &Scene<'_>) -> bool {
        self.waiting.asks(scene.now, Point2::from(scene.map_from_base.translation.vector))
    }

    /// The robot does something else than driving ahead.
    pub fn rest(&mut self, now: Time) {
        self.waiting.note(now, false);
    }
}

/// The scan of a level scanner as one that is not upside down sees it; none of a tilted one.
fn as_upright(scan: &LaserScan, base_from_sensor: &Pose3) -> Option<LaserScan> {
    let up = (base_from_sensor.rotation * nalgebra::Vector3::z()).z;
    let side = if up > 0.0 { 1.0 } else { -1.0 };
    (up.abs() >= People::LEVEL).then(|| LaserScan {
        first_bearing_rad: side * scan.first_bearing_rad,
        bearing_step_rad: side * scan.bearing_step_rad,
        ..scan.clone()
    })
}
