//! What a JSON schema says, in the terms of TOML values and of messages.

use super::node::{Node, NodeValue};
use serde_json::Value;

/// The words that a schema of fixed texts allows.
pub(super) fn words(schema: &Value) -> Option<Vec<&str>> {
    if let Some(word) = schema.get("const").and_then(Value::as_str) {
        return Some(vec![word]);
    }
    let all = schema.get("enum")?.as_array()?;
    Some(all.iter().filter_map(Value::as_str).collect())
}

/// The key whose fixed text tells the tables apart.
pub(super) fn tag_of<'s>(objects: &[&'s Value]) -> Option<&'s str> {
    let properties = objects.first()?.get("properties")?.as_object()?;
    properties.keys().map(String::as_str).find(|key| {
        objects.len() > 1 && objects.iter().all(|object| words(&object["properties"][*key]).is_some())
    })
}

/// Names of the types that a schema allows, `null` left out.
pub(super) fn types(schema: &Value) -> Vec<&str> {
    match schema.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(many)) => many.iter().filter_map(Value::as_str).filter(|t| *t != "null").collect(),
        _ => Vec::new(),
    }
}

/// The value has a type that the schema allows.
pub(super) fn has_type(node: &Node, schema: &Value) -> bool {
    let types = types(schema);
    types.is_empty()
        || types.iter().any(|name| match node.value {
            NodeValue::Table(_) => *name == "object",
            NodeValue::Array(_) => *name == "array",
            NodeValue::String(_) | NodeValue::Datetime(_) => *name == "string",
            NodeValue::Integer(_) => *name == "integer" || *name == "number",
            NodeValue::Float(_) => *name == "number",
            NodeValue::Bool(_) => *name == "boolean",
        })
}

/// What a schema asks for, in words.
pub(super) fn expected(schema: &Value) -> String {
    if let Some(words) = words(schema) {
        return words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ");
    }
    let name = |name: &&str| match *name {
        "object" => "a table",
        "array" => "a list",
        "string" => "text in quotes",
        "integer" => "a whole number",
        "number" => "a number",
        "boolean" => "true or false",
        _ => "another type",
    };
    match types(schema).as_slice() {
        [] if schema.get("oneOf").is_some() => "one of its forms".to_owned(),
        [] => "a value".to_owned(),
        types => types.iter().map(name).collect::<Vec<_>>().join(" or "),
    }
}
