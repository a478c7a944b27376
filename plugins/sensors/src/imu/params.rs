//! What `[[sensor]] plugin = "imu"` takes.

use std::f64::consts::TAU;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::port::address_fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::device::Interpretation;
use super::noise::{AttitudeErrors, ImuNoise};

/// An inertial measurement unit: roll, pitch and yaw, turning rates and accelerations. Yaw is counter-clockwise from the
/// map's x axis.
///
/// In a simulated world it errs as the parameters below say. At a real line it reads text such as
/// `Y: -1.82 P: -0.05 R: 0.48`, from which `unit`, `sign` and `yaw_offset_deg` make a yaw in the map; such a device says
/// no rates and accelerations: rates are then differences of attitudes, and accelerations those of a robot that does not
/// speed up. A recording is passed on as it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImuParams {
    /// What the simulated yaw is off by all the time, degrees.
    pub yaw_bias_deg: f64,
    /// What it drifts by, as that of a gyroscope without a compass, degrees a minute.
    pub yaw_drift_deg_min: f64,
    /// Standard deviation of each simulated yaw, degrees.
    pub yaw_noise_deg: f64,
    /// Standard deviation of each simulated roll and pitch, degrees.
    pub tilt_noise_deg: f64,
    /// What each simulated turning rate is off by all the time, degrees a second.
    pub rate_bias_deg_s: f64,
    /// Standard deviation of each simulated turning rate, degrees a second.
    pub rate_noise_deg_s: f64,
    /// Standard deviation of each simulated acceleration, m/s².
    pub acceleration_noise_m_s2: f64,
    /// Where the real device is, in a world that is real: a serial port such as `/dev/ttyUSB0`, or `tcp://host:port` of a
    /// bridge. Simulated and recorded worlds do not need it.
    pub port: Option<String>,
    /// Speed of the serial port, bits in a second.
    pub baud: u32,
    /// What the real device's numbers are: `"deg"` or `"rad"`. It does not say so itself, and a real device needs it.
    pub unit: Option<AngleUnit>,
    /// The map's yaw when the real device says 0, degrees.
    pub yaw_offset_deg: f64,
    /// 1 where the real device's yaw grows counter-clockwise, -1 where it grows clockwise, as that of a compass.
    pub sign: i8,
    /// A real attitude is this old when its text has come, seconds.
    pub delay_s: f64,
}

/// The unit of a device's angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum AngleUnit {
    /// Degrees.
    #[serde(rename = "deg")]
    Degrees,
    /// Radians.
    #[serde(rename = "rad")]
    Radians,
}

impl AngleUnit {
    /// A full turn in this unit.
    pub fn full_turn(self) -> f64 {
        match self {
            AngleUnit::Degrees => 360.0,
            // Rounded up to the digits of the device.
            AngleUnit::Radians => TAU + 0.005,
        }
    }

    /// An angle in this unit, radians.
    pub fn to_rad(self, angle: f64) -> f64 {
        match self {
            AngleUnit::Degrees => angle.to_radians(),
            AngleUnit::Radians => angle,
        }
    }
}

impl Default for ImuParams {
    fn default() -> Self {
        Self {
            yaw_bias_deg: 0.0,
            yaw_drift_deg_min: 0.0,
            yaw_noise_deg: 0.5,
            tilt_noise_deg: 0.5,
            rate_bias_deg_s: 0.0,
            rate_noise_deg_s: 0.1,
            acceleration_noise_m_s2: 0.02,
            port: None,
            baud: 57_600,
            unit: None,
            yaw_offset_deg: 0.0,
            sign: 1,
            delay_s: 0.0,
        }
    }
}

impl ImuParams {
    /// How a simulated device errs.
    pub(super) fn noise(&self) -> ImuNoise {
        ImuNoise {
            attitude: AttitudeErrors {
                yaw_bias_rad: self.yaw_bias_deg.to_radians(),
                yaw_drift_rad_s: self.yaw_drift_deg_min.to_radians() / 60.0,
                yaw_rad: self.yaw_noise_deg.to_radians(),
                tilt_rad: self.tilt_noise_deg.to_radians(),
            },
            rate_bias_rad_s: self.rate_bias_deg_s.to_radians(),
            rate_rad_s: self.rate_noise_deg_s.to_radians(),
            acceleration_m_s2: self.acceleration_noise_m_s2,
        }
    }

    /// How a real one's numbers become an attitude; nothing where their unit is not known.
    pub(super) fn interpretation(&self) -> Option<Interpretation> {
        let offset_rad = self.yaw_offset_deg.to_radians();
        self.unit.map(|unit| Interpretation::new(unit, f64::from(self.sign), offset_rad))
    }
}

impl Params for ImuParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        for (key, value) in [
            ("yaw_bias_deg", self.yaw_bias_deg),
            ("yaw_drift_deg_min", self.yaw_drift_deg_min),
            ("rate_bias_deg_s", self.rate_bias_deg_s),
            ("yaw_offset_deg", self.yaw_offset_deg),
        ] {
            if !value.is_finite() {
                faults.push(BuildError::at(key, format!("is {value}, expected a finite number")));
            }
        }
        for (key, value) in [
            ("yaw_noise_deg", self.yaw_noise_deg),
            ("tilt_noise_deg", self.tilt_noise_deg),
            ("rate_noise_deg_s", self.rate_noise_deg_s),
            ("acceleration_noise_m_s2", self.acceleration_noise_m_s2),
            ("delay_s", self.delay_s),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(BuildError::at(key, format!("is {value}, expected a finite number, 0 or more")));
            }
        }
        faults.extend(address_fault(self.port.as_deref()));
        if self.port.is_some() && self.unit.is_none() {
            let fault = BuildError::at("unit", "is missing, expected \"deg\" or \"rad\"");
            faults.push(fault.help("turn the device by hand: the yaw of a quarter turn is 90 or 1.57"));
        }
        if self.baud == 0 {
            faults.push(BuildError::at("baud", "is 0, expected the speed of the port, such as 57600"));
        }
        if !matches!(self.sign, 1 | -1) {
            faults.push(BuildError::at("sign", format!("is {}, expected 1 or -1", self.sign)));
        }
        faults
    }
}
