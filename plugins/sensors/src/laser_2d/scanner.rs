//! One scan: exact ranges from the world, made into the device's readings.

use rumbo_core::messages::{LaserScan, Observations};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, Probe, SensorError, World, WorldError};

use super::ScanNoise;
use crate::recorded::Seat;

/// Geometry of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanShape {
    /// Bearing of the first beam, radians.
    pub first_bearing_rad: f64,
    /// From one beam to the next, radians.
    pub bearing_step_rad: f64,
    /// How many.
    pub n_beams: usize,
    /// Shorter ranges are no readings, meters.
    pub min_range_m: f64,
    /// Reach, meters.
    pub max_range_m: f64,
}

/// What came of asking the world.
#[derive(Debug)]
pub enum Scanned {
    /// A scan with the device's readings.
    Scan(LaserScan),
    /// The world plays a recording, which was passed on.
    Recorded,
    /// The world is the real one: the sensor has to read its own device.
    Live,
}

impl ScanShape {
    /// Asks the world for exact ranges and lets `read` make readings of those that hit something within reach.
    pub fn scan(
        &self,
        seat: &Seat,
        world: &mut dyn World,
        out: &mut Observations,
        mut read: impl FnMut(f64) -> f64,
    ) -> Result<Scanned, SensorError> {
        let probe = self.probe(seat, self.first_bearing_rad, self.n_beams);
        let answer = match world.probe(&probe) {
            Ok(answer) => answer,
            Err(unanswered @ WorldError::Unsupported { .. }) => {
                return seat.ask_recording(world, unanswered, out).map(|()| Scanned::Recorded);
            }
            Err(error) => return Err(error.into()),
        };
        match answer {
            Answer::Ranges(exact) if exact.len() == self.n_beams => {
                let mut scan = self.empty_scan(out);
                for (reading, &exact_m) in scan.ranges_m.make_mut().iter_mut().zip(exact) {
                    *reading = self.reading(exact_m, &mut read);
                }
                Ok(Scanned::Scan(scan))
            }
            Answer::Recorded(recorded) => {
                seat.pass_on(recorded, out);
                Ok(Scanned::Recorded)
            }
            Answer::Live => Ok(Scanned::Live),
            other => Err(SensorError::WrongAnswer { expected: "beams", found: other.name() }),
        }
    }

    /// As [`scan`](Self::scan), but each beam points a little off: the world is asked beam by beam.
    pub fn bent_scan(
        &self,
        seat: &Seat,
        world: &mut dyn World,
        out: &mut Observations,
        noise: &dyn ScanNoise,
        rng: &mut Rng,
    ) -> Result<Scanned, SensorError> {
        let mut scan = self.empty_scan(out);
        for (idx, reading) in scan.ranges_m.make_mut().iter_mut().enumerate() {
            let nominal_rad = self.first_bearing_rad + self.bearing_step_rad * idx as f64;
            let bearing_rad = nominal_rad + noise.bearing_error_rad(rng);
            match world.probe(&self.probe(seat, bearing_rad, 1)) {
                Ok(Answer::Ranges([exact_m])) => {
                    *reading = self.reading(*exact_m, &mut |exact| noise.read(exact, rng))
                }
                Ok(Answer::Recorded(recorded)) => {
                    seat.pass_on(recorded, out);
                    return Ok(Scanned::Recorded);
                }
                Ok(other) => {
                    return Err(SensorError::WrongAnswer { expected: "beams", found: other.name() });
                }
                Err(unanswered @ WorldError::Unsupported { .. }) => {
                    return seat.ask_recording(world, unanswered, out).map(|()| Scanned::Recorded);
                }
                Err(error) => return Err(error.into()),
            }
        }
        Ok(Scanned::Scan(scan))
    }

    fn probe<'a>(&self, seat: &'a Seat, first_bearing_rad: f64, n_beams: usize) -> Probe<'a> {
        Probe::Beams {
            base_from_sensor: &seat.base_from_sensor,
            first_bearing_rad,
            bearing_step_rad: self.bearing_step_rad,
            n_beams,
            max_range_m: self.max_range_m,
        }
    }

    fn empty_scan(&self, out: &mut Observations) -> LaserScan {
        LaserScan {
            first_bearing_rad: self.first_bearing_rad,
            bearing_step_rad: self.bearing_step_rad,
            // A simulated scan is taken at one instant, so there is no sweep to correct.
            sweep_s: 0.0,
            min_range_m: self.min_range_m as f32,
            max_range_m: self.max_range_m as f32,
            ranges_m: out.buffer(self.n_beams),
            intensities: rumbo_core::boundary::Buffer::empty(),
        }
    }

    /// REP-117: infinite when nothing is within reach, not-a-number when the device has no reading.
    fn reading(&self, exact_m: f32, read: &mut impl FnMut(f64) -> f64) -> f32 {
        if !exact_m.is_finite() {
            return f32::INFINITY;
        }
        let reading_m = read(f64::from(exact_m));
        if reading_m > self.max_range_m {
            f32::INFINITY
        } else if reading_m < self.min_range_m {
            f32::NAN
        } else {
            reading_m as f32
        }
    }
}
