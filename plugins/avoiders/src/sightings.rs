//! The last reading of every range sensor, as points that stay where they were while the robot moves on.
//!
//! Points are kept in the odometer's frame: between two readings the robot's own motion moves them, and a correction of
//! the estimate does not.

use rumbo_core::frames::{Point2, Point3, Pose2, Pose3};
use rumbo_core::messages::{Data, LaserScan, Observation, Obstacle, RangeRing, SensorId};
use rumbo_core::time::Time;
use rumbo_kit::moving_clusters::Mover;

/// Which kind of sensor a reading comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// Thin beams; ranges are from the sensor's center.
    Laser,
    /// Cones; ranges are from a transducer on a ring around the sensor's center.
    Sonar {
        /// Distance of the transducers from the center, meters.
        ring_radius_m: f64,
        /// Half of a cone's opening, radians.
        half_cone_rad: f64,
        /// Bearing from one axis to the next, radians.
        axis_step_rad: f64,
    },
}

/// The last reading of one sensor.
#[derive(Debug)]
pub struct Sighting {
    sensor: SensorId,
    /// When it was seen.
    pub stamp: Time,
    /// What kind of sensor saw it.
    pub source: Source,
    /// Center of the sensor in the base frame.
    pub base_from_center: Point2,
    /// Hits, or echoes on their cones' axes, in the odometer's frame.
    pub odom_points: Vec<Point2>,
    /// Hits of who walks, who is met otherwise.
    pub walker_points: Vec<Point2>,
}

/// The last reading of every range sensor.
#[derive(Debug)]
pub struct Sightings {
    keep_m: f64,
    sightings: Vec<Sighting>,
}

impl Sightings {
    /// What is this near to the middle of who walks is a part of him, meters: half a stride.
    const WALKER_M: f64 = 0.45;

    /// Nothing seen yet; hits farther than `keep_m` from their sensor are of no interest.
    pub fn new(keep_m: f64) -> Sightings {
        Sightings { keep_m, sightings: Vec::with_capacity(8) }
    }

    /// The last readings.
    pub fn iter(&self) -> std::slice::Iter<'_, Sighting> {
        self.sightings.iter()
    }

    /// Hits of who walks, as obstacles of the map.
    pub fn walkers(&self, map_from_odom: &Pose2) -> impl Iterator<Item = Obstacle> {
        self.sightings.iter().flat_map(move |sighting| {
            let stamp = sighting.stamp;
            let as_obstacle =
                move |hit: &Point2| Obstacle { position: map_from_odom * hit, radius_m: 0.0, stamp };
            sighting.walker_points.iter().map(as_obstacle)
        })
    }

    /// Takes in a range reading, unless it is invalid or not newer than the last; `odom_from_base` is where the base was
    /// when it was seen. Laser hits at who walks, in the odometer's frame, are kept apart.
    pub fn see(&mut self, observation: &Observation, odom_from_base: &Pose2, walkers: &[Mover]) {
        let mount = observation.base_from_sensor;
        let (source, n_readings) = match &observation.data {
            Data::LaserScan(scan) => (Source::Laser, scan.ranges_m.len()),
            Data::RangeRing(ring) => (sonar(ring), ring.ranges_m.len()),
            _ => return,
        };
        let keep_m = self.keep_m;
        let Some(sighting) = self.renew(observation, source) else { return };
        sighting.base_from_center = in_plane(&mount, 0.0, 0.0);
        // One growth at the first reading, none later.
        sighting.odom_points.reserve(n_readings);
        let mut keep = |bearing_rad: f64, range_m: f64, from_center_m: f64| {
            if range_m <= keep_m {
                let in_base = in_plane(&mount, bearing_rad, from_center_m);
                let point = odom_from_base * in_base;
                let is_walker = sighting.source == Source::Laser
                    && walkers.iter().any(|walker| (walker.position - point).norm() <= Self::WALKER_M);
                if is_walker { &mut sighting.walker_points } else { &mut sighting.odom_points }.push(point);
            }
        };
        match &observation.data {
            Data::LaserScan(scan) => hits(scan, &mut keep),
            Data::RangeRing(ring) => echoes(ring, &mut keep),
            _ => {}
        }
    }

    /// The sensor's sighting, emptied; none where the reading is no use.
    fn renew(&mut self, observation: &Observation, source: Source) -> Option<&mut Sighting> {
        if !observation.valid {
            return None;
        }
        let at = self.sightings.iter().position(|s| s.sensor == observation.sensor);
        let at = at.unwrap_or_else(|| {
            self.sightings.push(Sighting {
                sensor: observation.sensor,
                stamp: Time(i64::MIN),
                source,
                base_from_center: Point2::origin(),
                odom_points: Vec::new(),
                walker_points: Vec::new(),
            });
            self.sightings.len() - 1
        });
        let sighting = self.sightings.get_mut(at).filter(|s| s.stamp < observation.stamp)?;
        sighting.stamp = observation.stamp;
        sighting.source = source;
        sighting.odom_points.clear();
        sighting.walker_points.clear();
        Some(sighting)
    }
}

fn sonar(ring: &RangeRing) -> Source {
    Source::Sonar {
        ring_radius_m: ring.ring_radius_m,
        half_cone_rad: ring.cone_rad / 2.0,
        axis_step_rad: ring.bearing_step_rad.abs(),
    }
}

fn hits(scan: &LaserScan, keep: &mut impl FnMut(f64, f64, f64)) {
    scan.hits().for_each(|(bearing_rad, range_m)| keep(bearing_rad, range_m, range_m));
}

fn echoes(ring: &RangeRing, keep: &mut impl FnMut(f64, f64, f64)) {
    ring.echoes().for_each(|(bearing_rad, range_m)| keep(bearing_rad, range_m, ring.ring_radius_m + range_m));
}

/// A point of the sensor's plane on the floor, also for a sensor that is mounted upside down.
fn in_plane(base_from_sensor: &Pose3, bearing_rad: f64, distance_m: f64) -> Point2 {
    let (sin, cos) = bearing_rad.sin_cos();
    (base_from_sensor * Point3::new(distance_m * cos, distance_m * sin, 0.0)).xy()
}
