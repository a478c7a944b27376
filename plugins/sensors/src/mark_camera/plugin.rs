//! The camera as a sensor of the framework.

use rumbo_core::messages::{Check, Data, Mark, Marks, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};

use super::{MarkCameraParams, MarkNoise};
use crate::recorded::Seat;

rumbo_core::register_sensor!(
    MarkCameraParams,
    "mark_camera",
    "range and bearing to marks that a camera recognizes"
);

/// A camera that recognizes marks.
#[derive(Debug)]
pub struct MarkCamera {
    seat: Seat,
    params: MarkCameraParams,
    noise: MarkNoise,
    rng: Rng,
}

impl Plugin<dyn Sensor> for MarkCameraParams {
    fn manifest(&self) -> Manifest {
        Manifest { produces: vec![ObservationKind::Marks], default_rate_hz: Some(5.0), ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let (seat, rng) = (Seat::of(context), context.rng());
        Ok(Box::new(MarkCamera { seat, params: self.clone(), noise: self.noise(), rng }))
    }
}

impl Sensor for MarkCamera {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let probe = Probe::Marks {
            base_from_sensor: &self.seat.base_from_sensor,
            field_of_view_rad: self.params.field_of_view_deg.to_radians(),
            max_range_m: self.params.max_range_m,
        };
        let (noise, rng) = (&self.noise, &mut self.rng);
        let look = |answer: &Answer<'_>| {
            let Answer::Marks(exact) = answer else { return None };
            // A world that answers nonsense must not be measured: errors would hide it.
            let sound = exact.check().is_ok().then_some(&exact.marks);
            let marks = sound.map(|marks| marks.iter().filter_map(|mark| noise.read(mark, rng)).collect());
            Some(marks)
        };
        let asked: Option<Option<Vec<Mark>>> = self.seat.ask(world, &probe, "marks", out, look)?;
        let Some(marks) = asked else { return Ok(()) };
        let (is_sound, marks) = (marks.is_some(), marks.unwrap_or_default());
        let range_deviation_m =
            self.params.range_deviation_m + self.params.range_share * mean_range_m(&marks);
        // A picture without a mark tells something, too.
        let seen = Marks { marks, range_deviation_m, bearing_deviation_rad: self.noise.bearing_rad };
        out.push(Observation {
            sensor: self.seat.sensor,
            stamp: cx.now,
            base_from_sensor: self.seat.base_from_sensor,
            valid: is_sound,
            data: Data::Marks(seen),
        });
        Ok(())
    }
}

/// A message has one deviation of ranges for all its marks: that of their mean.
fn mean_range_m(marks: &[Mark]) -> f64 {
    if marks.is_empty() {
        return 0.0;
    }
    marks.iter().map(|mark| mark.range_m).sum::<f64>() / marks.len() as f64
}

#[cfg(test)]
mod tests;
