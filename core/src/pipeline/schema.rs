//! The JSON schema of the whole pipeline file, from the registry: completion and documentation in editors.

use super::own_sections::{Head, OWN_SECTIONS};
use super::{Mission, PipelineTest, Reserved, Seat};
use crate::registry::{Entry, Registry};
use crate::robot::Robot;
use serde_json::{Map, Value, json};

/// Describes every pipeline file that can be written with the plugins of `registry`.
pub fn schema(registry: &Registry) -> Value {
    let mut defs = Map::new();
    let mut properties = Map::new();
    let head = hoisted(schemars::schema_for!(Head).to_value(), "head", &mut defs);
    if let Some(keys) = head.get("properties").and_then(Value::as_object) {
        properties.extend(keys.clone());
    }
    let include = json!({
        "description": "Files that this one builds on, relative to its folder; what stands here wins.",
        "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" } }],
    });
    properties.insert("include".into(), include);
    for key in OWN_SECTIONS {
        let (schema, is_list) = match key {
            "robot" => (schemars::schema_for!(Robot).to_value(), false),
            "mission" => (schemars::schema_for!(Mission).to_value(), false),
            _ => (schemars::schema_for!(PipelineTest).to_value(), true),
        };
        let schema = hoisted(schema, key, &mut defs);
        properties.insert(key.into(), if is_list { list_of(schema) } else { schema });
    }
    for seat in Seat::ALL {
        let section = section(seat, registry, &mut defs);
        let schema = match seat {
            Seat::Sensor => list_of(section),
            Seat::MapBuilder => json!({ "anyOf": [section.clone(), list_of(section)] }),
            _ => section,
        };
        properties.insert(seat.section().into(), schema);
    }
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Rumbo pipeline",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "$defs": defs,
    })
}

fn list_of(item: Value) -> Value {
    json!({ "type": "array", "items": item })
}

/// One alternative a plugin.
fn section(seat: Seat, registry: &Registry, defs: &mut Map<String, Value>) -> Value {
    let plugins: Vec<Value> =
        registry.of_stage(seat.stage()).map(|entry| plugin(seat, entry, defs)).collect();
    match plugins.is_empty() {
        true => json!({ "type": "object" }),
        false => json!({ "type": "object", "required": ["plugin"], "oneOf": plugins }),
    }
}

/// The framework's and the plugin's keys, in one table.
fn plugin(seat: Seat, entry: &Entry, defs: &mut Map<String, Value>) -> Value {
    let prefix = format!("{}_{}", entry.stage.section(), entry.name);
    let mut schema = hoisted(entry.source.schema(), &prefix, defs);
    let reserved = hoisted(Reserved::schema(seat), seat.section(), defs);
    let Some(table) = schema.as_object_mut() else { return schema };
    let properties = table.entry("properties").or_insert_with(|| json!({}));
    if let (Some(properties), Some(framework)) =
        (properties.as_object_mut(), reserved["properties"].as_object())
    {
        properties.extend(framework.clone());
        properties.insert("plugin".into(), json!({ "const": entry.name, "description": entry.summary }));
    }
    let required = table.entry("required").or_insert_with(|| json!([]));
    if let Some(required) = required.as_array_mut() {
        required.push("plugin".into());
        if seat == Seat::Sensor {
            required.push("name".into());
        }
    }
    table.insert("title".into(), format!("{} {}", seat.section(), entry.name).into());
    schema
}

/// The schema with its definitions moved to `defs`, under names that do not meet others'.
fn hoisted(mut schema: Value, prefix: &str, defs: &mut Map<String, Value>) -> Value {
    let own = schema.as_object_mut().and_then(|table| {
        table.remove("$schema");
        table.remove("$defs")
    });
    rename_references(&mut schema, prefix);
    if let Some(Value::Object(own)) = own {
        for (name, mut definition) in own {
            rename_references(&mut definition, prefix);
            defs.insert(format!("{prefix}.{name}"), definition);
        }
    }
    schema
}

fn rename_references(value: &mut Value, prefix: &str) {
    match value {
        Value::Object(table) => {
            for (key, value) in table.iter_mut() {
                match value.as_str().and_then(|text| text.strip_prefix("#/$defs/")) {
                    Some(name) if key == "$ref" => *value = format!("#/$defs/{prefix}.{name}").into(),
                    _ => rename_references(value, prefix),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| rename_references(item, prefix)),
        _ => {}
    }
}
