//! From text to nodes, with every syntax error of the text.

use super::fault::{Fault, FaultCode, Faults};
use super::node::{Node, NodeValue, Table, item_path, join_path};
use super::source::{Origin, SourceId};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Tables may be nested so deep; deeper ones are a mistake or an attack on the stack.
const MAX_DEPTH: usize = 60;

/// Reads a whole text.
pub(super) fn read_table(text: &str, source: SourceId, faults: &mut Faults) -> Node {
    let origin = Origin { source, start: 0, end: text.len() };
    if let Some(at) = too_deep(text) {
        let message = format!("brackets are nested more than {MAX_DEPTH} deep");
        faults.push(Fault::new(FaultCode::Syntax, "", Origin { source, start: at, end: at + 1 }, message));
        return Node::empty_table(origin);
    }
    let (table, errors) = DeTable::parse_recoverable(text);
    let mut reader = Reader { source, faults };
    reader.errors(&errors, text);
    let value = NodeValue::Table(reader.table(table.get_ref(), ""));
    Node { value, origin, key_origin: None }
}

/// Reads a single value that begins at the byte `offset` of its source.
pub(super) fn read_value(text: &str, offset: usize, source: SourceId, faults: &mut Faults) -> Option<Node> {
    if too_deep(text).is_some() {
        let place = Origin { source, start: offset, end: offset + text.len() };
        faults.push(Fault::new(FaultCode::Syntax, "", place, "brackets are nested too deep"));
        return None;
    }
    let (value, errors) = DeValue::parse_recoverable(text);
    let mut found = Faults::default();
    let mut reader = Reader { source, faults: &mut found };
    reader.errors(&errors, text);
    let mut node = reader.node(&value, "");
    let fine = found.is_empty();
    for fault in found.iter() {
        let mut fault = fault.clone();
        fault.origin = fault.origin.map(|origin| shifted(origin, offset));
        faults.push(fault);
    }
    shift(&mut node, offset);
    fine.then_some(node)
}

/// The first bracket that opens deeper than allowed. Brackets in strings and comments count too: nobody writes so many.
fn too_deep(text: &str) -> Option<usize> {
    let mut depth = 0usize;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'[' | b'{' => depth += 1,
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Some(at);
        }
    }
    text.lines().find(|line| line.split('=').next().unwrap_or("").matches('.').count() > MAX_DEPTH).map(|_| 0)
}

struct Reader<'f> {
    source: SourceId,
    faults: &'f mut Faults,
}

impl Reader<'_> {
    fn errors(&mut self, errors: &[toml::de::Error], text: &str) {
        for error in errors {
            let span = error.span().unwrap_or(0..text.len().min(1));
            let message = error.message().trim().replace('\n', ", ");
            let fault = Fault::new(FaultCode::Syntax, "", self.origin(span), message);
            self.faults.push(fault);
        }
    }

    fn origin(&self, span: Range<usize>) -> Origin {
        Origin { source: self.source, start: span.start, end: span.end }
    }

    fn table(&mut self, table: &DeTable<'_>, path: &str) -> Table {
        let mut keys: Vec<_> = table.iter().collect();
        // The parser sorts by name; people read in the order of the file.
        keys.sort_by_key(|(key, _)| key.span().start);
        let mut nodes = Table::default();
        for (key, value) in keys {
            let mut node = self.node(value, &join_path(path, key.get_ref()));
            node.key_origin = Some(self.origin(key.span()));
            nodes.set(key.get_ref(), node);
        }
        nodes
    }

    fn array(&mut self, array: &DeArray<'_>, path: &str) -> Vec<Node> {
        let items = array.iter().enumerate();
        items.map(|(idx, item)| self.node(item, &format!("{path}[{idx}]"))).collect()
    }

    fn node(&mut self, value: &Spanned<DeValue<'_>>, path: &str) -> Node {
        let origin = self.origin(value.span());
        let value = match value.get_ref() {
            DeValue::String(text) => NodeValue::String(text.to_string()),
            DeValue::Integer(number) => {
                let digits = number.as_str().replace('_', "");
                match i64::from_str_radix(&digits, number.radix()) {
                    Ok(number) => NodeValue::Integer(number),
                    Err(_) => {
                        let message =
                            format!("is {digits}, expected a whole number of at most 64 bits with sign");
                        self.faults.push(Fault::new(FaultCode::BadValue, path, origin, message));
                        NodeValue::Integer(0)
                    }
                }
            }
            // A number too large for a double becomes infinite, and is refused as such.
            DeValue::Float(number) => {
                NodeValue::Float(number.as_str().replace('_', "").parse().unwrap_or(f64::NAN))
            }
            DeValue::Boolean(truth) => NodeValue::Bool(*truth),
            // What the parser makes of a broken date: the error is in the list, and the date cannot be printed.
            DeValue::Datetime(when) if when.date.is_none() && when.time.is_none() => {
                NodeValue::String(String::new())
            }
            DeValue::Datetime(when) => NodeValue::Datetime(*when),
            DeValue::Array(array) => NodeValue::Array(self.array(array, path)),
            DeValue::Table(table) => NodeValue::Table(self.table(table, path)),
        };
        Node { value, origin, key_origin: None }
    }
}

/// Refuses every NaN and infinity below `node`.
pub(super) fn refuse_not_finite(node: &Node, path: &str, faults: &mut Faults) {
    match &node.value {
        NodeValue::Float(number) if !number.is_finite() => {
            let message = format!("is {number}, expected a finite number");
            faults.push(Fault::new(FaultCode::NotFinite, path, node.origin, message));
        }
        NodeValue::Array(items) => {
            for (idx, item) in items.iter().enumerate() {
                refuse_not_finite(item, &item_path(path, idx, item), faults);
            }
        }
        NodeValue::Table(table) => {
            for (key, value) in table.iter() {
                refuse_not_finite(value, &join_path(path, key), faults);
            }
        }
        _ => {}
    }
}

fn shifted(origin: Origin, offset: usize) -> Origin {
    Origin { start: origin.start + offset, end: origin.end + offset, ..origin }
}

fn shift(node: &mut Node, offset: usize) {
    node.origin = shifted(node.origin, offset);
    node.key_origin = node.key_origin.map(|origin| shifted(origin, offset));
    match &mut node.value {
        NodeValue::Array(items) => items.iter_mut().for_each(|item| shift(item, offset)),
        NodeValue::Table(table) => table.iter_mut().for_each(|(_, value)| shift(value, offset)),
        _ => {}
    }
}
