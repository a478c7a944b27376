//! A plugin's parameters as rows, read from its schema.

use rumbo_core::registry::Entry;
use serde::Serialize;
use serde_json::Value;

/// One key of a plugin's section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Full key below the section, such as `noise.range_m`.
    pub key: String,
    /// What it takes, in words.
    pub takes: String,
    /// The unit, by the key's ending.
    pub unit: Option<&'static str>,
    /// Its default as TOML; none where the key may be absent or must be given.
    pub default: Option<String>,
    /// What it does.
    pub description: String,
}

/// Endings of keys, longest first, and what they mean.
const UNITS: [(&str, &str); 15] = [
    ("_deg_s2", "°/s²"),
    ("_rad_s2", "rad/s²"),
    ("_deg_s", "°/s"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_deg_m", "°/m"),
    ("_per_s", "1/s"),
    ("_m_s", "m/s"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_px", "pixels"),
    ("_m", "m"),
    ("_s", "s"),
];

/// All parameters of a plugin, in the order of its schema.
pub fn parameters(entry: &Entry) -> Vec<Parameter> {
    let schema = entry.source.schema();
    let defaults = entry.source.defaults();
    let mut rows = Vec::new();
    collect(&schema, &schema, "", &defaults, &mut rows);
    rows
}

/// The plugin's own description.
pub fn description(entry: &Entry) -> String {
    let schema = entry.source.schema();
    schema.get("description").and_then(Value::as_str).unwrap_or_default().to_owned()
}

fn collect(root: &Value, schema: &Value, prefix: &str, defaults: &toml::Table, rows: &mut Vec<Parameter>) {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return };
    for (name, property) in properties {
        let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        let target = resolve(root, property);
        let text = |value: &Value| value.get("description").and_then(Value::as_str).map(str::to_owned);
        let inner = defaults.get(name).and_then(toml::Value::as_table);
        let is_table = target.get("properties").is_some_and(|p| p.as_object().is_some_and(|p| p.len() > 1));
        if let Some(inner) = inner.filter(|_| is_table) {
            collect(root, target, &key, inner, rows);
            continue;
        }
        rows.push(Parameter {
            takes: takes(root, property),
            unit: unit(name),
            default: defaults.get(name).map(inline),
            description: text(property).or_else(|| text(target)).unwrap_or_default(),
            key,
        });
    }
}

/// Follows `$ref`, also inside `anyOf` with null.
pub fn resolve<'v>(root: &'v Value, schema: &'v Value) -> &'v Value {
    if let Some(path) = schema.get("$ref").and_then(Value::as_str) {
        let found = path.strip_prefix('#').and_then(|pointer| root.pointer(pointer));
        return found.map_or(schema, |found| resolve(root, found));
    }
    let choices = schema.get("anyOf").and_then(Value::as_array);
    let real = choices.and_then(|c| c.iter().find(|s| s.get("type").is_none_or(|kind| kind != "null")));
    real.map_or(schema, |real| resolve(root, real))
}

fn takes(root: &Value, property: &Value) -> String {
    let schema = resolve(root, property);
    let words =
        |values: Vec<&Value>| values.into_iter().map(Value::to_string).collect::<Vec<_>>().join(" or ");
    if let Some(choices) = schema.get("enum").and_then(Value::as_array) {
        return words(choices.iter().collect());
    }
    if let Some(choices) = schema.get("oneOf").and_then(Value::as_array) {
        let named: Vec<&Value> = choices.iter().filter_map(|choice| choice.get("const")).collect();
        if named.len() == choices.len() {
            return words(named);
        }
    }
    let kind = match schema.get("type") {
        Some(Value::String(kind)) => kind.clone(),
        Some(Value::Array(kinds)) => {
            kinds.iter().filter_map(Value::as_str).find(|kind| *kind != "null").unwrap_or("value").to_owned()
        }
        _ => "value".to_owned(),
    };
    match kind.as_str() {
        "number" => "number".into(),
        "integer" => "whole number".into(),
        "boolean" => "true or false".into(),
        "string" => "text".into(),
        "array" => {
            let item = schema.get("items").map(|item| takes(root, item)).unwrap_or_else(|| "value".into());
            format!("list of {item}")
        }
        "object" => "table".into(),
        other => other.to_owned(),
    }
}

fn unit(key: &str) -> Option<&'static str> {
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, unit)| *unit)
}

/// A value as TOML on one line.
pub fn inline(value: &toml::Value) -> String {
    match value {
        toml::Value::Table(table) => {
            let pairs: Vec<String> =
                table.iter().map(|(key, value)| format!("{key} = {}", inline(value))).collect();
            if pairs.is_empty() { "{}".into() } else { format!("{{ {} }}", pairs.join(", ")) }
        }
        toml::Value::Array(items) => {
            format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::registry::{Registry, Stage};

    #[test]
    fn every_parameter_of_every_plugin_says_what_it_does_and_takes() {
        for entry in Registry::linked().unwrap().iter() {
            for row in parameters(entry) {
                assert!(!row.description.is_empty(), "{}.{}: write a doc comment", entry.name, row.key);
                assert_ne!(row.takes, "value", "{}.{}", entry.name, row.key);
            }
        }
    }

    #[test]
    fn the_rows_of_the_scanner_have_units_and_defaults() {
        let registry = Registry::linked().unwrap();
        let rows = parameters(registry.get(Stage::Sensor, "laser_2d").unwrap());
        let row = rows.iter().find(|row| row.key == "field_of_view_deg").unwrap();
        assert_eq!((row.unit, row.default.as_deref()), (Some("°"), Some("270.0")));
        assert_eq!(row.takes, "number");
    }

    #[test]
    fn longer_endings_win() {
        assert_eq!(unit("max_turn_accel_deg_s2"), Some("°/s²"));
        assert_eq!((unit("drift_deg_m"), unit("gain_per_s")), (Some("°/m"), Some("1/s")));
        assert_eq!((unit("speed_m_s"), unit("radius_m"), unit("n_beams")), (Some("m/s"), Some("m"), None));
    }
}
