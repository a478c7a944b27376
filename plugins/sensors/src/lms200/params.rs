//! What `[[sensor]] plugin = "lms200"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::port::address_fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::driver::Settings;
use super::protocol::{LineSpeed, MeasuringMode};
use super::{Lms200Mode, Lms200Unit};

/// The SICK LMS 200: ±15 mm, 8 m in millimeters or 80 m in centimeters, 180 or 100 degrees.
///
/// 0.25 degrees over 180 is not a variant of the device: it comes as four partial scans of 1 degree steps, each a
/// quarter degree further and each with its own stamp, so `rate_hz` then counts partial scans.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Lms200Params {
    /// 180 or 100 degrees.
    pub field_of_view_deg: f64,
    /// 1, 0.5 or 0.25 degrees.
    pub resolution_deg: f64,
    /// `"mm"` reaches 8.18 m, `"cm"` 81.8 m.
    pub unit: Lms200Unit,
    /// Exact readings in whole counts instead of readings within ±15 mm.
    pub exact: bool,
    /// Share of the simulated scans that a rocking robot tilts: half of such a scan reads 3 % too long.
    pub tilted: f64,
    /// Where the real device is, in a world that is real: a serial port such as `/dev/ttyUSB0`, or `tcp://host:port` of a
    /// bridge that follows its speed. Simulated and recorded worlds do not need it.
    pub port: Option<String>,
    /// Speed of the line to the real device: 9600, 19200 or 38400 baud over RS-232, where it lets some of the scans
    /// through, or 500000 over RS-422, where all come.
    pub baud: u32,
    /// Speeds at which the real device is looked for besides `baud`, in this order.
    pub connect_baud: Vec<u32>,
    /// How the real device's values share their bits between distance and flags: 0, 2, 4, 6 fields, 1, 3, 5 reflector
    /// levels (which become intensities), 15 distance only. From 3 on there are more bits and more reach.
    pub measuring_mode: u8,
    /// The real device hangs upside down: its values run from left to right.
    pub inverted: bool,
}

impl Default for Lms200Params {
    fn default() -> Self {
        Self {
            field_of_view_deg: 180.0,
            resolution_deg: 0.5,
            unit: Lms200Unit::Millimeters,
            exact: false,
            tilted: 0.0,
            port: None,
            baud: 38_400,
            connect_baud: vec![9600, 38_400, 19_200, 500_000],
            measuring_mode: 0,
            inverted: false,
        }
    }
}

impl Params for Lms200Params {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if Lms200Mode::new(self.field_of_view_deg, 1.0).is_none() {
            let message =
                format!("is {}, expected 180 or 100: the device has no other", self.field_of_view_deg);
            faults.push(BuildError::at("field_of_view_deg", message));
        }
        if Lms200Mode::new(180.0, self.resolution_deg).is_none() {
            let message =
                format!("is {}, expected 1, 0.5 or 0.25: the device has no other", self.resolution_deg);
            faults.push(BuildError::at("resolution_deg", message));
        }
        if !(0.0..=1.0).contains(&self.tilted) {
            faults
                .push(BuildError::at("tilted", format!("is {}, expected a share from 0 to 1", self.tilted)));
        }
        let is_speed = |baud: u32| LineSpeed::of_baud(baud).is_some();
        let not_speed = |baud: u32| format!("is {baud}, expected 9600, 19200, 38400 or 500000");
        if !is_speed(self.baud) {
            faults.push(BuildError::at("baud", not_speed(self.baud)));
        }
        let wrong = self.connect_baud.iter().enumerate().filter(|(_, baud)| !is_speed(**baud));
        faults.extend(
            wrong.map(|(idx, baud)| BuildError::at(format!("connect_baud[{idx}]"), not_speed(*baud))),
        );
        faults.extend(address_fault(self.port.as_deref()));
        if self.distance_mode().is_none() {
            let message = format!("is {}, expected 0 to 6 or 15", self.measuring_mode);
            faults.push(BuildError::at("measuring_mode", message));
        }
        faults
    }
}

impl Lms200Params {
    /// The device's variant; `None` when [`check`](Params::check) has faults.
    pub fn mode(&self) -> Option<Lms200Mode> {
        Lms200Mode::new(self.field_of_view_deg, self.resolution_deg)
    }

    /// The measuring mode, if it has distances.
    pub(super) fn distance_mode(&self) -> Option<MeasuringMode> {
        MeasuringMode::of_code(self.measuring_mode).filter(|mode| mode.distance_bits() > 0)
    }

    /// What the real device shall do; `None` when [`check`](Params::check) has faults.
    pub(super) fn settings(&self) -> Option<Settings> {
        let mode = self.mode()?;
        Some(Settings {
            connect: self.connect_baud.iter().filter_map(|baud| LineSpeed::of_baud(*baud)).collect(),
            speed: LineSpeed::of_baud(self.baud)?,
            variant: mode.variant(),
            partials: mode.is_partial(),
            unit: self.unit.count_unit(),
            measuring_mode: self.distance_mode()?,
        })
    }
}
