//! The robot as a world of the framework.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{Command, Observation};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{
    Advance, Answer, BuildContext, BuildError, Drove, OwnDevice, Probe, Truth, World, WorldError,
};
use rumbo_core::time::Time;
use rumbo_kit::emulation::Outlet;
use rumbo_kit::wall_clock::WallClock;

use super::emulated::EmulatedRobot;
use super::fits::{Cones, check_base};
use super::params::RobotParams;
use super::worker::Connection;
use crate::sim::Start;

rumbo_core::register_world!(
    RobotParams,
    "robot",
    "a real robot: its base over a serial port or TCP, its sensors at their own ports"
);

/// The real world.
#[derive(Debug)]
pub struct RobotWorld {
    /// Dropped before the robot that may be emulated: it says good-bye to it.
    connection: Option<Connection>,
    emulated: Option<EmulatedRobot>,
    address: String,
    robot: Arc<Robot>,
    give_up_s: f64,
    start: Option<Pose2>,
    map_file: Option<PathBuf>,
    clock: Option<WallClock>,
    now: Time,
    truth: Option<Truth>,
    contacts_rad: Vec<f64>,
    recorded: Vec<Observation>,
}

impl Plugin<dyn World> for RobotParams {
    fn build(&self, context: &BuildContext) -> Result<Box<dyn World>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let emulate = self.emulated();
        let mut emulated = emulate
            .map(|emulate| Ok(EmulatedRobot::new(emulate.place(context)?, emulate, context)))
            .transpose()?;
        let address = match (&mut emulated, &self.port) {
            (Some(robot), _) if !context.dry_run => served(robot)?,
            (_, port) => port.clone().unwrap_or_default(),
        };
        let connection = (!context.dry_run).then(|| Connection::start(&address, self.baud));
        let start = self.start.or(emulate.map(|emulate| emulate.start));
        let map = self.map.as_ref().or(emulate.and_then(|emulate| emulate.map.as_ref()));
        Ok(Box::new(RobotWorld {
            truth: emulated.as_ref().and_then(EmulatedRobot::truth),
            connection,
            emulated,
            address,
            robot: Arc::clone(&context.robot),
            give_up_s: self.give_up_s,
            start: start.map(|Start { x_m, y_m, yaw_deg }| pose2(x_m, y_m, yaw_deg.to_radians())),
            map_file: map.map(|map| context.resolve(map)),
            clock: None,
            now: Time::ZERO,
            contacts_rad: Vec::new(),
            recorded: Vec::new(),
        }))
    }
}

fn served(robot: &mut EmulatedRobot) -> Result<String, BuildError> {
    let served = Outlet::any().and_then(|outlet| robot.serve_base(outlet));
    served
        .map_err(|error| BuildError::at("emulate", format!("there is no pseudo-terminal to be had: {error}")))
}

impl RobotWorld {
    /// Ends the run where the base cannot be driven, or does not come back.
    fn check(&self) -> Result<(), WorldError> {
        let Some(connection) = &self.connection else { return Ok(()) };
        let (link, now) = connection.now();
        let about = |reason: String| WorldError::Other(format!("the base at {}: {reason}", self.address));
        if let Some(reason) = link.refused() {
            return Err(about(reason.to_owned()));
        }
        if let Some(base) = link.base() {
            check_base(base, &self.robot).map_err(about)?;
        }
        match link.lost_for(now) {
            Some((span, reason)) if span.as_secs() > self.give_up_s => {
                Err(about(format!("no answer for {:.0} s: {reason}", self.give_up_s)))
            }
            _ => Ok(()),
        }
    }

