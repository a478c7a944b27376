//! `--swap planner=dp,a_star`: the alternatives that are compared.

use super::study::Named;
use crate::load::did_you_mean;
use rumbo_core::document::FaultCode;
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::Registry;
use serde_json::Value;
use std::path::Path;

/// One part of the pipeline and the plugins that take its place in turn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Swap {
    /// The section: `planner`, `sensor.front_laser`.
    pub section: String,
    /// At least one, each once.
    pub plugins: Vec<String>,
}

/// One choice of plugins.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Alternative {
    /// Section and plugin, in the order of the swaps.
    pub choices: Vec<(String, String)>,
    /// Its name in a study, and what it changes besides.
    pub named: Option<Named>,
}

impl Alternative {
    /// `planner=dp localizer=odometry`, or `as it is`.
    pub fn name(&self) -> String {
        let name = self.named.iter().map(|named| named.name.clone());
        let choices = self.choices.iter().map(|(section, plugin)| format!("{section}={plugin}"));
        let words: Vec<String> = name.chain(choices).collect();
        if words.is_empty() { "as it is".to_owned() } else { words.join(" ") }
    }

    /// As arguments of `--set`.
    pub fn sets(&self) -> Vec<String> {
        let plugins = self.choices.iter().map(|(section, plugin)| format!("{section}.plugin={plugin:?}"));
        let others = self.named.iter().flat_map(|named| named.set.iter().cloned());
        plugins.chain(others).collect()
    }
}

/// Reads `SECTION=PLUGIN,PLUGIN`.
pub fn parse(text: &str) -> Result<Swap, String> {
    let shape = "expected SECTION=PLUGIN,PLUGIN, such as planner=dp,a_star";
    let (section, list) = text.split_once('=').ok_or_else(|| format!("`{text}` has no `=`, {shape}"))?;
    let plugins: Vec<String> = list.split(',').map(|name| name.trim().to_owned()).collect();
    let section = section.trim().to_owned();
    if section.is_empty() || plugins.iter().any(String::is_empty) {
        return Err(format!("`{text}` has an empty name, {shape}"));
    }
    for (idx, name) in plugins.iter().enumerate() {
        if plugins.iter().take(idx).any(|other| other == name) {
            return Err(format!("`{text}` names {name} twice"));
        }
    }
    Ok(Swap { section, plugins })
}

/// Every combination, the last swap changing fastest; with each of the named ones, if there are any.
pub fn alternatives(swaps: &[Swap], named: &[Named]) -> Vec<Alternative> {
    let with_name = |named: &Named| Alternative { named: Some(named.clone()), choices: Vec::new() };
    let mut all: Vec<Alternative> = named.iter().map(with_name).collect();
    if all.is_empty() {
        all.push(Alternative::default());
    }
    for swap in swaps {
        let with = |alternative: &Alternative, plugin: &String| {
            let mut longer = alternative.clone();
            longer.choices.push((swap.section.clone(), plugin.clone()));
            longer
        };
        all = all.iter().flat_map(|a| swap.plugins.iter().map(move |plugin| with(a, plugin))).collect();
    }
    all
}

/// Refuses sections that the pipeline (its effective form) does not have and plugins that nobody has.
pub fn check(
    swaps: &[Swap],
    effective: &Value,
    base: (&Path, &[String]),
    registry: &Registry,
) -> Result<(), String> {
    let parts = parts(effective);
    for (idx, swap) in swaps.iter().enumerate() {
        let section = &swap.section;
        if !parts.contains(section) {
            let hint = did_you_mean(section, parts.iter().map(String::as_str));
            return Err(format!(
                "--swap {section}: the pipeline has no such part{hint}; it has {}",
                parts.join(", ")
            ));
        }
        if swaps.iter().take(idx).any(|other| other.section == *section) {
            return Err(format!("--swap {section} stands twice, name all its plugins in one"));
        }
        for plugin in &swap.plugins {
            let mut sets = base.1.to_vec();
            sets.push(format!("{section}.plugin={plugin:?}"));
            let loaded = Loaded::read(base.0, &sets, registry);
            let path = format!("{section}.plugin");
            if let Some(fault) = loaded
                .faults
                .iter()
                .find(|fault| fault.code == FaultCode::UnknownPlugin && fault.path == path)
            {
                return Err(format!("--swap {section}={plugin}: {}", fault.message));
            }
        }
    }
    Ok(())
}

/// Sections with a plugin.
fn parts(effective: &Value) -> Vec<String> {
    let mut parts = Vec::new();
    for (key, value) in effective.as_object().into_iter().flatten() {
        let has_plugin = |value: &Value| value.get("plugin").is_some();
        if has_plugin(value) {
            parts.push(key.clone());
        }
        for (idx, item) in value.as_array().into_iter().flatten().enumerate().filter(|(_, v)| has_plugin(v)) {
            let name = item.get("name").and_then(Value::as_str).map_or(idx.to_string(), str::to_owned);
            parts.push(format!("{key}.{name}"));
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swaps_multiply_and_the_last_one_changes_fastest() {
        let swaps =
            [parse("planner=dp, a_star").unwrap(), parse("localizer=odometry,particle_filter").unwrap()];
        let names: Vec<String> = alternatives(&swaps, &[]).iter().map(Alternative::name).collect();
        assert_eq!(
            names,
            [
                "planner=dp localizer=odometry",
                "planner=dp localizer=particle_filter",
                "planner=a_star localizer=odometry",
                "planner=a_star localizer=particle_filter"
            ]
        );
        assert_eq!(alternatives(&[], &[])[0].name(), "as it is");
    }

    #[test]
    fn a_swap_without_names_is_refused_with_an_example() {
        for text in ["planner", "planner=", "=dp", "planner=dp,,a_star"] {
            assert!(parse(text).unwrap_err().contains("planner=dp,a_star"), "{text}");
        }
        assert!(parse("planner=dp,dp").unwrap_err().contains("twice"));
    }
}
