//! From a section of the file to a stage: which plugin, how often, with which parameters.

use super::reserved::Reserved;
use super::{Seat, StageSpec};
use crate::document::{Fault, FaultCode, Faults, Node, RESERVED_KEYS, did_you_mean, join_path, parse_with};
use crate::registry::{Configured, Entry, Manifest, Registry, Stage};
use crate::stages::BuildError;
use serde_json::Value;
use std::sync::Arc;

/// A section, as far as it can be understood.
#[derive(Debug, Clone)]
pub(super) struct Section {
    /// Where it sits.
    pub seat: Seat,
    /// Its path in messages: `planner`, `sensor.front_laser`.
    pub path: String,
    /// The section with the keys of the variant that applies.
    pub node: Node,
    /// The framework's keys.
    pub reserved: Reserved,
    /// The stage; none where the plugin or a key that it cannot do without is wrong.
    pub spec: Option<StageSpec>,
    /// Nothing was wrong.
    pub is_sound: bool,
}

impl Section {
    /// Reads a section. `name` is that of the instance.
    pub fn parse(
        seat: Seat,
        name: &str,
        path: String,
        node: &Node,
        registry: &Registry,
        faults: &mut Faults,
    ) -> Section {
        let n_before = faults.len();
        let mut section = Section {
            seat,
            is_sound: !faults.any_below(&path),
            path,
            node: node.clone(),
            reserved: Reserved::default(),
            spec: None,
        };
        if node.as_table().is_some() {
            section.fill(name, registry, faults);
        } else {
            let message = format!("is {}, expected a table with the key plugin", node.shown());
            faults.push(Fault::new(FaultCode::WrongType, section.path.clone(), node.origin, message));
        }
        section.check_rate(faults);
        section.is_sound &= faults.len() == n_before;
        section
    }

    fn fill(&mut self, name: &str, registry: &Registry, faults: &mut Faults) {
        let seat = self.seat;
        self.reserved = Reserved::parse(seat, &self.node, &self.path, faults);
        variants(seat, &self.node, &self.path, registry, faults);
        let Some(entry) = plugin(seat, &self.node, &self.path, registry, faults) else { return };
        take_variant(&mut self.node, &entry.name);
        let configured = configured(&entry, &self.node, &self.path, seat.reserved_keys(), registry, faults);
        self.spec = configured.map(|configured| StageSpec {
            name: name.to_owned(),
            entry,
            configured,
            rate: self.reserved.rate(),
            latency: self.reserved.latency(),
        });
    }

    /// What the plugin needs and gives.
    pub fn manifest(&self) -> Option<Manifest> {
        self.spec.as_ref().map(StageSpec::manifest)
    }

    /// A fault of the whole section, shown at the name of its plugin.
    pub fn fault(&self, code: FaultCode, message: impl Into<String>) -> Fault {
        let place = self.node.get("plugin").map_or(self.node.place(), |plugin| plugin.origin);
        Fault::new(code, self.path.clone(), place, message)
    }

    /// A fault that a plugin found in its own keys.
    pub fn plugin_fault(&self, error: &BuildError) -> Fault {
        plugin_fault(&self.node, &self.path, error)
    }

    fn check_rate(&self, faults: &mut Faults) {
        let most = self.manifest().and_then(|manifest| manifest.max_rate_hz);
        let (Some(most), Some(rate)) = (most, self.reserved.rate()) else { return };
        // A rate given as 1/37.5 s is the device's rate all the same.
        if rate.hz() > most * (1.0 + 1e-9) {
            let message = format!("asks for {} a second, but the device gives at most {most}", rate.hz());
            faults.push(self.rate_fault(message));
        }
    }

    /// A fault of the section's rate, in whichever key it is given.
    pub fn rate_fault(&self, message: String) -> Fault {
        let key = if self.reserved.every_s.is_some() { "every_s" } else { "rate_hz" };
        Fault::new(FaultCode::Rate, join_path(&self.path, key), self.node.nearest(key).origin, message)
    }
}

fn plugin_fault(node: &Node, path: &str, error: &BuildError) -> Fault {
    let found = node.nearest(&error.path);
    let place = match (error.path.is_empty(), node.get("plugin")) {
        (true, Some(plugin)) => plugin.origin,
        // The key is not there: the default is what is wrong, and the section is the place to say otherwise.
        _ if found == node => node.place(),
        _ => found.origin,
    };
    let fault = Fault::new(FaultCode::Plugin, join_path(path, &error.path), place, error.message.clone());
    match &error.help {
        Some(help) => fault.help(help.clone()),
        None => fault,
    }
}

