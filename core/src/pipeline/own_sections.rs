//! What the framework itself reads: the keys outside sections, `[robot]`, `[mission]` and `[[test]]`.

use super::libraries::PluginFile;
use super::{Mission, PipelineTest, Seat};
use crate::document::{
    Fault, FaultCode, Faults, Node, Parsed, item_path, join_path, parse_table, parse_with,
};
use crate::engine::EndReason;
use crate::registry::ParseFault;
use crate::robot::Robot;
use schemars::JsonSchema;
use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};

/// The version of the pipeline file that this program writes; it reads all up to it.
const SCHEMA_VERSION: u32 = 1;

/// The keys of a pipeline file outside its sections.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Head {
    /// What the pipeline is; the file's name where absent.
    pub name: String,
    /// Seed of every random stream.
    pub seed: u64,
    /// Version of this file's format.
    pub schema: u32,
    /// Libraries with more plugins, relative to the file's folder; folders are searched for `libNAME` of a plugin NAME.
    pub plugin_path: Vec<PluginFile>,
    /// Where to record the run, relative to the file's folder; or `true` for a file below `out/`, named after the
    /// pipeline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordTo>,
}

impl Default for Head {
    fn default() -> Self {
        Head { name: String::new(), seed: 0, schema: SCHEMA_VERSION, plugin_path: Vec::new(), record: None }
    }
}

/// Where a run is recorded.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum RecordTo {
    /// Yes, below `out/`, or no.
    Usual(bool),
    /// In this file.
    File(PathBuf),
}

impl<'de> Deserialize<'de> for RecordTo {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<RecordTo, D::Error> {
        struct Told;
        impl Visitor<'_> for Told {
            type Value = RecordTo;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a file, or true")
            }

            fn visit_bool<E>(self, is_wanted: bool) -> Result<RecordTo, E> {
                Ok(RecordTo::Usual(is_wanted))
            }

            fn visit_str<E>(self, file: &str) -> Result<RecordTo, E> {
                Ok(RecordTo::File(PathBuf::from(file)))
            }
        }
        from.deserialize_any(Told)
    }
}

/// Sections that the framework itself reads.
pub(super) const OWN_SECTIONS: [&str; 3] = ["robot", "mission", "test"];

/// Keys outside sections, and sections that nobody knows.
pub(super) fn head(root: &Node, path: &Path, faults: &mut Faults) -> Head {
    let sections: Vec<&str> = OWN_SECTIONS.into_iter().chain(Seat::ALL.map(Seat::section)).collect();
    let mut own = root.clone();
    if let Some(table) = own.as_table_mut() {
        table.retain(|key| !sections.contains(&key));
    }
    let schema = schemars::schema_for!(Head).to_value();
    let parsed = parse_with(&own, "", &schema, &sections, faults, |table| {
        serde_path_to_error::deserialize(table).map_err(|fault| ParseFault {
            path: fault.path().to_string(),
            message: fault.inner().message().to_owned(),
        })
    });
    let mut head: Head = parsed.map(|parsed| parsed.value).unwrap_or_default();
    if head.schema == 0 || head.schema > SCHEMA_VERSION {
        let message =
            format!("is {}, this program reads pipeline files of version {SCHEMA_VERSION}", head.schema);
        let place = root.nearest("schema").origin;
        faults.push(Fault::new(FaultCode::BadValue, "schema", place, message));
    }
    if head.name.is_empty() {
        head.name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    }
    head
}

/// `[robot]`, or the default robot.
pub(super) fn robot(node: Option<&Node>, faults: &mut Faults) -> Robot {
    let Some(node) = node else { return Robot::default() };
    let Some(Parsed { value, left_out }) = parse_table::<Robot>(node, "robot", faults) else {
        return Robot::default();
    };
    for (key, message) in value.faults() {
        let top = key.split('.').next().unwrap_or(&key);
        if !left_out.iter().any(|left| left == top) {
            let place = node.nearest(&key).origin;
            faults.push(Fault::new(FaultCode::BadValue, join_path("robot", &key), place, message));
        }
    }
    value
}

/// `[mission]`, or a robot that goes nowhere.
pub(super) fn mission(node: Option<&Node>, faults: &mut Faults) -> Mission {
    let Some(node) = node else { return Mission::default() };
    let Some(Parsed { value, .. }) = parse_table::<Mission>(node, "mission", faults) else {
        return Mission::default();
    };
    let follow = value.follow.as_ref();
    let above = [
        ("follow.stop_distance_m", follow.map(|follow| follow.stop_distance_m)),
        ("follow.spacing_m", follow.map(|follow| follow.spacing_m)),
        ("follow.pass_radius_m", follow.map(|follow| follow.pass_radius_m)),
        ("follow.lost_after_s", follow.map(|follow| follow.lost_after_s)),
        ("arrival_radius_m", Some(value.arrival_radius_m)),
        ("goal_timeout_s", value.goal_timeout_s),
        ("time_limit_s", Some(value.time_limit_s)),
        ("stuck_after_s", value.stuck_after_s),
        ("stuck_within_m", Some(value.stuck_within_m)),
    ];
    let at_least = [
        ("switch_radius_m", Some(value.switch_radius_m)),
        ("initial_deviation_m", Some(value.initial_deviation_m)),
        ("initial_deviation_deg", Some(value.initial_deviation_deg)),
        ("obstacle_memory_s", Some(value.obstacle_memory_s)),
        ("patience_s", Some(value.patience_s)),
    ];
    let wrong_above = above.into_iter().filter(|(_, number)| number.is_some_and(|number| number <= 0.0));
    let wrong_least = at_least.into_iter().filter(|(_, number)| number.is_some_and(|number| number < 0.0));
    let wrong =
        wrong_above.map(|wrong| (wrong, "above 0")).chain(wrong_least.map(|wrong| (wrong, "at least 0")));
    let missions = [
        ("commands", value.commands.is_some()),
        ("follow", follow.is_some()),
        ("waypoints", !value.waypoints.is_empty()),
    ];
    let mut missions = missions.into_iter().filter(|(_, is_given)| *is_given).map(|(key, _)| key);
    if let (Some(first), Some(second)) = (missions.next(), missions.next()) {
        let message = format!("stands beside {second}; a mission has the one or the other");
        let place = node.nearest(first).origin;
        faults.push(Fault::new(FaultCode::BadValue, join_path("mission", first), place, message));
    }
    for ((key, number), expected) in wrong {
        let message = format!("is {}, expected {expected}", number.unwrap_or_default());
        let place = node.nearest(key).origin;
        faults.push(Fault::new(FaultCode::BadValue, join_path("mission", key), place, message));
    }
    value
}

/// One `[[test]]`.
pub(super) fn test(node: &Node, idx: usize, faults: &mut Faults) -> Option<PipelineTest> {
    let path = item_path("test", idx, node);
    let test = parse_table::<PipelineTest>(node, &path, faults)?.value;
    if let Some(reason) = &test.expect.reason
        && toml::Value::String(reason.clone()).try_into::<EndReason>().is_err()
    {
        let place = node.nearest("expect.reason").origin;
        let message =
            format!("is \"{reason}\", which is no end of a run; expected arrived, unreachable, ...");
        faults.push(Fault::new(FaultCode::BadValue, format!("{path}.expect.reason"), place, message));
    }
    Some(test)
}
