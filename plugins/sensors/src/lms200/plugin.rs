//! The LMS 200 as a sensor of the framework.

use rumbo_core::messages::{Data, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{BuildContext, BuildError, Cx, Sensor, SensorError, World};

use super::device::read;
use super::{Lms200Mode, Lms200Params, Lms200Unit};
use crate::laser_2d::scanner::Scanned;
use crate::recorded::Seat;

rumbo_core::register_sensor!(Lms200Params, "lms200", "the SICK LMS 200 laser scanner with its variants");

/// The scanner.
#[derive(Debug)]
pub struct Lms200 {
    seat: Seat,
    mode: Lms200Mode,
    unit: Lms200Unit,
    is_exact: bool,
    partial: usize,
    rng: Rng,
}

impl Plugin<dyn Sensor> for Lms200Params {
    fn manifest(&self) -> Manifest {
        let max_rate_hz = self.mode().map(Lms200Mode::rate_hz);
        Manifest {
            produces: vec![ObservationKind::LaserScan],
            default_rate_hz: Some(10.0),
            max_rate_hz,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let Some(mode) = self.mode() else {
            return Err(BuildError::at("resolution_deg", "the device has no such variant"));
        };
        if let Some(rate_hz) = context.rate_hz.filter(|rate_hz| *rate_hz > mode.rate_hz()) {
            let message =
                format!("is {rate_hz}, but this variant gives at most {} scans a second", mode.rate_hz());
            return Err(
                BuildError::at("rate_hz", message).help("lower rate_hz or choose a coarser resolution_deg")
            );
        }
        let (seat, rng) = (Seat::of(context), context.rng());
        Ok(Box::new(Lms200 { seat, mode, unit: self.unit, is_exact: self.exact, partial: 0, rng }))
    }
}

impl Sensor for Lms200 {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let (unit, is_exact, rng) = (self.unit, self.is_exact, &mut self.rng);
        let scanned = self.mode.shape(self.partial, unit).scan(&self.seat, world, out, |exact_m| {
            if is_exact {
                (exact_m / unit.step_m()).round() * unit.step_m()
            } else {
                read(exact_m, unit, rng)
            }
        })?;
        if let Scanned::Scan(scan) = scanned {
            self.partial = (self.partial + 1) % self.mode.n_partials();
            out.push(Observation {
                sensor: self.seat.sensor,
                stamp: cx.now,
                base_from_sensor: self.seat.base_from_sensor,
                valid: true,
                data: Data::LaserScan(scan),
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
