//! The LMS 200 as a sensor of the framework.

use rumbo_core::messages::{Data, Observation, ObservationKind, Observations};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::rng::Rng;
use rumbo_core::stages::{BuildContext, BuildError, Cx, Sensor, SensorError, World};
use rumbo_core::time::Time;

use super::device::read;
use super::driver::Settings;
use super::live::{Interpretation, Live};
use super::tilt::tilt;
use super::{Lms200Mode, Lms200Params, Lms200Unit};
use crate::laser_2d::scanner::Scanned;
use crate::recorded::Seat;

/// What the device is called among emulated ones.
pub(super) const MODEL: &str = "lms200";

rumbo_core::register_sensor!(Lms200Params, "lms200", "the SICK LMS 200 laser scanner with its variants");

/// The scanner.
#[derive(Debug)]
pub struct Lms200 {
    seat: Seat,
    mode: Lms200Mode,
    unit: Lms200Unit,
    is_exact: bool,
    tilted: f64,
    partial: usize,
    rng: Rng,
    device: Device,
}

/// The real device, should the world be real.
#[derive(Debug)]
struct Device {
    port: Option<String>,
    settings: Settings,
    interpretation: Interpretation,
    is_dry: bool,
    live: Option<Live>,
}

impl Plugin<dyn Sensor> for Lms200Params {
    fn manifest(&self) -> Manifest {
        let max_rate_hz = self.mode().map(Lms200Mode::rate_hz);
        Manifest {
            produces: vec![ObservationKind::LaserScan],
            default_rate_hz: Some(10.0),
            max_rate_hz,
            field_of_view_rad: Some(self.field_of_view_deg.to_radians()),
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
        let (unit, is_exact) = (self.unit, self.exact);
        let (Some(settings), Some(measuring_mode)) = (self.settings(), self.distance_mode()) else {
            return Err(BuildError::at("measuring_mode", "the device cannot do this"));
        };
        let interpretation = Interpretation { mode, unit, measuring_mode, is_inverted: self.inverted };
        let (port, is_dry) = (self.port.clone(), context.dry_run);
        let device = Device { port, settings, interpretation, is_dry, live: None };
        let tilted = self.tilted;
        Ok(Box::new(Lms200 { seat, mode, unit, is_exact, tilted, partial: 0, rng, device }))
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
        match scanned {
            Scanned::Scan(mut scan) => {
                tilt(scan.ranges_m.make_mut(), self.tilted, &mut self.rng);
                self.partial = (self.partial + 1) % self.mode.n_partials();
                out.push(Observation {
                    sensor: self.seat.sensor,
                    stamp: cx.now,
                    base_from_sensor: self.seat.base_from_sensor,
                    valid: true,
                    data: Data::LaserScan(scan),
                });
            }
            Scanned::Recorded => {}
            Scanned::Live => self.device.poll(&self.seat, cx.now, world, out)?,
        }
        Ok(())
    }
}

impl Device {
    /// Passes on what has come from the device since the last time. The port is opened when a real world first asks for it.
    fn poll(
        &mut self,
        seat: &Seat,
        now: Time,
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
                empty.insert(Live::start(&address, self.settings.clone()))
            }
        };
        let interpretation = &self.interpretation;
        live.drain(|scan, age| {
            let data = Data::LaserScan(interpretation.laser_scan(scan, out));
            out.push(Observation {
                sensor: seat.sensor,
                stamp: now - age,
                base_from_sensor: seat.base_from_sensor,
                valid: !scan.status.is_implausible(),
                data,
            });
        })
    }
}

#[cfg(test)]
mod tests;
