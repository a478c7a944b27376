//! The document as it takes effect, each value with its origin.

use super::node::{Node, NodeValue, Table, item_path, join_path};
use super::source::{Origin, Sources};
use std::fmt::Write;

/// Adds the defaults of every key that the document does not have.
pub fn fill_defaults(node: &mut Node, defaults: &toml::Table) {
    let Some(table) = node.as_table_mut() else { return };
    for (key, default) in defaults {
        match (table.get_mut(key), default) {
            (None, default) => table.set(key, Node::from_toml(default, Origin::BUILT_IN)),
            (Some(node), toml::Value::Table(defaults)) => fill_defaults(node, defaults),
            (Some(_), _) => {}
        }
    }
}

/// The document as TOML that reads back as the same document, with the origin of each value as a comment.
pub fn to_commented_toml(root: &Node, sources: &Sources) -> String {
    let mut printer = Printer { text: String::new(), sources };
    let Some(table) = root.as_table() else { return printer.text };
    for (key, node) in table.iter().filter(|(_, node)| !is_section(node)) {
        printer.key(&quoted(key), node);
    }
    for (key, node) in table.iter() {
        match &node.value {
            NodeValue::Table(section) => printer.section(&format!("[{}]", quoted(key)), section),
            NodeValue::Array(items) if is_section(node) => {
                for section in items.iter().filter_map(Node::as_table) {
                    printer.section(&format!("[[{}]]", quoted(key)), section);
                }
            }
            _ => {}
        }
    }
    printer.text
}

/// The document as JSON: the values, and the origin of each by its path.
pub fn to_json(root: &Node, sources: &Sources) -> serde_json::Value {
    let mut origins = serde_json::Map::new();
    collect_origins(root, "", sources, &mut origins);
    serde_json::json!({ "pipeline": json_value(root), "origins": origins })
}

fn json_value(node: &Node) -> serde_json::Value {
    match &node.value {
        NodeValue::Table(table) => serde_json::Value::Object(
            table.iter().map(|(key, node)| (key.to_owned(), json_value(node))).collect(),
        ),
        NodeValue::Array(items) => serde_json::Value::Array(items.iter().map(json_value).collect()),
        NodeValue::String(text) => text.as_str().into(),
        NodeValue::Integer(number) => (*number).into(),
        NodeValue::Float(number) => (*number).into(),
        NodeValue::Bool(truth) => (*truth).into(),
        NodeValue::Datetime(when) => when.to_string().into(),
    }
}

fn collect_origins(
    node: &Node,
    path: &str,
    sources: &Sources,
    origins: &mut serde_json::Map<String, serde_json::Value>,
) {
    match &node.value {
        NodeValue::Table(table) if !table.is_empty() => {
            table
                .iter()
                .for_each(|(key, node)| collect_origins(node, &join_path(path, key), sources, origins));
        }
        NodeValue::Array(items) if items.iter().any(|item| item.as_table().is_some()) => {
            for (idx, item) in items.iter().enumerate() {
                collect_origins(item, &item_path(path, idx, item), sources, origins);
            }
        }
        _ => {
            origins.insert(path.to_owned(), sources.short(node.origin).into());
        }
    }
}

/// It gets a header of its own.
fn is_section(node: &Node) -> bool {
    match &node.value {
        NodeValue::Table(_) => true,
        NodeValue::Array(items) => !items.is_empty() && items.iter().all(|item| item.as_table().is_some()),
        _ => false,
    }
}

struct Printer<'s> {
    text: String,
    sources: &'s Sources,
}

impl Printer<'_> {
    fn section(&mut self, header: &str, table: &Table) {
        let gap = if self.text.is_empty() { "" } else { "\n" };
        let _ = writeln!(self.text, "{gap}{header}");
        self.keys("", table);
    }

    /// Dotted keys, not tables in braces: so each value has a line, and a comment, of its own.
    fn keys(&mut self, prefix: &str, table: &Table) {
        for (key, node) in table.iter() {
            let key = if prefix.is_empty() { quoted(key) } else { format!("{prefix}.{}", quoted(key)) };
            match &node.value {
                NodeValue::Table(inner) if !inner.is_empty() => self.keys(&key, inner),
                _ => self.key(&key, node),
            }
        }
    }

    fn key(&mut self, key: &str, node: &Node) {
        let _ = match &node.value {
            NodeValue::Array(items) if items.iter().any(|item| item.as_table().is_some()) => {
                let _ = writeln!(self.text, "{key} = [");
                for item in items {
                    let _ = writeln!(self.text, "  {}, # {}", inline(item), self.sources.short(item.origin));
                }
                writeln!(self.text, "]")
            }
            _ => writeln!(self.text, "{key} = {} # {}", inline(node), self.sources.short(node.origin)),
        };
    }
}

/// A value on one line.
fn inline(node: &Node) -> String {
    match &node.value {
        NodeValue::Table(table) if table.is_empty() => "{}".to_owned(),
        NodeValue::Table(table) => {
            let pairs: Vec<String> =
                table.iter().map(|(key, node)| format!("{} = {}", quoted(key), inline(node))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        NodeValue::Array(items) => {
            format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", "))
        }
        // JSON's escapes are a part of TOML's, and a text in quotes stays on its line.
        NodeValue::String(text) => {
            serde_json::Value::from(text.as_str()).to_string().replace('\u{7f}', "\\u007F")
        }
        _ => node.to_toml().to_string(),
    }
}

/// A key as TOML writes it.
fn quoted(key: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(bare) {
        return key.to_owned();
    }
    serde_json::Value::from(key).to_string().replace('\u{7f}', "\\u007F")
}
