//! From a table of the document to a struct, with every fault of the table.

use super::fault::{Fault, FaultCode, Faults};
use super::node::{Node, Step, Table, join_path, steps};
use super::shape::Shape;
use crate::registry::ParseFault;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// What came out of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed<T> {
    /// The struct. Keys with a fault have their default here, so that the rest can be checked all the same.
    pub value: T,
    /// Keys of the table that were left out because of a fault.
    pub left_out: Vec<String>,
}

/// Reads a table as a `T` and reports everything that is wrong with it; nothing comes out only where a key that has no
/// default is missing or wrong.
pub fn parse_table<T: DeserializeOwned + JsonSchema>(
    node: &Node,
    path: &str,
    faults: &mut Faults,
) -> Option<Parsed<T>> {
    let schema = schemars::schema_for!(T).to_value();
    parse_with(node, path, &schema, &[], faults, |table| {
        serde_path_to_error::deserialize(table).map_err(|fault| ParseFault {
            path: fault.path().to_string(),
            message: fault.inner().message().to_owned(),
        })
    })
}

/// As [`parse_table`] with a schema and a parser of your own. Keys in `also_known` are suggested beside the schema's.
pub fn parse_with<T>(
    node: &Node,
    path: &str,
    schema: &Value,
    also_known: &[&str],
    faults: &mut Faults,
    parse: impl Fn(toml::Table) -> Result<T, ParseFault>,
) -> Option<Parsed<T>> {
    let found = Shape { schema, also_known }.check(node, path);
    let Some(table) = node.as_table() else {
        faults.extend(found);
        return None;
    };
    let is_bad = |key: &str| {
        let key = join_path(path, key);
        found.any_below(&key) || faults.any_below(&key)
    };
    let mut left_out: Vec<String> = keys(table).filter(|key| is_bad(key)).map(str::to_owned).collect();
    let shape_is_fine = found.is_empty();
    faults.extend(found);
    loop {
        let mut kept = node.clone();
        if let Some(table) = kept.as_table_mut() {
            table.retain(|key| !left_out.iter().any(|left| left == key));
        }
        let kept = kept.as_table().map(Table::to_toml).unwrap_or_default();
        let fault = match parse(kept) {
            Ok(value) => return Some(Parsed { value, left_out }),
            Err(fault) => fault,
        };
        let top = steps(&fault.path).next();
        let key = match top {
            Some(Step::Key(key)) if table.get(key).is_some() && !left_out.iter().any(|left| left == key) => {
                key
            }
            _ => {
                // The schema has named what is missing, unless it knows less than the parser does.
                if shape_is_fine && left_out.is_empty() {
                    faults.push(Fault::new(FaultCode::BadValue, path, node.place(), fault.message));
                }
                return None;
            }
        };
        let place = node.nearest(&fault.path).origin;
        faults.push(Fault::new(FaultCode::BadValue, join_path(path, &fault.path), place, fault.message));
        left_out.push(key.to_owned());
    }
}

fn keys(table: &Table) -> impl Iterator<Item = &str> {
    table.iter().map(|(key, _)| key)
}

#[cfg(test)]
mod tests;
