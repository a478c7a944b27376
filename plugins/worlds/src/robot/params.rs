//! What `[world] plugin = "robot"` takes.

use std::path::PathBuf;

use rumbo_core::registry::{Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, World};
use rumbo_kit::emulation::LineFaultParams;
use rumbo_kit::port::is_address;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sim::{SimParams, Slip, Start};

/// A real robot in real time: its base speaks the protocol of `docs/base-protocol.md` over a serial port or TCP, and
/// sensors such as `lms200` read their own devices.
///
/// With the table `emulate` there is no robot: base and devices are emulated in a simulated place, behind the same lines
/// and in real time, and `port` (also that of sensors) is not used. Without it the same file drives the real robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RobotParams {
    /// Where the base is: a serial port such as `/dev/ttyUSB1`, or `tcp://host:port`.
    pub port: Option<String>,
    /// Speed of the serial port, bits in a second.
    pub baud: u32,
    /// The map of the place: a map_server YAML file or a TOML world file, for plugins without a file of their own.
    pub map: Option<PathBuf>,
    /// Where an operator would say that the robot stands at the start.
    pub start: Option<Start>,
    /// A base that does not answer for so long ends the run, seconds.
    pub give_up_s: f64,
    /// The robot that is not there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emulate: Option<EmulateParams>,
}

/// A robot in a simulated place, emulated in real time behind pseudo-terminals (TCP where there are none).
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EmulateParams {
    /// Emulate in this run; with `false` the real ports are opened, and the table is for `rumbo emulate` only.
    pub enabled: bool,
    /// The place: a TOML world file, or a map_server YAML file. Without it: an endless plain.
    pub map: Option<PathBuf>,
    /// Where the robot stands at the start.
    pub start: Start,
    /// How the wheels slip, as in the world `sim`; without it they grip.
    #[schemars(schema_with = "crate::sim::slip_schema")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip: Option<Box<dyn Slip>>,
    /// How many sonars the base has, evenly around its hull; 0 for none.
    pub sonars: u32,
    /// Full opening of the sonars' cones, degrees.
    pub sonar_cone_deg: f64,
    /// How many bumpers the base has, evenly around its hull; 0 for none.
    pub bumpers: u32,
    /// What goes wrong on the lines.
    pub faults: LineFaultParams,
}

impl Default for EmulateParams {
    fn default() -> Self {
        Self {
            enabled: true,
            map: None,
            start: Start::default(),
            slip: None,
            sonars: 16,
            sonar_cone_deg: 25.0,
            bumpers: 16,
            faults: LineFaultParams::default(),
        }
    }
}

/// Rings of more are no rings of bases, and do not fit into a line.
const MOST_IN_RING: u32 = 64;

impl Default for RobotParams {
    fn default() -> Self {
        Self { port: None, baud: 115_200, map: None, start: None, give_up_s: 10.0, emulate: None }
    }
}

impl RobotParams {
    /// The robot that is emulated in this run.
    pub fn emulated(&self) -> Option<&EmulateParams> {
        self.emulate.as_ref().filter(|emulate| emulate.enabled)
    }
}

impl Params for RobotParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        match &self.port {
            Some(port) if !is_address(port) => {
                let message = format!("is `{port}`, expected a serial port or tcp://host:port");
                faults.push(BuildError::at("port", message));
            }
            None if self.emulated().is_none() => {
                let fault = BuildError::at("port", "is missing, expected the port of the base");
                faults.push(fault.help(
                    "such as /dev/ttyUSB0 or tcp://host:port; to try without a robot, add the table `emulate`",
                ));
            }
            _ => {}
        }
        if self.baud == 0 {
            faults
                .push(BuildError::at("baud", "is 0, expected the speed of the base's port, such as 115200"));
        }
        if !(self.give_up_s.is_finite() && self.give_up_s > 0.0) {
            let message = format!("is {}, expected a finite time above 0", self.give_up_s);
            faults.push(BuildError::at("give_up_s", message));
        }
        if let Some(start) = &self.start {
            faults.extend(start.faults("start"));
        }
        faults.extend(self.emulate.iter().flat_map(EmulateParams::check));
        faults
    }
}

impl EmulateParams {
    /// The simulated place, with the robot in it.
    pub fn place(&self, context: &BuildContext) -> Result<Box<dyn World>, BuildError> {
        let sim = SimParams {
            map: self.map.clone(),
            start: self.start,
            slip: self.slip.clone(),
            ..SimParams::default()
        };
        sim.build(context).map_err(|fault| BuildError { path: format!("emulate.{}", fault.path), ..fault })
    }

    /// Every impossible value at once.
    pub fn check(&self) -> Vec<BuildError> {
        let mut faults = self.start.faults("emulate.start");
        for (key, n) in [("sonars", self.sonars), ("bumpers", self.bumpers)] {
            if n > MOST_IN_RING {
                let message = format!("is {n}, expected at most {MOST_IN_RING}");
                faults.push(BuildError::at(format!("emulate.{key}"), message));
            }
        }
        let cone_deg = self.sonar_cone_deg;
        if !(cone_deg > 0.0 && cone_deg <= 180.0) {
            let message = format!("is {cone_deg}, expected an angle above 0, up to 180");
            faults.push(BuildError::at("emulate.sonar_cone_deg", message));
        }
        for (key, message) in self.slip.iter().flat_map(|slip| slip.faults()) {
            faults.push(BuildError::at(format!("emulate.slip.{key}"), message));
        }
        for (key, message) in self.faults.faults() {
            faults.push(BuildError::at(format!("emulate.faults.{key}"), message));
        }
        faults
    }
}
