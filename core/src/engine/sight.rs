//! What scanners say of an obstacle: whether light ends at it or goes through.

use crate::frames::{Point2, Pose2};
use crate::messages::{Data, LaserScan, Observation, Observations, Obstacle};

/// A beam that goes this far beyond an obstacle's middle has seen through it, meters.
const BEYOND_M: f64 = 0.15;

/// What a scan says of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Both beams next to its middle read farther.
    Through,
    /// One of them ends at it.
    There,
    /// Something is before it, or no beam goes there.
    Hidden,
}

/// What light does at an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// No beam has gone there yet.
    Unknown,
    /// A beam ended at it: when one goes through, it is gone.
    Stops,
    /// The first beam went through: glass, or too low or too high for the scanner. Light cannot say when it is gone.
    Passes,
}

impl Light {
    /// What was known, or else what is found out now.
    pub fn or(self, found: Light) -> Light {
        if self == Light::Unknown { found } else { self }
    }
}

/// The newest scan of every scanner, and where it was made.
#[derive(Debug, Default)]
pub struct NewestScans {
    scans: Vec<(Observation, Pose2)>,
}

impl NewestScans {
    /// A scan that is older than this says nothing of an obstacle that is found now.
    const FRESH_S: f64 = 2.0;

    /// Keeps this scan instead of the last one of its sensor, which goes back to the pool.
    pub fn keep(&mut self, scan: &Observation, map_from_sensor: &Pose2, pool: &mut Observations) {
        let newest = (scan.clone(), *map_from_sensor);
        match self.scans.iter_mut().find(|(known, _)| known.sensor == scan.sensor) {
            Some(known) => pool.recycle(std::mem::replace(known, newest).0),
            None => self.scans.push(newest),
        }
    }

    /// What the newest scans say of an obstacle that was just found.
    pub fn light_at(&self, obstacle: &Obstacle) -> Light {
        let mut light = Light::Unknown;
        for (observation, map_from_sensor) in &self.scans {
            let Data::LaserScan(scan) = &observation.data else { continue };
            if (obstacle.stamp - observation.stamp).as_secs().abs() > Self::FRESH_S {
                continue;
            }
            let in_sensor = map_from_sensor.inverse() * obstacle.position;
            let sight = sight(scan, in_sensor, obstacle.radius_m);
            if sight == Sight::There || ends_near(scan, in_sensor, obstacle.radius_m) {
                return Light::Stops;
            }
            if sight == Sight::Through {
                light = Light::Passes;
            }
        }
        light
    }
}

/// A beam ends near a disc, on any side: sonars and bumpers know the direction of what they meet to ten degrees only, and
/// what they met may be what light meets beside it.
fn ends_near(scan: &LaserScan, in_sensor: Point2, radius_m: f64) -> bool {
    scan.hits().any(|(bearing_rad, range_m)| {
        let (sin, cos) = bearing_rad.sin_cos();
        (Point2::new(range_m * cos, range_m * sin) - in_sensor).norm() <= radius_m + BEYOND_M
    })
}

/// What one scan says of a disc at a point of the scanner's frame.
pub fn sight(scan: &LaserScan, in_sensor: Point2, radius_m: f64) -> Sight {
    let distance_m = in_sensor.coords.norm();
    let beam = (in_sensor.y.atan2(in_sensor.x) - scan.first_bearing_rad) / scan.bearing_step_rad;
    if !beam.is_finite() || beam < 0.0 {
        return Sight::Hidden;
    }
    let tolerance_m = radius_m + BEYOND_M;
    let beyond_m = [beam.floor(), beam.ceil()].map(|idx| {
        let range = scan.ranges_m.get(idx as usize).copied().unwrap_or(f32::NAN);
        // Nothing within reach says as much as the reach, and not-a-number says nothing.
        let reads_m = if range.is_nan() { f64::NAN } else { f64::from(range.min(scan.max_range_m)) };
        reads_m - distance_m
    });
    if beyond_m.iter().all(|beyond_m| *beyond_m > tolerance_m) {
        Sight::Through
    } else if beyond_m.iter().any(|beyond_m| beyond_m.abs() <= tolerance_m) {
        Sight::There
    } else {
        Sight::Hidden
    }
}
