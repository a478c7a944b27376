//! The tracker as a sensor of the framework.

use rumbo_core::frames::Point2;
use rumbo_core::messages::{Data, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};
use rumbo_core::time::Span;

use super::{PersonTrackerParams, Tracker};
use crate::recorded::Seat;

rumbo_core::register_sensor!(
    PersonTrackerParams,
    "person_tracker",
    "where a person is: a phone, a tag or a tracker, for `mission.follow`"
);

/// A tracker of one person.
#[derive(Debug)]
pub struct PersonTracker {
    seat: Seat,
    person: String,
    tracker: Tracker,
    rng: Rng,
}

impl Plugin<dyn Sensor> for PersonTrackerParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::Custom],
            default_rate_hz: Some(2.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let tracker = Tracker::new(self.deviation_m, Span::from_secs(self.delay_s), self.dropout_share);
        let (seat, rng) = (Seat::of(context), context.rng());
        Ok(Box::new(PersonTracker { seat, person: self.person.clone(), tracker, rng }))
    }
}

/// What the world said.
enum Said {
    At([f64; 3]),
    ReadYourDevice,
}

impl Sensor for PersonTracker {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let probe = Probe::Person { name: &self.person };
        let take = |answer: &Answer<'_>| match answer {
            Answer::Position(at) => Some(Said::At(*at)),
            Answer::Live => Some(Said::ReadYourDevice),
            _ => None,
        };
        match self.seat.ask(world, &probe, "where a person is", out, take)? {
            Some(Said::ReadYourDevice) => return Err(no_device()),
            // A world that answers nonsense must not be measured: errors would hide it.
            Some(Said::At(exact)) if exact.iter().all(|number| number.is_finite()) => {
                self.tracker.measure(cx.now, Point2::new(exact[0], exact[1]), &mut self.rng);
            }
            _ => {}
        }
        while let Some((stamp, person)) = self.tracker.arrived(cx.now) {
            out.push(Observation {
                sensor: self.seat.sensor,
                stamp,
                base_from_sensor: self.seat.base_from_sensor,
                valid: true,
                data: Data::Custom(person.to_custom()),
            });
        }
        Ok(())
    }
}

fn no_device() -> SensorError {
    SensorError::Device {
        device: "the person's phone".to_owned(),
        reason: "this sensor has no protocol for one; give the positions as orders (person_at) instead"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests;
