//! What `[[sensor]] plugin = "gps"` takes.

use std::path::PathBuf;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_core::time::Time;
use rumbo_kit::port::address_fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::device::Interpretation;
use super::local_frame::LocalFrame;
use super::reception::ReceptionModel;

/// A satellite receiver: positions of its antenna in the map.
///
/// In a simulated world it errs as `error_m`, `bias_m`, `dropout` and `outages` say. At a real line, or from a capture of
/// one, it reads NMEA 0183 (GGA sentences) and turns degrees into meters on a plane that touches the earth at `origin`. A
/// recording is passed on as it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GpsParams {
    /// Fixes err evenly between minus and plus this, along each axis and anew each time, meters. For a real receiver: how
    /// it is said to err.
    pub error_m: f64,
    /// What all simulated fixes err by besides, along x, y and z, meters; the sensor does not claim to know.
    pub bias_m: [f64; 3],
    /// Share of simulated fixes that never come.
    pub dropout: f64,
    /// When the simulated receiver has no fix, such as `[{ from_s = 20.0, to_s = 50.0 }]`; it says so.
    pub outages: Vec<Outage>,
    /// Where the real receiver is, in a world that is real: a serial port such as `/dev/ttyUSB0`, or `tcp://host:port` of
    /// a bridge. Simulated and recorded worlds do not need it.
    pub port: Option<String>,
    /// Speed of the serial port, bits in a second; NMEA 0183 has 4800.
    pub baud: u32,
    /// A capture of a receiver's sentences, played whatever the world is. Its first GGA comes at the start of the run, the
    /// others as much later as their times of day say.
    pub file: Option<PathBuf>,
    /// The place on earth that is the map's origin. Without it: the receiver's first fix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<Origin>,
    /// Direction of east in the map, counter-clockwise from its x axis, degrees.
    pub rotation_deg: f64,
    /// A real fix is this old when its sentence has come, seconds.
    pub delay_s: f64,
}

/// A place on earth.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Origin {
    /// North positive, degrees of WGS-84.
    pub latitude_deg: f64,
    /// East positive, degrees of WGS-84.
    pub longitude_deg: f64,
    /// Over the geoid, meters: height 0 of the map. Without it: that of the first fix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
}

/// A time without fixes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Outage {
    /// From this time of the run on, seconds.
    pub from_s: f64,
    /// Until this time, seconds.
    pub to_s: f64,
}

impl Default for GpsParams {
    fn default() -> Self {
        Self {
            error_m: 5.0,
            bias_m: [0.0; 3],
            dropout: 0.0,
            outages: Vec::new(),
            port: None,
            baud: 4800,
            file: None,
            origin: None,
            rotation_deg: 0.0,
            delay_s: 0.0,
        }
    }
}

impl GpsParams {
    /// How a simulated receiver errs.
    pub(super) fn reception(&self) -> ReceptionModel {
        let time = Time::from_secs;
        ReceptionModel {
            error_m: self.error_m,
            bias_m: self.bias_m,
            dropout: self.dropout,
            outages: self.outages.iter().map(|outage| [time(outage.from_s), time(outage.to_s)]).collect(),
        }
    }

    /// How fixes of a real one become positions.
    pub(super) fn interpretation(&self) -> Interpretation {
        let rotation_rad = self.rotation_deg.to_radians();
        let frame =
            |origin: &Origin| LocalFrame::new(origin.latitude_deg, origin.longitude_deg, rotation_rad);
        Interpretation {
            error_m: self.error_m,
            rotation_rad,
            frame: self.origin.as_ref().map(frame),
            altitude_m: self.origin.and_then(|origin| origin.altitude_m),
        }
    }

    fn origin_faults(&self, origin: &Origin) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let Origin { latitude_deg, longitude_deg, altitude_m } = *origin;
        // At a pole there is no east.
        if latitude_deg.is_nan() || latitude_deg.abs() >= 90.0 {
            let message = format!("is {latitude_deg}, expected degrees between -90 and 90");
            faults.push(BuildError::at("origin.latitude_deg", message));
        }
        if longitude_deg.is_nan() || longitude_deg.abs() > 180.0 {
            let message = format!("is {longitude_deg}, expected degrees from -180 to 180");
            faults.push(BuildError::at("origin.longitude_deg", message));
        }
        if let Some(altitude_m) = altitude_m.filter(|altitude_m| !altitude_m.is_finite()) {
            let message = format!("is {altitude_m}, expected a finite height");
            faults.push(BuildError::at("origin.altitude_m", message));
        }
        faults
    }
}

impl Params for GpsParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        for (key, value) in [("error_m", self.error_m), ("delay_s", self.delay_s)] {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(BuildError::at(key, format!("is {value}, expected a finite number, 0 or more")));
            }
        }
        for (idx, bias_m) in self.bias_m.iter().enumerate().filter(|(_, bias_m)| !bias_m.is_finite()) {
            let message = format!("is {bias_m}, expected a finite length");
            faults.push(BuildError::at(format!("bias_m[{idx}]"), message));
        }
        if !(0.0..=1.0).contains(&self.dropout) {
            let message = format!("is {}, expected a share from 0 to 1", self.dropout);
            faults.push(BuildError::at("dropout", message));
        }
        for (idx, Outage { from_s, to_s }) in self.outages.iter().enumerate() {
            if !(from_s.is_finite() && to_s.is_finite() && from_s < to_s) {
                let message =
                    format!("is from {from_s} to {to_s}, expected two times, the earlier one first");
                faults.push(BuildError::at(format!("outages[{idx}]"), message));
            }
        }
        faults.extend(address_fault(self.port.as_deref()));
        if self.port.is_some() && self.file.is_some() {
            faults.push(BuildError::at("file", "is given, and so is port; only one of them can be read"));
        }
        if self.baud == 0 {
            faults.push(BuildError::at("baud", "is 0, expected the speed of the port, such as 4800"));
        }
        if !self.rotation_deg.is_finite() {
            let message = format!("is {}, expected a finite angle", self.rotation_deg);
            faults.push(BuildError::at("rotation_deg", message));
        }
        faults.extend(self.origin.iter().flat_map(|origin| self.origin_faults(origin)));
        faults
    }
}
