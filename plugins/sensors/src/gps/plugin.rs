//! The receiver as a sensor of the framework.

use nalgebra::{Rotation3, Vector3};
use rumbo_core::messages::{Data, MessageFault, Observation, ObservationKind, Observations, PositionFix};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{Answer, BuildContext, BuildError, Cx, Probe, Sensor, SensorError, World};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;

use super::GpsParams;
use super::capture::Capture;
use super::device::{Interpretation, Receiver};
use super::nmea::{Gga, Tally};
use super::reception::{Reception, ReceptionModel};
use crate::recorded::Seat;
use crate::text_device::TextDevice;

/// What the device is called among emulated ones.
pub(super) const MODEL: &str = "gps";

rumbo_core::register_sensor!(
    GpsParams,
    "gps",
    "positions from a satellite receiver: simulated, or NMEA 0183"
);

/// The receiver.
#[derive(Debug)]
pub struct Gps {
    seat: Seat,
    reception: ReceptionModel,
    rng: Rng,
    /// Played instead of the world.
    capture: Option<Capture>,
    interpretation: Interpretation,
    device: Device,
}

/// The real one, should the world be real.
#[derive(Debug)]
struct Device {
    port: Option<String>,
    baud: u32,
    delay: Span,
    is_dry: bool,
    live: Option<TextDevice<Receiver>>,
}

impl Plugin<dyn Sensor> for GpsParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            produces: vec![ObservationKind::PositionFix],
            default_rate_hz: Some(1.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Sensor>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let unreadable = |error: std::io::Error| BuildError::at("file", error.to_string());
        let path = self.file.as_ref().map(|file| context.resolve(file));
        let capture = path.map(|path| Capture::read(&path)).transpose().map_err(unreadable)?;
        let device = Device {
            port: self.port.clone(),
            baud: self.baud,
            delay: Span::from_secs(self.delay_s),
            is_dry: context.dry_run,
            live: None,
        };
        Ok(Box::new(Gps {
            seat: Seat::of(context),
            reception: self.reception(),
            rng: context.rng(),
            capture,
            interpretation: self.interpretation(),
            device,
        }))
    }
}

impl Sensor for Gps {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        if let Some(capture) = &mut self.capture {
            while let Some((due, gga)) = capture.next(cx.now) {
                let fix = position(&mut self.interpretation, &gga);
                push(&self.seat, due, fix, out);
            }
            tell(&capture.tally(), cx.trace);
            return Ok(());
        }
        let asked = self.seat.ask(world, &Probe::Position, "a position fix", out, |answer| match answer {
            Answer::Position(base_m) => Some(Some(*base_m)),
            Answer::Live => Some(None),
            _ => None,
        })?;
        match asked {
            Some(Some(base_m)) => self.receive(cx.now, base_m, world, out),
            Some(None) => self.device.poll(cx, &self.seat, &mut self.interpretation, world, out),
            None => Ok(()),
        }
    }
}

impl Gps {
    /// What a simulated receiver makes of the base's position.
    fn receive(
        &mut self,
        now: Time,
        base_m: [f64; 3],
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let antenna_m = Vector3::from(base_m) + self.lever_m(world)?;
        if !antenna_m.iter().all(|part| part.is_finite()) {
            let (message, field, expected) = ("a position fix", "position_m", "finite numbers");
            return Err(MessageFault { message, field, found: format!("{base_m:?}"), expected }.into());
        }
        let fix = match self.reception.receive(antenna_m.into(), now, &mut self.rng) {
            Reception::Nothing => return Ok(()),
            Reception::NoFix => None,
            Reception::Fix(position_m) => {
                let deviation_m = [ReceptionModel::deviation_m(self.reception.error_m); 3];
                Some(PositionFix { position_m, deviation_m })
            }
        };
        push(&self.seat, now, fix, out);
        Ok(())
    }

    /// From the base to the antenna in the map's axes. A receiver in the middle of the robot needs no attitude.
    fn lever_m(&self, world: &mut dyn World) -> Result<Vector3<f64>, SensorError> {
        let lever_m = self.seat.base_from_sensor.translation.vector;
        if lever_m.x == 0.0 && lever_m.y == 0.0 {
            return Ok(lever_m);
        }
        match world.probe(&Probe::Attitude)? {
            Answer::Attitude(attitude) => {
                let [roll, pitch, yaw] = attitude.attitude_rad;
                Ok(Rotation3::from_euler_angles(roll, pitch, yaw) * lever_m)
            }
            other => Err(SensorError::WrongAnswer { expected: "attitude", found: other.name() }),
        }
    }
}

impl Device {
    /// Passes on what has come since the last time. The port is opened when a real world first asks for it.
    fn poll(
        &mut self,
        cx: &Cx<'_>,
        seat: &Seat,
        interpretation: &mut Interpretation,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        if self.is_dry {
            return Ok(());
        }
        let live = match &mut self.live {
            Some(live) => live,
            empty => {
                let address = seat.device_address(MODEL, self.port.as_deref(), world)?;
                empty.insert(TextDevice::start(&address, self.baud, Receiver::default()))
            }
        };
        let outcome = live.drain(|gga, age| {
            push(seat, cx.now - age - self.delay, position(interpretation, &gga), out);
        });
        tell(&live.tally(), cx.trace);
        outcome
    }
}

/// The position of a sentence, should it have one.
fn position(interpretation: &mut Interpretation, gga: &Gga) -> Option<PositionFix> {
    match gga {
        Gga::Fix(fix) => Some(interpretation.position(fix)),
        Gga::NoFix { .. } => None,
    }
}

/// A receiver without a fix says so: an observation that nobody may use.
fn push(seat: &Seat, stamp: Time, fix: Option<PositionFix>, out: &mut Observations) {
    out.push(Observation {
        sensor: seat.sensor,
        stamp,
        base_from_sensor: seat.base_from_sensor,
        valid: fix.is_some(),
        data: Data::PositionFix(fix.unwrap_or_default()),
    });
}

/// What became of all lines, for whoever looks.
fn tell(tally: &Tally, trace: &Trace) {
    for (name, n_lines) in [
        ("gps_fixes", tally.n_fixes),
        ("gps_without_fix", tally.n_without_fix),
        ("gps_cut_off", tally.n_cut_off),
        ("gps_checksum", tally.n_checksum),
        ("gps_too_long", tally.n_too_long),
        ("gps_content", tally.n_content),
    ] {
        trace.count(name, n_lines as f64);
    }
}

#[cfg(test)]
mod tests;
