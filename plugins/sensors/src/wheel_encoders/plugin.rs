//! The wheel encoders as a sensor of the framework.

use rand_distr::{Distribution as _, StandardNormal};
use rumbo_core::frames::Twist;
use rumbo_core::messages::{Data, MessageFault, Observation, ObservationKind, Observations, Odometry};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{
    Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, WheelMotion, World,
};
use rumbo_core::time::Time;

use super::{Odometer, WheelEncodersParams};
use crate::recorded::Seat;

rumbo_core::register_sensor!(WheelEncodersParams, "wheel_encoders", "odometry from the wheels of any drive");

/// Encoders on the wheels.
#[derive(Debug)]
pub struct WheelEncoders {
    seat: Seat,
    odometer: Odometer,
    noise: [f64; 3],
    last: Option<Time>,
    twist: Twist,
    speed_noise_m_s: f64,
    /// What the wheels count too much by noise, meters.
    miscounted_m: [f64; 2],
    rng: Rng,
}

impl Plugin<dyn Sensor> for WheelEncodersParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::Odometry],
            default_rate_hz: Some(20.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let odometer = Odometer::new(context.robot.drive, self.steps());
        let noise = [self.claimed_distance, self.claimed_direction_deg_m.to_radians(), self.claimed_turn];
        Ok(Box::new(WheelEncoders {
            seat: Seat::of(context),
            odometer,
            noise,
            last: None,
            twist: Twist::ZERO,
            speed_noise_m_s: self.speed_noise_m_s,
            miscounted_m: [0.0; 2],
            rng: context.rng(),
        }))
    }
}

impl WheelEncoders {
    /// What noisy encoders count of what the wheels rolled.
    fn miscounted(&mut self, mut wheels: WheelMotion, seconds: f64) -> WheelMotion {
        if self.speed_noise_m_s > 0.0 {
            for (rolled_m, by_m) in wheels.rolled_m.iter_mut().zip(&mut self.miscounted_m) {
                let error: f64 = StandardNormal.sample(&mut self.rng);
                *by_m += self.speed_noise_m_s * error * seconds.max(0.0);
                *rolled_m += *by_m;
            }
        }
        wheels
    }
}

impl Sensor for WheelEncoders {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let motion = |answer: &Answer<'_>| match answer {
            Answer::Wheels(wheels) => Some(*wheels),
            _ => None,
        };
        let asked = self.seat.ask(world, &Probe::Wheels, "wheel motion", out, motion)?;
        let Some(wheels) = asked else { return Ok(()) };
        let numbers = wheels.rolled_m.iter().chain([&wheels.turned_rad, &wheels.steering_rad]);
        if let Some(number) = numbers.into_iter().find(|number| !number.is_finite()) {
            // The odometer adds up: one such number would stay in it for ever.
            let (message, field) = ("wheel motion", "rolled_m");
            return Err(MessageFault {
                message,
                field,
                found: number.to_string(),
                expected: "finite numbers",
            }
            .into());
        }
        let seconds = self.last.map_or(0.0, |last| (cx.now - last).as_secs());
        let counted = self.miscounted(wheels, seconds);
        let moved = self.odometer.update(&counted);
        if seconds > 0.0 {
            self.twist = moved.scaled(1.0 / seconds);
        }
        self.last = Some(cx.now);
        out.push(Observation {
            sensor: self.seat.sensor,
            stamp: cx.now,
            base_from_sensor: self.seat.base_from_sensor,
            valid: true,
            data: Data::Odometry(Odometry {
                odom_from_base: self.odometer.report(),
                twist: self.twist,
                noise: self.noise,
            }),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests;
