//! Does a value have the shape that a JSON schema describes? Everything that is wrong with it, each at its place.
//!
//! A deserializer stops at the first fault; this walk does not. It knows the part of JSON Schema (draft 2020-12) that
//! schemas derived from structs use.

use super::fault::{Fault, FaultCode, Faults};
use super::node::{Node, NodeValue, Table, item_path, join_path};
use super::schema_terms::{expected, has_type, tag_of, types, words};
use super::suggest::{did_you_mean, unknown_key_message};
use serde_json::Value;

/// References in a schema may lead on so often.
const MAX_REFERENCES: usize = 32;

/// Walks values and schema side by side.
pub(super) struct Shape<'s> {
    /// The whole schema, where `$ref` leads to.
    pub schema: &'s Value,
    /// Keys that are fine at the top, though the schema does not know them, and are suggested.
    pub also_known: &'s [&'s str],
}

impl<'s> Shape<'s> {
    /// Everything that is wrong with `node` at `path`.
    pub fn check(&self, node: &Node, path: &str) -> Faults {
        let mut faults = Faults::default();
        Walk { shape: self, faults: &mut faults, top: path }.value(node, self.schema, path);
        faults
    }

    fn resolved(&self, schema: &'s Value) -> &'s Value {
        let mut schema = schema;
        for _ in 0..MAX_REFERENCES {
            let Some(pointer) = schema.get("$ref").and_then(Value::as_str) else { break };
            match pointer.strip_prefix('#').and_then(|pointer| self.schema.pointer(pointer)) {
                Some(next) => schema = next,
                None => break,
            }
        }
        schema
    }

    /// The ways in which a value may look, `null` left out: TOML says it by leaving out the key.
    fn alternatives(&self, schema: &'s Value) -> Option<Vec<&'s Value>> {
        let list = schema.get("oneOf").or_else(|| schema.get("anyOf"))?.as_array()?;
        let all = list.iter().map(|one| self.resolved(one));
        let mut flat = Vec::new();
        for one in all.filter(|one| one.get("type").and_then(Value::as_str) != Some("null")) {
            match self.alternatives(one) {
                Some(deeper) => flat.extend(deeper),
                None => flat.push(one),
            }
        }
        Some(flat)
    }
}

struct Walk<'w, 's> {
    shape: &'w Shape<'s>,
    faults: &'w mut Faults,
    top: &'w str,
}

impl<'s> Walk<'_, 's> {
    fn value(&mut self, node: &Node, schema: &'s Value, path: &str) {
        let schema = self.shape.resolved(schema);
        if let Some(alternatives) = self.shape.alternatives(schema) {
            return self.one_of(node, &alternatives, path);
        }
        for part in schema.get("allOf").and_then(Value::as_array).into_iter().flatten() {
            self.value(node, part, path);
        }
        if let Some(words) = words(schema) {
            return self.word(node, &words, path);
        }
        if !has_type(node, schema) {
            return self.wrong_type(node, &expected(schema), path);
        }
        match &node.value {
            NodeValue::Table(table) => self.table(node, table, schema, path),
            NodeValue::Array(items) => self.array(node, items, schema, path),
            NodeValue::Integer(number) => self.range(node, *number as f64, schema, path),
            NodeValue::Float(number) => self.range(node, *number, schema, path),
            _ => {}
        }
    }

    fn wrong_type(&mut self, node: &Node, expected: &str, path: &str) {
        let message = format!("is {}, expected {expected}", node.shown());
        self.faults.push(Fault::new(FaultCode::WrongType, path, node.origin, message));
    }

    fn one_of(&mut self, node: &Node, alternatives: &[&'s Value], path: &str) {
        let all_words: Option<Vec<&str>> =
            alternatives.iter().map(|one| words(one)).collect::<Option<Vec<_>>>().map(|all| all.concat());
        if let Some(all_words) = all_words {
            return self.word(node, &all_words, path);
        }
        let objects: Vec<&Value> =
            alternatives.iter().copied().filter(|one| one.get("properties").is_some()).collect();
        if let (Some(table), Some(tag)) = (node.as_table(), tag_of(&objects)) {
            return self.tagged(node, table, &objects, tag, path);
        }
        let is_free_text = |one: &&Value| words(one).is_none() && types(one).contains(&"string");
        if node.as_str().is_some() && !alternatives.iter().any(is_free_text) {
            let some: Vec<&str> = alternatives.iter().filter_map(|one| words(one)).flatten().collect();
            if !some.is_empty() {
                return self.word(node, &some, path);
            }
        }
        let mut best: Option<Faults> = None;
        for one in alternatives {
            let mut found = Faults::default();
            Walk { shape: self.shape, faults: &mut found, top: self.top }.value(node, one, path);
            if found.is_empty() {
                return;
            }
            let fits = words(one).map_or_else(|| has_type(node, one), |_| node.as_str().is_some());
            if fits && best.as_ref().is_none_or(|best| found.len() < best.len()) {
                best = Some(found);
            }
        }
        match best {
            Some(found) => self.faults.extend(found),
            None => {
                let ways: Vec<String> = alternatives.iter().map(|one| expected(one)).collect();
                self.wrong_type(node, &ways.join(" or "), path);
            }
        }
    }

    fn word(&mut self, node: &Node, words: &[&str], path: &str) {
        let Some(found) = node.as_str() else {
            return self.wrong_type(node, &format!("one of {}", words.join(", ")), path);
        };
        if words.contains(&found) {
            return;
        }
        let mut message = format!("is \"{found}\", expected one of {}", words.join(", "));
        if let Some(close) = did_you_mean(found, words.iter().copied()) {
            message = format!("is \"{found}\", did you mean {close}?");
        }
        self.faults.push(Fault::new(FaultCode::BadValue, path, node.origin, message));
    }

    /// A table that says by one key which kind of table it is.
    fn tagged(&mut self, node: &Node, table: &Table, objects: &[&'s Value], tag: &str, path: &str) {
        let tag_path = join_path(path, tag);
        let word_of = |object: &'s Value| words(&object["properties"][tag]).unwrap_or_default();
        let all: Vec<&str> = objects.iter().copied().flat_map(word_of).collect();
        let Some(found) = table.get(tag) else {
            let message = format!("is missing, expected one of {}", all.join(", "));
            self.faults.push(Fault::new(FaultCode::MissingKey, tag_path, node.place(), message));
            return;
        };
        let chosen =
            objects.iter().find(|object| found.as_str().is_some_and(|word| word_of(object).contains(&word)));
        match chosen {
            Some(object) => self.table(node, table, object, path),
            None => self.word(found, &all, &tag_path),
        }
    }

    fn table(&mut self, node: &Node, table: &Table, schema: &'s Value, path: &str) {
        let properties = schema.get("properties").and_then(Value::as_object);
        let property = |key: &str| -> Option<&'s Value> { properties?.get(key) };
        let others = schema.get("additionalProperties");
        let also_known = if path == self.top { self.shape.also_known } else { &[] };
        for (key, value) in table.iter() {
            let key_path = join_path(path, key);
            match (property(key), others) {
                (Some(schema), _) => self.value(value, schema, &key_path),
                (None, Some(Value::Bool(false))) if !also_known.contains(&key) => {
                    let known = properties.into_iter().flat_map(|all| all.keys()).map(String::as_str);
                    let message = unknown_key_message(key, known.chain(also_known.iter().copied()));
                    self.faults.push(Fault::new(FaultCode::UnknownKey, key_path, value.place(), message));
                }
                (None, Some(schema @ Value::Object(_))) => self.value(value, schema, &key_path),
                _ => {}
            }
        }
        for key in schema.get("required").and_then(Value::as_array).into_iter().flatten() {
            let Some(key) = key.as_str().filter(|key| table.get(key).is_none()) else { continue };
            let wanted = property(key).map_or("a value".to_owned(), |one| expected(self.shape.resolved(one)));
            let message = format!("is missing, expected {wanted}");
            let fault = Fault::new(FaultCode::MissingKey, join_path(path, key), node.place(), message);
            self.faults.push(fault);
        }
    }

    fn array(&mut self, node: &Node, items: &[Node], schema: &'s Value, path: &str) {
        let count = |key: &str| schema.get(key).and_then(Value::as_u64);
        let n_items = items.len() as u64;
        let (least, most) = (count("minItems").unwrap_or(0), count("maxItems").unwrap_or(u64::MAX));
        if n_items < least || n_items > most {
            let wanted = match (least, most) {
                (least, most) if least == most => format!("{least}"),
                (least, u64::MAX) => format!("at least {least}"),
                (0, most) => format!("at most {most}"),
                (least, most) => format!("{least} to {most}"),
            };
            let message = format!("has {n_items} items, expected {wanted}");
            self.faults.push(Fault::new(FaultCode::BadValue, path, node.origin, message));
        }
        let firsts = schema.get("prefixItems").and_then(Value::as_array);
        for (idx, item) in items.iter().enumerate() {
            let first = firsts.and_then(|firsts| firsts.get(idx));
            if let Some(schema) = first.or_else(|| schema.get("items")) {
                self.value(item, schema, &item_path(path, idx, item));
            }
        }
    }

    fn range(&mut self, node: &Node, number: f64, schema: &Value, path: &str) {
        let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
        let wrong = [
            limit("minimum").filter(|least| number < *least).map(|least| format!("at least {least}")),
            limit("maximum").filter(|most| number > *most).map(|most| format!("at most {most}")),
            limit("exclusiveMinimum").filter(|low| number <= *low).map(|low| format!("above {low}")),
            limit("exclusiveMaximum").filter(|high| number >= *high).map(|high| format!("below {high}")),
        ];
        for wanted in wrong.into_iter().flatten() {
            let message = format!("is {}, expected {wanted}", node.shown());
            self.faults.push(Fault::new(FaultCode::BadValue, path, node.origin, message));
        }
    }
}
