//! What `[world] plugin = "sim"` takes.

use std::path::PathBuf;

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::world_file::Things;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::hardships::{Kidnap, Spin, Sway, Wheels};
use super::slip::Slip;

/// A simulated place in 2.5 dimensions: walls and objects with heights, glass, ramps and steps, doors and people.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SimParams {
    /// A TOML world file, or a map_server YAML file, relative to the pipeline's folder. Without it: an endless plain.
    pub map: Option<PathBuf>,
    /// Where the robot stands at the start.
    pub start: Start,
    /// How the wheels slip, such as `{ model = "gaussian", speed = 0.02, turn = 0.02, drift_deg_m = 0.5 }`; without it
    /// they grip.
    #[schemars(schema_with = "slip_schema")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip: Option<Box<dyn Slip>>,
    /// How the wheels take the ramps and steps of the world.
    pub wheels: Wheels,
    /// The body rolls and pitches on its wheels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sway: Option<Sway>,
    /// Somebody carries the robot away, such as `{ at_s = 30.0, to = { x_m = 1.0, y_m = 2.0, yaw_deg = 90.0 } }`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kidnap: Option<Kidnap>,
    /// When or where the wheels spin in place, such as `[{ from_s = 10.0, to_s = 15.0 }]` or
    /// `[{ area = [0.0, 0.0, 1.0, 1.0] }]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub spins: Vec<Spin>,
    /// Things that stand in the world besides, with the keys of a world file, such as
    /// `{ box = [{ center = [2.0, 1.0], size = [0.5, 0.5] }] }`; they are on no map.
    #[schemars(schema_with = "things_schema")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub add: Option<Things>,
    /// Names of boxes, ramps, steps, doors and people of the world file that are not there; maps show them as before.
    pub without: Vec<String>,
    /// Somebody who walks to and fro in front of the robot all the time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub companion: Option<Companion>,
    /// A map picture with more cells is refused.
    pub max_cells: u64,
}

/// A pose in the map.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// Along the map's x axis, meters.
    pub x_m: f64,
    /// Along the map's y axis, meters.
    pub y_m: f64,
    /// Counter-clockwise from the map's x axis, degrees.
    pub yaw_deg: f64,
}

impl Start {
    /// As a pose of the base.
    pub fn map_from_base(&self) -> Pose2 {
        pose2(self.x_m, self.y_m, self.yaw_deg.to_radians())
    }

    /// What is no number, at this key.
    pub fn faults(&self, key: &str) -> Vec<BuildError> {
        let numbers = [("x_m", self.x_m), ("y_m", self.y_m), ("yaw_deg", self.yaw_deg)];
        let wrong = numbers.into_iter().filter(|(_, value)| !value.is_finite());
        wrong
            .map(|(part, value)| {
                BuildError::at(format!("{key}.{part}"), format!("is {value}, expected a finite number"))
            })
            .collect()
    }
}

/// Somebody who keeps in front of the robot and crosses its way to and fro, also through walls: the moving object of
/// Hernández Alamilla (2005), section 8.5.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Companion {
    /// So far in front of the robot's middle, meters.
    pub ahead_m: f64,
    /// So far to both sides, meters.
    pub sway_m: f64,
    /// How fast to the sides, m/s.
    pub speed_m_s: f64,
    /// Radius, meters.
    pub radius_m: f64,
}

impl Default for Companion {
    fn default() -> Self {
        Companion { ahead_m: 1.5, sway_m: 1.0, speed_m_s: 0.5, radius_m: 0.20 }
    }
}

impl Companion {
    /// To the robot's left, meters; a function of time alone.
    pub fn left_m(&self, time_s: f64) -> f64 {
        if self.sway_m <= 0.0 {
            return 0.0;
        }
        let phase_m = (self.speed_m_s * time_s).rem_euclid(4.0 * self.sway_m);
        (2.0 * self.sway_m - phase_m).abs() - self.sway_m
    }
}

impl Default for SimParams {
    fn default() -> Self {
        Self {
            map: None,
            start: Start::default(),
            slip: None,
            wheels: Wheels::default(),
            sway: None,
            kidnap: None,
            spins: Vec::new(),
            add: None,
            without: Vec::new(),
            companion: None,
            max_cells: rumbo_kit::map_file::DEFAULT_MAX_CELLS,
        }
    }
}

fn things_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let list = || schemars::json_schema!({ "type": "array", "items": { "type": "object" } });
    schemars::json_schema!({
        "type": ["object", "null"],
        "properties": { "wall": list(), "box": list(), "ramp": list(), "step": list(), "door": list(),
            "person": list(), "mark": list() },
        "additionalProperties": false
    })
}

/// Slip models are an open family: their names and keys are known to the program that links them.
pub(crate) fn slip_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": ["object", "null"],
        "properties": { "model": { "type": "string" } },
        "required": ["model"]
    })
}

impl Params for SimParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = self.start.faults("start");
        if self.max_cells == 0 {
            faults.push(BuildError::at("max_cells", "is 0, expected at least 1"));
        }
        for fault in self.add.iter().filter_map(|things| things.read().err()).flatten() {
            faults.push(BuildError::at(format!("add.{}", fault.key), fault.message));
        }
        if let Some(companion) = &self.companion {
            let Companion { ahead_m, sway_m, speed_m_s, radius_m } = *companion;
            let numbers =
                [("ahead_m", ahead_m), ("sway_m", sway_m), ("speed_m_s", speed_m_s), ("radius_m", radius_m)];
            let bad = numbers.into_iter().filter(|(_, value)| !(value.is_finite() && *value >= 0.0));
            faults.extend(bad.map(|(key, value)| {
                BuildError::at(format!("companion.{key}"), format!("is {value}, expected 0 or more"))
            }));
        }
        for (key, message) in self.slip.iter().flat_map(|slip| slip.faults()) {
            faults.push(BuildError::at(format!("slip.{key}"), message));
        }
        faults.extend(self.wheels.faults());
        faults.extend(self.sway.iter().flat_map(Sway::faults));
        faults.extend(self.kidnap.iter().flat_map(Kidnap::faults));
        faults.extend(self.spins.iter().enumerate().flat_map(|(idx, spin)| spin.faults(idx)));
        faults
    }
}
