//! The steering encoder as a sensor of the framework.

use rand_distr::{Distribution as _, StandardNormal};
use rumbo_core::frames::wrap_angle;
use rumbo_core::messages::{Data, Observation, ObservationKind, Observations, SteeringAngle};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::robot::DriveKind;
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};

use super::SteeringEncoderParams;
use crate::recorded::Seat;

rumbo_core::register_sensor!(
    SteeringEncoderParams,
    "steering_encoder",
    "the angle of a tricycle's steered wheel"
);

/// An encoder on the steered wheel.
#[derive(Debug)]
pub struct SteeringEncoder {
    seat: Seat,
    params: SteeringEncoderParams,
    rng: Rng,
}

impl Plugin<dyn Sensor> for SteeringEncoderParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::SteeringAngle],
            drives: vec![DriveKind::Tricycle],
            default_rate_hz: Some(20.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let seat = Seat::of(context);
        Ok(Box::new(SteeringEncoder { seat, params: self.clone(), rng: context.rng() }))
    }
}

impl SteeringEncoder {
    /// What the encoder says of an angle, radians.
    fn read(&mut self, exact_rad: f64) -> f64 {
        let SteeringEncoderParams { deviation_deg, step_deg, offset_deg } = self.params;
        let error: f64 = StandardNormal.sample(&mut self.rng);
        let angle_rad = exact_rad + (offset_deg + deviation_deg * error).to_radians();
        let step_rad = step_deg.to_radians();
        wrap_angle(if step_rad > 0.0 { (angle_rad / step_rad).round() * step_rad } else { angle_rad })
    }
}

impl Sensor for SteeringEncoder {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let steering_rad = |answer: &Answer<'_>| match answer {
            Answer::Wheels(wheels) => Some(wheels.steering_rad),
            _ => None,
        };
        let asked = self.seat.ask(world, &Probe::Wheels, "wheel motion", out, steering_rad)?;
        let Some(exact_rad) = asked else { return Ok(()) };
        let angle_rad = self.read(exact_rad);
        out.push(Observation {
            sensor: self.seat.sensor,
            stamp: cx.now,
            base_from_sensor: self.seat.base_from_sensor,
            valid: angle_rad.is_finite(),
            data: Data::SteeringAngle(SteeringAngle {
                angle_rad: if angle_rad.is_finite() { angle_rad } else { 0.0 },
            }),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rumbo_core::stages::WheelMotion;
    use rumbo_core::time::Time;
    use rumbo_core::trace::Trace;

    use super::*;
    use crate::test_world::{TestWorld, given};

    fn readings(params: &SteeringEncoderParams, exact_rad: f64, n: usize) -> Vec<f64> {
        let mut sensor = params.build(&BuildContext::bare("sensor")).unwrap();
        let (mut world, mut out, trace) =
            (TestWorld::with_wall(1.0), Observations::default(), Trace::unwatched());
        world.wheels = WheelMotion { steering_rad: exact_rad, ..WheelMotion::default() };
        for tick in 0..n {
            let now = Time(tick as i64);
            sensor.poll(&mut Cx { now, trace: &trace }, &mut world, &mut out).unwrap();
        }
        let angle = |observation: &Observation| match observation.data {
            Data::SteeringAngle(SteeringAngle { angle_rad }) if observation.valid => angle_rad,
            _ => f64::NAN,
        };
        given(&out).iter().map(angle).collect()
    }

    #[test]
    fn readings_have_the_error_and_the_offset_they_are_said_to_have() {
        let params = SteeringEncoderParams { offset_deg: -1.0, ..SteeringEncoderParams::default() };
        let errors: Vec<f64> =
            readings(&params, 0.3, 20_000).iter().map(|angle| (angle - 0.3).to_degrees()).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / errors.len() as f64;
        assert!((mean + 1.0).abs() < 0.015 && (variance.sqrt() - 0.5).abs() < 0.01, "{mean} {variance}");
    }

    #[test]
    fn steps_are_rounded_and_no_number_is_no_angle() {
        let params = SteeringEncoderParams { deviation_deg: 0.0, step_deg: 0.25, offset_deg: 0.0 };
        assert!((readings(&params, 0.1, 1)[0].to_degrees() - 5.75).abs() < 1e-12, "5.73 degrees");
        assert!(readings(&params, f64::NAN, 1)[0].is_nan());
        let bad = SteeringEncoderParams { deviation_deg: -1.0, step_deg: f64::NAN, offset_deg: 91.0 };
        assert_eq!(bad.check().len(), 3);
    }
}
