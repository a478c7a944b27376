//! Readings of distance: planar scans, single ranges, touch.

use super::check::{Check, Checker, MessageFault};
use crate::boundary::Buffer;

/// A planar scan, beams counter-clockwise from the first.
///
/// Ranges follow REP-117: a finite number is a hit, `+inf` says that nothing is within reach, not-a-number that there
/// is no reading.
#[doc(alias = "sensor_msgs/LaserScan")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LaserScan {
    /// Bearing of the first beam in the sensor's frame, radians.
    pub first_bearing_rad: f64,
    /// Bearing from one beam to the next, radians.
    pub bearing_step_rad: f64,
    /// Time from the first beam to the last, seconds; the stamp is the first beam's.
    pub sweep_s: f64,
    /// Shorter ranges than this are not readings, meters.
    pub min_range_m: f32,
    /// Reach of the device, meters.
    pub max_range_m: f32,
    /// One range a beam, meters.
    pub ranges_m: Buffer<f32>,
    /// One intensity a beam, or none at all.
    pub intensities: Buffer<f32>,
}

impl LaserScan {
    /// Bearing of beam `idx`, radians.
    pub fn bearing_rad(&self, idx: usize) -> f64 {
        self.first_bearing_rad + self.bearing_step_rad * idx as f64
    }

    /// Bearing (radians) and range (meters) of every beam that hit something within the device's reach.
    pub fn hits(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.ranges_m.iter().enumerate().filter_map(|(idx, &range)| {
            let hit = range >= self.min_range_m && range <= self.max_range_m;
            hit.then(|| (self.bearing_rad(idx), f64::from(range)))
        })
    }
}

impl Check for LaserScan {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("laser_scan");
        c.finite("first_bearing_rad", &[self.first_bearing_rad])?;
        c.finite("bearing_step_rad", &[self.bearing_step_rad])?;
        c.not_negative("sweep_s", self.sweep_s)?;
        c.not_negative("min_range_m", self.min_range_m.into())?;
        c.positive("max_range_m", self.max_range_m.into())?;
        c.ranges("ranges_m", &self.ranges_m)?;
        if !self.intensities.is_empty() {
            c.equal("intensities", self.intensities.len(), self.ranges_m.len())?;
        }
        Ok(())
    }
}

/// Single ranges around the hull, each a cone (sonar, infrared).
#[doc(alias = "sensor_msgs/Range")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RangeRing {
    /// Bearing of the first cone's axis in the sensor's frame, radians.
    pub first_bearing_rad: f64,
    /// Bearing from one axis to the next, radians.
    pub bearing_step_rad: f64,
    /// Full opening of a cone, radians.
    pub cone_rad: f64,
    /// Distance of the transducers from the ring's center, meters; ranges are from the transducer.
    pub ring_radius_m: f64,
    /// Shorter ranges than this are not readings, meters.
    pub min_range_m: f32,
    /// Reach, meters.
    pub max_range_m: f32,
    /// One range a transducer, meters, as in [`LaserScan`].
    pub ranges_m: Buffer<f32>,
}

impl RangeRing {
    /// Bearing (radians) and range (meters, from the transducer) of every echo within the device's reach.
    pub fn echoes(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.ranges_m.iter().enumerate().filter_map(|(idx, &range)| {
            let is_echo = range >= self.min_range_m && range <= self.max_range_m;
            let bearing_rad = || self.first_bearing_rad + self.bearing_step_rad * idx as f64;
            is_echo.then(|| (bearing_rad(), f64::from(range)))
        })
    }
}

impl Check for RangeRing {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("range_ring");
        c.finite("first_bearing_rad", &[self.first_bearing_rad])?;
        c.finite("bearing_step_rad", &[self.bearing_step_rad])?;
        c.positive("cone_rad", self.cone_rad)?;
        c.not_negative("ring_radius_m", self.ring_radius_m)?;
        c.not_negative("min_range_m", self.min_range_m.into())?;
        c.positive("max_range_m", self.max_range_m.into())?;
        c.ranges("ranges_m", &self.ranges_m)
    }
}

/// Touch sensors around the hull, at most 64.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bumpers {
    /// How many there are.
    pub n_bumpers: u32,
    /// Bit `k` is set while bumper `k` touches something.
    pub pressed: u64,
    /// Bearing of bumper 0 in the sensor's frame, radians.
    pub first_bearing_rad: f64,
    /// Bearing from one bumper to the next, radians.
    pub bearing_step_rad: f64,
    /// Distance of the bumpers from the ring's center, meters.
    pub ring_radius_m: f64,
}

impl Bumpers {
    /// Bearings of the bumpers that touch something, radians.
    pub fn touching(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.n_bumpers.min(64))
            .filter(|k| self.pressed >> k & 1 == 1)
            .map(|k| self.first_bearing_rad + self.bearing_step_rad * f64::from(k))
    }
}

impl Check for Bumpers {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("bumpers");
        c.finite("first_bearing_rad", &[self.first_bearing_rad])?;
        c.finite("bearing_step_rad", &[self.bearing_step_rad])?;
        c.not_negative("ring_radius_m", self.ring_radius_m)
    }
}
