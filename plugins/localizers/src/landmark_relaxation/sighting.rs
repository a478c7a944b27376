//! One scan with what was known when it was made.

use nalgebra::Vector3;
use rumbo_core::frames::{Pose2, Pose3, flatten};
use rumbo_core::messages::LaserScan;
use rumbo_core::time::Time;
use rumbo_kit::landmarks::BeamFan;
use std::f64::consts::TAU;

/// A scan, and where the odometer said the base was.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// When.
    pub stamp: Time,
    /// The base, by the odometer.
    pub odom_from_base: Pose2,
    /// The scanner.
    pub base_from_sensor: Pose2,
    /// Its beams.
    pub fan: BeamFan,
    /// Range of each, meters.
    pub ranges_m: Vec<f64>,
}

/// A scanner that leans more than this does not see walls where the map has them: cosine of 14 degrees.
const LEAST_UPRIGHT: f64 = 0.97;

impl Sighting {
    /// A scan of a scanner that looks along the floor; none of one that leans, or whose beams are nowhere. Readings
    /// farther than `reach_m` are not used: the model does not reach farther.
    pub fn of(
        scan: &LaserScan,
        stamp: Time,
        base_from_sensor: &Pose3,
        odom_from_base: Pose2,
        reach_m: f64,
    ) -> Option<Sighting> {
        let up = (base_from_sensor.rotation * Vector3::z()).z;
        let is_finite = scan.first_bearing_rad.is_finite() && scan.bearing_step_rad.is_finite();
        if up.abs() < LEAST_UPRIGHT || !is_finite {
            return None;
        }
        // Upside down it sweeps the other way.
        let side = up.signum();
        let fan = BeamFan {
            first_bearing_rad: side * scan.first_bearing_rad,
            bearing_step_rad: side * scan.bearing_step_rad,
            min_range_m: scan.min_range_m.into(),
            max_range_m: f64::from(scan.max_range_m).min(reach_m),
        };
        // A range that is no number at all has no bearing worth knowing either, and one full turn is enough.
        let most = (TAU / fan.bearing_step_rad.abs().max(1e-4)).ceil() as usize + 1;
        let ranges_m = scan.ranges_m.iter().take(most).map(|range| f64::from(*range)).collect();
        Some(Sighting { stamp, odom_from_base, base_from_sensor: flatten(base_from_sensor), fan, ranges_m })
    }

    /// Bearing of each beam in the scanner's frame (radians), and what it says.
    pub fn beams(&self) -> impl Iterator<Item = (f64, Beam)> + '_ {
        let fan = self.fan;
        self.ranges_m.iter().enumerate().map(move |(idx, range_m)| {
            let bearing_rad = fan.first_bearing_rad + fan.bearing_step_rad * idx as f64;
            (bearing_rad, Beam::of(*range_m, &fan))
        })
    }

    /// How much of a turn it covers, radians.
    pub fn view_rad(&self) -> f64 {
        (self.fan.bearing_step_rad.abs() * self.ranges_m.len() as f64).min(TAU)
    }
}

/// What a beam says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beam {
    /// Something is there, meters.
    Hit(f64),
    /// Nothing within reach.
    Free,
    /// No reading.
    Silent,
}

impl Beam {
    fn of(range_m: f64, fan: &BeamFan) -> Beam {
        if range_m >= fan.max_range_m {
            Beam::Free
        } else if range_m >= fan.min_range_m.max(f64::MIN_POSITIVE) {
            Beam::Hit(range_m)
        } else {
            Beam::Silent
        }
    }
}
