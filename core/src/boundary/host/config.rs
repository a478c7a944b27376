//! Parameters of a dynamic plugin: as text for Rust, by path for C.

use super::super::abi::{rumbo_config, rumbo_values};
use super::super::convert::text_of;
use super::module::Record;
use crate::registry::ParseFault;
use serde_json::Value as Json;

/// Parsed parameters behind the accessors.
pub(super) struct Values(toml::Value);

impl Values {
    /// The value at a path such as `weights[2]` or `limits.speed_m_s`.
    pub fn at(&self, path: &str) -> Option<&toml::Value> {
        let mut at = &self.0;
        for part in path.split('.').filter(|part| !part.is_empty()) {
            let mut pieces = part.split('[');
            let key = pieces.next().unwrap_or_default();
            if !key.is_empty() {
                at = at.get(key)?;
            }
            for piece in pieces {
                at = at.get(piece.strip_suffix(']')?.parse::<usize>().ok()?)?;
            }
        }
        Some(at)
    }
}

/// The parameters of one plugin, ready to be handed over.
pub(super) struct Config {
    text: String,
    values: Values,
}

impl Config {
    /// `keys` as the pipeline gives them, below them the defaults.
    pub fn new(keys: &toml::Table, defaults: &toml::Table) -> Config {
        let mut all = defaults.clone();
        lay_over(&mut all, keys);
        Config { text: keys.to_string(), values: Values(toml::Value::Table(all)) }
    }

    /// A view that holds as long as this does.
    pub fn lend(&self) -> rumbo_config {
        rumbo_config {
            size: size_of::<rumbo_config>(),
            toml: text_of(&self.text),
            values: std::ptr::from_ref(&self.values).cast::<rumbo_values>(),
        }
    }

    /// All parameters, defaults included.
    pub fn all(&self) -> toml::Table {
        self.values.0.as_table().cloned().unwrap_or_default()
    }
}

fn lay_over(below: &mut toml::Table, above: &toml::Table) {
    for (key, value) in above {
        match (below.get_mut(key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => lay_over(below, above),
            _ => {
                below.insert(key.clone(), value.clone());
            }
        }
    }
}

/// A plugin without a check of its own relies on its schema, also where the keys come from no pipeline.
pub(super) fn fits_schema(record: &Record, keys: &toml::Table) -> Result<(), ParseFault> {
    if record.entry.check.is_some() {
        return Ok(());
    }
    let misfit = crate::document::misfit(&record.schema, keys);
    misfit.map_or(Ok(()), |(path, message)| Err(ParseFault { path, message }))
}

/// The defaults that a schema names, for plugins that do not write them as TOML.
pub(super) fn defaults_of(schema: &Json) -> toml::Table {
    let mut table = toml::Table::new();
    let properties = schema.get("properties").and_then(Json::as_object);
    for (key, property) in properties.into_iter().flatten() {
        let value = match property.get("default") {
            Some(default) => toml_of(default),
            None => Some(toml::Value::Table(defaults_of(property)))
                .filter(|_| property.get("properties").is_some()),
        };
        if let Some(value) = value {
            table.insert(key.clone(), value);
        }
    }
    table
}

fn toml_of(json: &Json) -> Option<toml::Value> {
    Some(match json {
        Json::Null => return None,
        Json::Bool(value) => toml::Value::Boolean(*value),
        Json::Number(number) => match number.as_i64() {
            Some(whole) => toml::Value::Integer(whole),
            None => toml::Value::Float(number.as_f64()?),
        },
        Json::String(text) => toml::Value::String(text.clone()),
        Json::Array(items) => toml::Value::Array(items.iter().map(toml_of).collect::<Option<_>>()?),
        Json::Object(members) => {
            let members = members.iter().filter_map(|(key, value)| Some((key.clone(), toml_of(value)?)));
            toml::Value::Table(members.collect())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_leads_through_tables_and_arrays_and_defaults_lie_below() {
        let keys = toml::from_str("a = 1\nlimits.speed = 2.5\nrows = [[1, 2], [3, 4]]").unwrap();
        let defaults = toml::from_str("a = 7\nb = 'word'\nlimits = { speed = 1.0, turn = 3.0 }").unwrap();
        let values = Config::new(&keys, &defaults).values;
        let number =
            |path: &str| values.at(path).and_then(|v| v.as_float().or(v.as_integer().map(|i| i as f64)));
        assert_eq!(number("a"), Some(1.0));
        assert_eq!(number("limits.speed"), Some(2.5));
        assert_eq!(number("limits.turn"), Some(3.0));
        assert_eq!(number("rows[1][0]"), Some(3.0));
        assert_eq!(values.at("b").and_then(toml::Value::as_str), Some("word"));
        for nowhere in ["c", "rows[2]", "rows[x]", "rows[1", "a.b", "limits[0]"] {
            assert!(values.at(nowhere).is_none(), "{nowhere}");
        }
    }

    #[test]
    fn defaults_are_read_from_a_schema() {
        let schema = serde_json::json!({ "properties": {
            "speed_m_s": { "default": 0.5 }, "n": { "default": 3 }, "name": { "default": "x" }, "free": {},
            "inner": { "properties": { "a": { "default": [1.5, 2.5] } } },
        }});
        let expected: toml::Table =
            toml::from_str("speed_m_s = 0.5\nn = 3\nname = 'x'\ninner.a = [1.5, 2.5]").unwrap();
        assert_eq!(defaults_of(&schema), expected);
    }
}
