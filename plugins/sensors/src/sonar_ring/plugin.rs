//! The sonar ring as a sensor of the framework.

use std::f64::consts::TAU;

use rand::RngExt as _;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::messages::{Data, Observation, ObservationKind, Observations, RangeRing};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};

use super::SonarRingParams;
use super::crosstalk::mix;
use crate::recorded::Seat;

rumbo_core::register_sensor!(SonarRingParams, "sonar_ring", "ultrasonic transducers around the hull");

/// A ring of transducers.
#[derive(Debug)]
pub struct SonarRing {
    seat: Seat,
    params: SonarRingParams,
    bearings_rad: Vec<f64>,
    /// What each transducer would read alone.
    exact_m: Vec<f32>,
    rng: Rng,
}

impl Plugin<dyn Sensor> for SonarRingParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::RangeRing],
            default_rate_hz: Some(10.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let mut params = self.clone();
        if params.ring_radius_m == 0.0 {
            params.ring_radius_m = context.robot.hull().inner_radius_m();
        }
        let step_rad = TAU / f64::from(self.transducers);
        let bearings_rad = (0..self.transducers).map(|k| step_rad * f64::from(k)).collect();
        let exact_m = vec![0.0; self.transducers as usize];
        Ok(Box::new(SonarRing { seat: Seat::of(context), params, bearings_rad, exact_m, rng: context.rng() }))
    }
}

impl SonarRing {
    /// REP-117: infinite without an echo, not-a-number for one that was lost or is too near.
    fn reading(&mut self, exact_m: f32) -> f32 {
        if !exact_m.is_finite() {
            return f32::INFINITY;
        }
        let normal: f64 = StandardNormal.sample(&mut self.rng);
        let reading_m = f64::from(exact_m) + normal * self.params.deviation_m;
        let is_lost = self.params.dropout > 0.0 && self.rng.random::<f64>() < self.params.dropout;
        if is_lost || reading_m < self.params.min_range_m {
            f32::NAN
        } else if reading_m > self.params.max_range_m {
            f32::INFINITY
        } else {
            reading_m as f32
        }
    }
}

impl Sensor for SonarRing {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let probe = Probe::Cones {
            base_from_sensor: &self.seat.base_from_sensor,
            bearings_rad: &self.bearings_rad,
            cone_rad: self.params.cone_deg.to_radians(),
            ring_radius_m: self.params.ring_radius_m,
            max_range_m: self.params.max_range_m,
        };
        let mut ranges_m = out.buffer(self.bearings_rad.len());
        let exact_m = &mut self.exact_m;
        let keep = |answer: &Answer<'_>| match answer {
            Answer::Ranges(exact) if exact.len() == ranges_m.len() => {
                exact_m.clear();
                exact_m.extend_from_slice(exact);
                Some(())
            }
            _ => None,
        };
        if self.seat.ask(world, &probe, "sound cones", out, keep)?.is_none() {
            return Ok(());
        }
        let heard_m = ranges_m.make_mut();
        heard_m.copy_from_slice(&self.exact_m);
        mix(&self.exact_m, self.params.crosstalk, &mut self.rng, heard_m);
        for range in heard_m {
            *range = self.reading(*range);
        }
        let ring = RangeRing {
            first_bearing_rad: 0.0,
            bearing_step_rad: TAU / f64::from(self.params.transducers),
            cone_rad: self.params.cone_deg.to_radians(),
            ring_radius_m: self.params.ring_radius_m,
            min_range_m: self.params.min_range_m as f32,
            max_range_m: self.params.max_range_m as f32,
            ranges_m,
        };
        out.push(Observation {
            sensor: self.seat.sensor,
            stamp: cx.now,
            base_from_sensor: self.seat.base_from_sensor,
            valid: true,
            data: Data::RangeRing(ring),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests;