    fn wheels(&mut self) -> Answer<'_> {
        let taken =
            self.connection.as_ref().and_then(|connection| connection.now().0.readings().wheels.take());
        taken.map_or(Answer::Recorded(&[]), |reading| Answer::Wheels(reading.value))
    }

    fn contacts(&mut self) -> Result<Answer<'_>, WorldError> {
        let Some(connection) = &self.connection else { return Ok(Answer::Recorded(&[])) };
        let (mut link, _) = connection.now();
        let touch = link.readings().touch.take();
        let Some(ring) = link.base().map(|base| base.bumpers) else { return Ok(Answer::Recorded(&[])) };
        if ring.n_bumpers == 0 {
            return Err(has_none("bumpers"));
        }
        let Some(touch) = touch else { return Ok(Answer::Recorded(&[])) };
        let pressed = (0..ring.n_bumpers).filter(|k| touch.value >> k & 1 == 1);
        self.contacts_rad.clear();
        self.contacts_rad
            .extend(pressed.map(|k| ring.first_bearing_rad + ring.bearing_step_rad * f64::from(k)));
        Ok(Answer::Contacts(&self.contacts_rad))
    }

    fn cones(&mut self, cones: &Cones<'_>) -> Result<Answer<'_>, WorldError> {
        self.recorded.clear();
        let Some(connection) = &self.connection else { return Ok(Answer::Recorded(&[])) };
        let (mut link, now) = connection.now();
        let ranges = link.readings().ranges_m.take();
        let Some(ring) = link.base().map(|base| base.sonars) else { return Ok(Answer::Recorded(&[])) };
        if ring.n_sonars == 0 {
            return Err(has_none("sonars"));
        }
        cones.check(&ring).map_err(WorldError::Other)?;
        if let Some(ranges) = ranges {
            let stamp = self.now - (now - ranges.at);
            self.recorded.push(cones.observation(&ring, stamp, &ranges.value));
        }
        Ok(Answer::Recorded(&self.recorded))
    }
}

fn has_none(what: &str) -> WorldError {
    WorldError::Other(format!("the base has no {what}; remove the sensor that asks for them"))
}

impl World for RobotWorld {
    fn now(&self) -> Time {
        self.now
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        if to < self.now {
            return Err(WorldError::Backwards { now: self.now, to });
        }
        // The clock begins with the first step: building maps takes its time.
        let clock = *self.clock.get_or_insert_with(WallClock::start);
        clock.sleep_until(to);
        self.now = clock.now().max(to);
        self.truth = self.emulated.as_ref().and_then(EmulatedRobot::truth);
        self.check()?;
        Ok(Advance::Reached(self.now))
    }

    fn drive(&mut self, command: &Command) -> Result<Drove, WorldError> {
        if !command.twist.is_finite() {
            return Err(WorldError::NotFinite);
        }
        if let Some(connection) = &self.connection {
            let (mut link, now) = connection.now();
            link.drive(now, command.twist);
        }
        Ok(Drove::Drove)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        match *probe {
            Probe::Wheels => Ok(self.wheels()),
            Probe::Contacts => self.contacts(),
            Probe::Cones { base_from_sensor, bearings_rad, cone_rad, ring_radius_m, max_range_m } => {
                self.cones(&Cones { base_from_sensor, bearings_rad, cone_rad, ring_radius_m, max_range_m })
            }
            Probe::Channel { .. } => Err(WorldError::Unsupported { probe: probe.name() }),
            _ => Ok(Answer::Live),
        }
    }

    fn emulated_device(&mut self, device: &OwnDevice<'_>) -> Result<Option<String>, WorldError> {
        let Some(robot) = &mut self.emulated else { return Ok(None) };
        let outlet = Outlet::any().map_err(|error| WorldError::Other(error.to_string()))?;
        robot.serve_device(device, outlet).map(Some)
    }

    fn truth(&self) -> Option<&Truth> {
        self.truth.as_ref()
    }

    fn start(&self) -> Option<Pose2> {
        self.start
    }

    fn map_file(&self) -> Option<&Path> {
        self.map_file.as_deref()
    }

    fn take_notice(&mut self) -> Option<String> {
        let (mut link, _) = self.connection.as_ref()?.now();
        link.next_event().map(|event| event.to_string())
    }

    fn is_real_time(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests;
