//! The inertial measurement unit as a sensor of the framework.

use nalgebra::{Rotation3, Vector3};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Check as _, Data, Imu, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, Attitude, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};
use rumbo_core::time::{Span, Time};

use super::ImuParams;
use super::device::{Interpretation, Listener};
use super::noise::ImuNoise;
use crate::recorded::Seat;
use crate::text_device::TextDevice;

/// What the device is called among emulated ones.
pub(super) const MODEL: &str = "imu";

rumbo_core::register_sensor!(
    ImuParams,
    "imu",
    "attitude and turning rates: simulated, or text of a serial board"
);

/// The device.
#[derive(Debug)]
pub struct ImuSensor {
    seat: Seat,
    noise: ImuNoise,
    rng: Rng,
    device: Device,
    /// When it was last asked, and what rates the base had then, rad/s.
    last_rates: Option<(Time, Vector3<f64>)>,
}

/// The real one, should the world be real.
#[derive(Debug)]
struct Device {
    port: Option<String>,
    baud: u32,
    delay: Span,
    interpretation: Option<Interpretation>,
    is_dry: bool,
    live: Option<TextDevice<Listener>>,
}

impl Plugin<dyn Sensor> for ImuParams {
    fn manifest(&self) -> Manifest {
        Manifest { produces: vec![ObservationKind::Imu], default_rate_hz: Some(20.0), ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let device = Device {
            port: self.port.clone(),
            baud: self.baud,
            delay: Span::from_secs(self.delay_s),
            interpretation: self.interpretation(),
            is_dry: context.dry_run,
            live: None,
        };
        Ok(Box::new(ImuSensor {
            seat: Seat::of(context),
            noise: self.noise(),
            rng: context.rng(),
            device,
            last_rates: None,
        }))
    }
}

impl Sensor for ImuSensor {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let asked = self.seat.ask(world, &Probe::Attitude, "attitude", out, |answer| match answer {
            Answer::Attitude(attitude) => Some(Some(*attitude)),
            Answer::Live => Some(None),
            _ => None,
        })?;
        match asked {
            Some(Some(attitude)) => {
                let exact = seen_by(cx.now, &attitude, &self.seat.base_from_sensor, self.last_rates);
                // Errors must not hide nonsense.
                exact.check()?;
                self.last_rates = Some((cx.now, Vector3::from(attitude.rates_rad_s)));
                push(&self.seat, cx.now, self.noise.read(&exact, cx.now, &mut self.rng), out);
                Ok(())
            }
            Some(None) => self.device.poll(cx, &self.seat, world, out),
            None => Ok(()),
        }
    }
}

impl Device {
    /// Passes on what has come since the last time. The port is opened when a real world first asks for it.
    fn poll(
        &mut self,
        cx: &Cx<'_>,
        seat: &Seat,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        if self.is_dry {
            return Ok(());
        }
        let Some(interpretation) = &mut self.interpretation else {
            return Err(SensorError::Device {
                device: seat.name.clone(),
                reason:
                    "the world is real, and `unit` does not say whether the device speaks degrees or radians"
                        .to_owned(),
            });
        };
        let live = match &mut self.live {
            Some(live) => live,
            empty => {
                let address = seat.device_address(MODEL, self.port.as_deref(), world)?;
                let listener = Listener::new(interpretation.full_turn());
                empty.insert(TextDevice::start(&address, self.baud, listener))
            }
        };
        let outcome = live.drain(|spoken, age| {
            let stamp = cx.now - age - self.delay;
            push(seat, stamp, interpretation.read(stamp, &spoken), out);
        });
        let tally = live.tally();
        for (name, n_records) in [
            ("imu_good", tally.n_good),
            ("imu_incomplete", tally.n_incomplete),
            ("imu_malformed", tally.n_malformed),
        ] {
            cx.trace.count(name, n_records as f64);
        }
        outcome
    }
}

/// The base's attitude and motion as a device sees them that is mounted like this. Beside the base's middle it feels how the
/// base turns, too; how that changes, it takes from the rates of the last time.
fn seen_by(
    now: Time,
    attitude: &Attitude,
    base_from_sensor: &Pose3,
    before: Option<(Time, Vector3<f64>)>,
) -> Imu {
    let [roll, pitch, yaw] = attitude.attitude_rad;
    let map_from_sensor =
        Rotation3::from_euler_angles(roll, pitch, yaw) * base_from_sensor.rotation.to_rotation_matrix();
    let (roll, pitch, yaw) = map_from_sensor.euler_angles();
    let (rates, arm_m) = (Vector3::from(attitude.rates_rad_s), base_from_sensor.translation.vector);
    let change_rad_s2 = before
        .filter(|(last, _)| now > *last)
        .map_or(Vector3::zeros(), |(last, last_rates)| (rates - last_rates) / (now - last).as_secs());
    let by_turning = rates.cross(&rates.cross(&arm_m)) + change_rad_s2.cross(&arm_m);
    let into_sensor = |vector: Vector3<f64>| (base_from_sensor.rotation.inverse() * vector).into();
    Imu {
        attitude_rad: Some([roll, pitch, yaw]),
        rates_rad_s: into_sensor(rates),
        accelerations_m_s2: into_sensor(Vector3::from(attitude.accelerations_m_s2) + by_turning),
    }
}

fn push(seat: &Seat, stamp: Time, imu: Imu, out: &mut Observations) {
    out.push(Observation {
        sensor: seat.sensor,
        stamp,
        base_from_sensor: seat.base_from_sensor,
        valid: true,
        data: Data::Imu(imu),
    });
}

#[cfg(test)]
mod tests;
