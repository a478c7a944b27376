//! The range finder as a sensor of the framework.

use rumbo_core::messages::{Data, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Sensor, SensorError, World};

use super::scanner::{ScanShape, Scanned};
use super::{Laser2dParams, ScanFaultParams, ScanNoise};
use crate::recorded::Seat;

rumbo_core::register_sensor!(
    Laser2dParams,
    "laser_2d",
    "a planar laser range finder of any shape, range and noise"
);

/// A planar range finder.
#[derive(Debug)]
pub struct Laser2d {
    seat: Seat,
    shape: ScanShape,
    noise: Box<dyn ScanNoise>,
    faults: ScanFaultParams,
    rng: Rng,
}

impl Plugin<dyn Sensor> for Laser2dParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::LaserScan],
            default_rate_hz: Some(10.0),
            field_of_view_rad: Some(self.field_of_view_deg.to_radians()),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let (seat, rng) = (Seat::of(context), context.rng());
        let (noise, faults) = (self.noise.clone(), self.faults);
        Ok(Box::new(Laser2d { seat, shape: self.shape(), noise, faults, rng }))
    }
}

impl Sensor for Laser2d {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let (noise, rng) = (&*self.noise, &mut self.rng);
        let scanned = if noise.bends_beams() {
            self.shape.bent_scan(&self.seat, world, out, noise, rng)?
        } else {
            self.shape.scan(&self.seat, world, out, |exact_m| noise.read(exact_m, rng))?
        };
        match scanned {
            Scanned::Scan(_) if self.faults.is_silent(cx.now) => {}
            Scanned::Scan(mut scan) => {
                self.faults.befall(&mut scan, &mut self.rng);
                out.push(Observation {
                    sensor: self.seat.sensor,
                    stamp: cx.now,
                    base_from_sensor: self.seat.base_from_sensor,
                    valid: true,
                    data: Data::LaserScan(scan),
                });
            }
            Scanned::Recorded => {}
            // A scanner of any shape is no device that could be read.
            Scanned::Live => {
                return Err(SensorError::WrongAnswer { expected: "beams", found: Answer::Live.name() });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