/// The entry that the key `plugin` names.
fn plugin(
    seat: Seat,
    node: &Node,
    path: &str,
    registry: &Registry,
    faults: &mut Faults,
) -> Option<Arc<Entry>> {
    let path = join_path(path, "plugin");
    let names: Vec<&str> = registry.of_stage(seat.stage()).map(|entry| entry.name.as_str()).collect();
    let Some(plugin) = node.get("plugin") else {
        let message = format!("is missing, expected {}", one_of(&names));
        faults.push(Fault::new(FaultCode::MissingKey, path, node.place(), message));
        return None;
    };
    let name = plugin.as_str()?;
    if let Some(entry) = registry.get(seat.stage(), name) {
        return Some(entry.clone());
    }
    let message = unknown_plugin(seat.stage(), name, &names, registry);
    let elsewhere =
        "a plugin from elsewhere comes with its library: `plugin_path = [\"FILE\"]`, or --plugin FILE";
    let fault = Fault::new(FaultCode::UnknownPlugin, path, plugin.origin, message);
    // A mistyped name needs no library.
    let is_mistyped = did_you_mean(name, names.iter().copied()).is_some();
    faults.push(if is_mistyped { fault } else { fault.help(elsewhere) });
    None
}

fn unknown_plugin(stage: Stage, name: &str, names: &[&str], registry: &Registry) -> String {
    let seat = stage.section();
    if let Some(other) = registry.iter().find(|entry| entry.name == name) {
        return format!(
            "`{name}` is for [{}], not for [{seat}]; expected {}",
            other.stage.section(),
            one_of(names)
        );
    }
    match did_you_mean(name, names.iter().copied()) {
        Some(close) => format!("no {seat} is called `{name}`, did you mean {close}?"),
        None => format!("no {seat} is called `{name}`, expected {}", one_of(names)),
    }
}

fn one_of(names: &[&str]) -> String {
    match names {
        [] => "a plugin, but this program has none for this section".to_owned(),
        names => format!("one of {}", names.join(", ")),
    }
}

/// Lays the keys of the variant for `plugin` below the section's own.
fn take_variant(node: &mut Node, plugin: &str) {
    let variant = node.get("variants").and_then(|variants| variants.get(plugin)).cloned();
    let (Some(variant), Some(table)) = (variant, node.as_table_mut()) else { return };
    for (key, value) in variant.as_table().into_iter().flat_map(|variant| variant.iter()) {
        if table.get(key).is_none() && !RESERVED_KEYS.contains(&key) {
            table.set(key, value.clone());
        }
    }
}

/// Every variant must be one that its plugin takes, not only the one that applies.
fn variants(seat: Seat, node: &Node, path: &str, registry: &Registry, faults: &mut Faults) {
    let Some(variants) = node.get("variants").and_then(Node::as_table) else { return };
    let active = node.get("plugin").and_then(Node::as_str);
    for (name, variant) in variants.iter() {
        let path = join_path(path, &format!("variants.{name}"));
        let Some(entry) = registry.get(seat.stage(), name) else {
            let names: Vec<&str> = registry.of_stage(seat.stage()).map(|entry| entry.name.as_str()).collect();
            let message = unknown_plugin(seat.stage(), name, &names, registry);
            faults.push(Fault::new(FaultCode::UnknownPlugin, path, variant.place(), message));
            continue;
        };
        if active != Some(name) {
            configured(entry, variant, &path, &[], registry, faults);
        }
    }
}

/// The plugin with its parameters.
fn configured(
    entry: &Entry,
    node: &Node,
    path: &str,
    also_known: &[&str],
    registry: &Registry,
    faults: &mut Faults,
) -> Option<Arc<dyn Configured>> {
    let mut own = node.clone();
    if let Some(table) = own.as_table_mut() {
        table.retain(|key| !RESERVED_KEYS.contains(&key));
    }
    let schema = entry.source.schema();
    take_foreign_keys(&mut own, entry, &schema, path, registry, faults);
    let parsed = parse_with(&own, path, &schema, also_known, faults, |keys| entry.source.parse(keys))?;
    let known = faults.clone();
    for error in parsed.value.check() {
        let fault = plugin_fault(node, path, &error);
        // A key that has a fault already has its default here, and whatever is wrong with that is not the user's.
        if error.path.is_empty() || !known.any_below(&fault.path) {
            faults.push(fault);
        }
    }
    Some(parsed.value.into())
}

/// Keys that another plugin of this stage has: what is left behind when somebody changes only the plugin's name.
fn take_foreign_keys(
    own: &mut Node,
    entry: &Entry,
    schema: &Value,
    path: &str,
    registry: &Registry,
    faults: &mut Faults,
) {
    let has = |schema: &Value, key: &str| schema.get("properties").is_some_and(|all| all.get(key).is_some());
    let Some(table) = own.as_table_mut() else { return };
    let mut foreign = Vec::new();
    for (key, node) in table.iter().filter(|(key, _)| !has(schema, key)) {
        let mut others = registry.of_stage(entry.stage).filter(|other| other.name != entry.name);
        let Some(other) = others.find(|other| has(&other.source.schema(), key)) else { continue };
        let message = format!("unknown key, {} has it, {} does not", other.name, entry.name);
        let fault = Fault::new(FaultCode::UnknownKey, join_path(path, key), node.place(), message);
        let section = path.split('.').next().unwrap_or(path);
        faults.push(match path == section {
            true => {
                fault.help(format!("a section [{section}.variants.{}] keeps its keys for a swap", other.name))
            }
            false => fault,
        });
        foreign.push(key.to_owned());
    }
    table.retain(|key| !foreign.iter().any(|other| other == key));
}
