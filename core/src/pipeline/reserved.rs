//! The framework's keys of a section.

use super::{Rate, Seat};
use crate::document::{Fault, FaultCode, Faults, Node, RESERVED_KEYS, parse_with};
use crate::registry::ParseFault;
use crate::time::Span;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::PathBuf;

/// A stage cannot run more often, times a second: the schedule counts nanoseconds.
const MAX_RATE_HZ: f64 = 10_000.0;
/// The slowest control that is still control, times a second.
const MIN_CONTROL_HZ: f64 = 1.0;

/// Where a sensor sits.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mount {
    /// The frame that the numbers are in: `base_link`, or the name of another sensor that this one sits on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Forward, meters.
    pub x_m: f64,
    /// To the left, meters.
    pub y_m: f64,
    /// Up, meters.
    pub z_m: f64,
    /// Turn about the x axis, degrees.
    pub roll_deg: f64,
    /// Turn about the y axis, degrees; positive looks down.
    pub pitch_deg: f64,
    /// Turn about the z axis, degrees; positive looks left.
    pub yaw_deg: f64,
}

/// The framework's keys of a section; every other key is the plugin's.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Reserved {
    /// Name of the plugin.
    pub plugin: String,
    /// Name of this part.
    pub name: Option<String>,
    /// Where the sensor sits.
    pub mount: Mount,
    /// How often it runs, times a second.
    pub rate_hz: Option<f64>,
    /// How often it runs: once in so many seconds.
    pub every_s: Option<f64>,
    /// Sensors that this virtual sensor derives its observations from.
    pub inputs: Vec<String>,
    /// Virtual time that slow work in the background takes, seconds.
    pub latency_s: f64,
    /// Keys that a swap to another plugin takes, by the plugin's name.
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Map<String, Value>>")]
    pub variants: toml::Table,
    /// End of a run without a mission, seconds of the world's time.
    pub duration_s: Option<f64>,
    /// A state that `rumbo run --save-state` wrote, relative to the pipeline's folder: the map begins as it was, and the
    /// robot stands where it stood, unless `mission.initial_pose` says where it is now.
    pub resume: Option<PathBuf>,
}

impl Reserved {
    /// The schema of the keys that mean something in this seat.
    pub fn schema(seat: Seat) -> Value {
        let mut schema = schemars::schema_for!(Reserved).to_value();
        if let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) {
            properties.retain(|key, _| seat.reserved_keys().contains(&key.as_str()));
        }
        schema
    }

    /// Reads the framework's keys of a section, and refuses those that mean nothing there.
    pub fn parse(seat: Seat, node: &Node, path: &str, faults: &mut Faults) -> Reserved {
        let mut framework = node.clone();
        if let Some(table) = framework.as_table_mut() {
            table.retain(|key| seat.reserved_keys().contains(&key));
        }
        for (key, value) in node.as_table().into_iter().flat_map(|table| table.iter()) {
            if RESERVED_KEYS.contains(&key) && !seat.reserved_keys().contains(&key) {
                let message = format!("means nothing in [{}], remove it", seat.section());
                faults.push(Fault::new(
                    FaultCode::UnknownKey,
                    format!("{path}.{key}"),
                    value.place(),
                    message,
                ));
            }
        }
        let parsed = parse_with(&framework, path, &Reserved::schema(seat), &[], faults, |table| {
            serde_path_to_error::deserialize(table).map_err(|fault| ParseFault {
                path: fault.path().to_string(),
                message: fault.inner().message().to_owned(),
            })
        });
        let reserved: Reserved = parsed.map(|parsed| parsed.value).unwrap_or_default();
        Numbers { node, path, faults }.check(seat, &reserved);
        reserved
    }

    /// How often it runs, if the file says so and it makes sense.
    pub fn rate(&self) -> Option<Rate> {
        let sane = |number: &f64| *number > 0.0 && number.is_finite();
        let hz = self.rate_hz.filter(|hz| sane(hz) && *hz <= MAX_RATE_HZ).map(Rate::Hz);
        hz.or(self.every_s.filter(sane).map(Rate::Every))
    }

    /// Time that slow work takes.
    pub fn latency(&self) -> Span {
        Span::from_secs(self.latency_s.max(0.0))
    }
}

struct Numbers<'a> {
    node: &'a Node,
    path: &'a str,
    faults: &'a mut Faults,
}

impl Numbers<'_> {
    fn refuse(&mut self, code: FaultCode, key: &str, message: String) {
        let place = self.node.nearest(key).origin;
        self.faults.push(Fault::new(code, format!("{}.{key}", self.path), place, message));
    }

    fn check(&mut self, seat: Seat, reserved: &Reserved) {
        if let Some(hz) = reserved.rate_hz
            && !(hz > 0.0 && hz <= MAX_RATE_HZ)
        {
            let message = format!("is {hz}, expected above 0 and at most {MAX_RATE_HZ}");
            self.refuse(FaultCode::Rate, "rate_hz", message);
        }
        if let Some(seconds) = reserved.every_s
            && seconds < 1.0 / MAX_RATE_HZ
        {
            let message = format!("is {seconds}, expected at least {}", 1.0 / MAX_RATE_HZ);
            self.refuse(FaultCode::Rate, "every_s", message);
        }
        if reserved.rate_hz.is_some() && reserved.every_s.is_some() {
            self.refuse(FaultCode::Rate, "every_s", "says again what rate_hz says, keep one of them".into());
        }
        if let (Seat::Avoider, Some(rate)) = (seat, reserved.rate())
            && rate.hz() < MIN_CONTROL_HZ
        {
            let key = if reserved.rate_hz.is_some() { "rate_hz" } else { "every_s" };
            let message =
                format!("makes {:.3} commands a second, expected at least {MIN_CONTROL_HZ}", rate.hz());
            self.refuse(FaultCode::Rate, key, message);
        }
        if reserved.latency_s < 0.0 {
            self.refuse(
                FaultCode::BadValue,
                "latency_s",
                format!("is {}, expected at least 0", reserved.latency_s),
            );
        }
        if let Some(seconds) = reserved.duration_s
            && seconds <= 0.0
        {
            self.refuse(FaultCode::BadValue, "duration_s", format!("is {seconds}, expected above 0"));
        }
    }
}
