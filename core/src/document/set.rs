//! `--set planner.minimum_clearance_m=0.2`: values from the command line.

use super::fault::{Fault, FaultCode, Faults};
use super::node::{Node, NodeValue, Step, item_path, steps};
use super::read::read_value;
use super::source::{Origin, SourceId, SourceName, Sources};
use super::suggest::did_you_mean;
use super::{NAMED_LISTS, RESERVED_KEYS};

/// Applies the arguments in their order, but swaps of plugins first: the other arguments are meant for the new plugin.
pub(super) fn apply(root: &mut Node, sets: &[String], sources: &mut Sources, faults: &mut Faults) {
    let mut parsed: Vec<Argument> =
        sets.iter().filter_map(|text| Argument::parse(text, sources, faults)).collect();
    parsed.sort_by_key(|argument| !argument.swaps_plugin());
    for argument in &parsed {
        if let Err(message) = argument.apply(root) {
            faults.push(Fault::new(FaultCode::Set, argument.path.clone(), argument.key, message));
        }
    }
}

/// Removes a plugin's own keys from its section and leaves the framework's, as a swap to another plugin does: keys of
/// one plugin mean nothing to another.
pub fn drop_plugin_keys(section: &mut Node) {
    if let Some(table) = section.as_table_mut() {
        table.retain(|key| RESERVED_KEYS.contains(&key));
    }
}

struct Argument {
    path: String,
    value: Node,
    key: Origin,
}

impl Argument {
    fn parse(text: &str, sources: &mut Sources, faults: &mut Faults) -> Option<Argument> {
        let source = sources.add(SourceName::Set, text);
        let whole = Origin { source, start: 0, end: text.len() };
        let fault = |message: &str| {
            Fault::new(FaultCode::Set, "", whole, message).help("write --set planner.minimum_clearance_m=0.2")
        };
        let Some((path, value)) = text.split_once('=') else {
            faults.push(fault("has no `=`, expected KEY=VALUE"));
            return None;
        };
        let offset = path.len() + 1;
        let (path, value) = (path.trim(), value.trim());
        if path.is_empty() || path.split('.').any(|step| step.trim().is_empty() || step.starts_with('[')) {
            faults.push(fault("has an empty key, expected KEY=VALUE"));
            return None;
        }
        let key = Origin { source, start: 0, end: path.len() };
        let lead = text[offset..].len() - text[offset..].trim_start().len();
        let mut value = read_argument(value, offset + lead, source, path, faults)?;
        value.key_origin = Some(key);
        Some(Argument { path: path.to_owned(), value, key })
    }

    /// This argument names another plugin for a section.
    fn swaps_plugin(&self) -> bool {
        self.path.ends_with(".plugin")
    }

    fn apply(&self, root: &mut Node) -> Result<(), String> {
        let steps: Vec<Step<'_>> = steps(&self.path).collect();
        let (Some((last, way)), mut node) = (steps.split_last(), root) else { return Ok(()) };
        let mut path = String::new();
        for step in way {
            node = self.step(node, *step, &mut path)?;
        }
        if self.swaps_plugin() && node.get("plugin").and_then(Node::as_str) != self.value.as_str() {
            drop_plugin_keys(node);
        }
        match (last, &mut node.value) {
            (Step::Key(key), NodeValue::Table(table)) => table.set(key, self.value.clone()),
            (Step::Index(idx), NodeValue::Array(items)) if *idx < items.len() => {
                items[*idx] = self.value.clone();
            }
            _ => return Err(self.nowhere(&path, node)),
        }
        Ok(())
    }

    /// One step down: into a table (made where it is missing), or to an item by index or name.
    fn step<'n>(
        &self,
        node: &'n mut Node,
        step: Step<'_>,
        path: &mut String,
    ) -> Result<&'n mut Node, String> {
        let found = match (step, &node.value) {
            (Step::Key(key), NodeValue::Table(table)) if table.get(key).is_some() => true,
            (Step::Key(key), NodeValue::Table(_)) => key != "sensor" || !path.is_empty(),
            (Step::Key(name), NodeValue::Array(items)) => position(items, name).is_some(),
            (Step::Index(idx), NodeValue::Array(items)) => idx < items.len(),
            _ => false,
        };
        if !found {
            return Err(self.nowhere(path, node));
        }
        match (step, &mut node.value) {
            (Step::Key(key), NodeValue::Table(table)) => {
                if table.get(key).is_none() {
                    table.set(key, Node::empty_table(self.key));
                }
                *path = super::join_path(path, key);
                table.get_mut(key).ok_or_else(|| self.path.clone())
            }
            (Step::Key(name), NodeValue::Array(items)) => {
                let idx = position(items, name).unwrap_or_default();
                *path = item_path(path, idx, &items[idx]);
                Ok(&mut items[idx])
            }
            (Step::Index(idx), NodeValue::Array(items)) => {
                *path = item_path(path, idx, &items[idx]);
                Ok(&mut items[idx])
            }
            _ => Err(format!("leads nowhere below `{path}`")),
        }
    }

    /// Why the path does not lead on from here.
    fn nowhere(&self, path: &str, node: &Node) -> String {
        let NodeValue::Array(items) = &node.value else {
            return match node.as_table() {
                Some(_) => "names a sensor of a pipeline without sensors".to_owned(),
                None => format!("leads into `{path}`, which is {}, not a table", node.shown()),
            };
        };
        let names: Vec<&str> = items.iter().filter_map(|item| item.get("name")?.as_str()).collect();
        let wanted = self.path.get(path.len()..).unwrap_or("").trim_start_matches('.');
        let wanted = wanted.split('.').next().unwrap_or(wanted);
        if !NAMED_LISTS.contains(&path) {
            return format!("`{path}` has {} items, and no {wanted}", items.len());
        }
        let message = format!("no {path} is called `{wanted}`");
        match did_you_mean(wanted, names.iter().copied()) {
            Some(close) => format!("{message}, did you mean {close}?"),
            None if names.is_empty() => message,
            None => format!("{message}, expected one of {}", names.join(", ")),
        }
    }
}

/// By name; a bare number is an index.
fn position(items: &[Node], name: &str) -> Option<usize> {
    let by_name = items.iter().position(|item| item.get("name").and_then(Node::as_str) == Some(name));
    by_name.or_else(|| name.parse().ok().filter(|idx| *idx < items.len()))
}

/// A TOML value; a word or a path may stand without quotes.
fn read_argument(
    value: &str,
    offset: usize,
    source: SourceId,
    path: &str,
    faults: &mut Faults,
) -> Option<Node> {
    let mut found = Faults::default();
    let node = read_value(value, offset, source, &mut found);
    if node.is_some() {
        return node;
    }
    let origin = Origin { source, start: offset, end: offset + value.len() };
    let begins_like_a_word = |c: char| c.is_alphabetic() || matches!(c, '_' | '/' | '.' | '~');
    let is_word = value.starts_with(begins_like_a_word) && !value.contains(['"', '\'', '\n', '{', '[', '=']);
    if is_word {
        return Some(Node { value: NodeValue::String(value.to_owned()), origin, key_origin: None });
    }
    for fault in found.iter() {
        let message = match fault.code {
            FaultCode::Syntax => format!("`{value}` is no TOML value: {}", fault.message),
            _ => fault.message.clone(),
        };
        let fault = Fault::new(fault.code, path, fault.origin, message);
        faults.push(fault.help("write text in quotes, as in --set 'name=\"3d map\"'"));
    }
    None
}
