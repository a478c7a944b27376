//! TOML values that remember where they come from.

use super::source::Origin;
use std::fmt::Write;
use toml::value::Datetime;

/// A value and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The value.
    pub value: NodeValue,
    /// Where the value is written.
    pub origin: Origin,
    /// Where its key is written; none for items of an array.
    pub key_origin: Option<Origin>,
}

/// What a [`Node`] holds.
#[derive(Debug, Clone, PartialEq)]
pub enum NodeValue {
    /// Keys in the order of the file.
    Table(Table),
    /// Values in brackets.
    Array(Vec<Node>),
    /// Text.
    String(String),
    /// A whole number.
    Integer(i64),
    /// A number with a fraction.
    Float(f64),
    /// `true` or `false`.
    Bool(bool),
    /// A date, a time, or both.
    Datetime(Datetime),
}

/// Keys and values in the order of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    entries: Vec<(String, Node)>,
}

impl Table {
    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries.iter().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    /// The value of a key, to change it.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Node> {
        self.entries.iter_mut().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    /// Sets a key in its place, or behind all others.
    pub fn set(&mut self, key: &str, node: Node) {
        match self.get_mut(key) {
            Some(old) => *old = node,
            None => self.entries.push((key.to_owned(), node)),
        }
    }

    /// Takes a key out.
    pub fn remove(&mut self, key: &str) -> Option<Node> {
        let at = self.entries.iter().position(|(name, _)| name == key)?;
        Some(self.entries.remove(at).1)
    }

    /// Takes the value of a key and leaves its place empty until it is set again.
    pub(super) fn take(&mut self, key: &str) -> Option<Node> {
        let place = self.get_mut(key)?;
        Some(std::mem::replace(place, Node::empty_table(Origin::BUILT_IN)))
    }

    /// Keys and values, given away.
    pub(super) fn into_entries(self) -> impl Iterator<Item = (String, Node)> {
        self.entries.into_iter()
    }

    /// Keeps the keys for which `keep` says so.
    pub fn retain(&mut self, mut keep: impl FnMut(&str) -> bool) {
        self.entries.retain(|(name, _)| keep(name));
    }

    /// Keys and values in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Node)> {
        self.entries.iter().map(|(name, node)| (name.as_str(), node))
    }

    /// Keys and values in order, to change the values.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&str, &mut Node)> {
        self.entries.iter_mut().map(|(name, node)| (name.as_str(), node))
    }

    /// There are no keys.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The plain table.
    pub fn to_toml(&self) -> toml::Table {
        self.iter().map(|(key, node)| (key.to_owned(), node.to_toml())).collect()
    }
}

impl Node {
    /// An empty table.
    pub fn empty_table(origin: Origin) -> Node {
        Node { value: NodeValue::Table(Table::default()), origin, key_origin: Some(origin) }
    }

    /// A plain value that comes from `origin`.
    pub fn from_toml(value: &toml::Value, origin: Origin) -> Node {
        let value = match value {
            toml::Value::String(text) => NodeValue::String(text.clone()),
            toml::Value::Integer(number) => NodeValue::Integer(*number),
            toml::Value::Float(number) => NodeValue::Float(*number),
            toml::Value::Boolean(truth) => NodeValue::Bool(*truth),
            toml::Value::Datetime(when) => NodeValue::Datetime(*when),
            toml::Value::Array(items) => {
                NodeValue::Array(items.iter().map(|item| Node::from_toml(item, origin)).collect())
            }
            toml::Value::Table(table) => {
                let keyed =
                    |(key, value): (&String, &toml::Value)| (key.clone(), Node::from_toml(value, origin));
                NodeValue::Table(Table { entries: table.iter().map(keyed).collect() })
            }
        };
        Node { value, origin, key_origin: Some(origin) }
    }

    /// The plain value.
    pub fn to_toml(&self) -> toml::Value {
        match &self.value {
            NodeValue::Table(table) => toml::Value::Table(table.to_toml()),
            NodeValue::Array(items) => toml::Value::Array(items.iter().map(Node::to_toml).collect()),
            NodeValue::String(text) => toml::Value::String(text.clone()),
            NodeValue::Integer(number) => toml::Value::Integer(*number),
            NodeValue::Float(number) => toml::Value::Float(*number),
            NodeValue::Bool(truth) => toml::Value::Boolean(*truth),
            NodeValue::Datetime(when) => toml::Value::Datetime(*when),
        }
    }

    /// Where the key is written, or the value where there is no key.
    pub fn place(&self) -> Origin {
        self.key_origin.unwrap_or(self.origin)
    }

    /// The table, if it is one.
    pub fn as_table(&self) -> Option<&Table> {
        match &self.value {
            NodeValue::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The table, to change it.
    pub fn as_table_mut(&mut self) -> Option<&mut Table> {
        match &mut self.value {
            NodeValue::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The items, if it is an array.
    pub fn as_array(&self) -> Option<&[Node]> {
        match &self.value {
            NodeValue::Array(items) => Some(items),
            _ => None,
        }
    }

    /// The text, if it is a string.
    pub fn as_str(&self) -> Option<&str> {
        match &self.value {
            NodeValue::String(text) => Some(text),
            _ => None,
        }
    }

    /// The number, if it is one.
    pub fn as_f64(&self) -> Option<f64> {
        match self.value {
            NodeValue::Integer(number) => Some(number as f64),
            NodeValue::Float(number) => Some(number),
            _ => None,
        }
    }

    /// The value of a key, if this is a table that has it.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.as_table()?.get(key)
    }

    /// What lies at a path such as `weights[2]` or `drive.track_m`, and as far as the path leads: with a path that
    /// ends nowhere the last node on the way.
    pub fn nearest(&self, path: &str) -> &Node {
        let mut node = self;
        for step in steps(path) {
            let next = match (&node.value, step) {
                (NodeValue::Table(table), Step::Key(key)) => table.get(key),
                (NodeValue::Array(items), Step::Index(idx)) => items.get(idx),
                _ => None,
            };
            match next {
                Some(next) => node = next,
                None => break,
            }
        }
        node
    }

    /// The value as a message shows it: short.
    pub fn shown(&self) -> String {
        let text = match &self.value {
            NodeValue::Table(_) => return "a table".to_owned(),
            NodeValue::Array(items) if items.len() > 4 => return format!("a list of {} items", items.len()),
            NodeValue::Array(items) if items.iter().any(|item| item.as_table().is_some()) => {
                return "a list of tables".to_owned();
            }
            _ => self.to_toml().to_string(),
        };
        if text.chars().count() <= 60 {
            return text;
        }
        text.chars().take(57).collect::<String>() + "..."
    }
}

/// One step of a dotted path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step<'p> {
    Key(&'p str),
    Index(usize),
}

/// `planner.weights[2]` as its steps.
pub(super) fn steps(path: &str) -> impl Iterator<Item = Step<'_>> {
    path.split(['.', '[']).filter(|step| !step.is_empty()).map(|step| {
        match step.strip_suffix(']').and_then(|idx| idx.parse().ok()) {
            Some(idx) => Step::Index(idx),
            None => Step::Key(step),
        }
    })
}

/// A path and what follows below it: `planner` and `weights[2]` are `planner.weights[2]`.
pub fn join_path(parent: &str, child: &str) -> String {
    let mut path = parent.to_owned();
    if !parent.is_empty() && !child.is_empty() && !child.starts_with('[') {
        path.push('.');
    }
    let _ = write!(path, "{child}");
    path
}

/// The path of an item of the list at `path`: parts of a pipeline go by their name, everything else by its index.
pub fn item_path(path: &str, idx: usize, item: &Node) -> String {
    let name = item.get("name").and_then(Node::as_str).filter(|_| super::NAMED_LISTS.contains(&path));
    match name {
        Some(name) if !name.is_empty() && !name.contains(['.', '[', ']']) => format!("{path}.{name}"),
        _ => format!("{path}[{idx}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::source::SourceId;

    fn node(text: &str) -> Node {
        Node::from_toml(&toml::Value::Table(toml::from_str(text).unwrap()), Origin::BUILT_IN)
    }

    #[test]
    fn a_path_leads_through_tables_and_arrays_as_far_as_it_can() {
        let root = node("[planner]\nweights = [1, 2, 'x']\ndrive = { track_m = 0.5 }");
        assert_eq!(root.nearest("planner.weights[2]").as_str(), Some("x"));
        assert_eq!(root.nearest("planner.drive.track_m").as_f64(), Some(0.5));
        assert_eq!(root.nearest("planner.drive.nothing"), root.nearest("planner.drive"));
        assert_eq!(root.nearest("planner.weights[7]"), root.nearest("planner.weights"));
        assert_eq!(root.nearest(""), &root);
    }

    #[test]
    fn paths_are_joined_with_a_dot_but_not_before_an_index() {
        assert_eq!(join_path("a", "b"), "a.b");
        assert_eq!(join_path("a", "[2]"), "a[2]");
        assert_eq!(join_path("", "b"), "b");
        assert_eq!(join_path("a", ""), "a");
    }

    #[test]
    fn a_changed_key_keeps_its_place_and_a_new_one_comes_last() {
        let mut root = node("a = 1\nb = 2");
        let table = root.as_table_mut().unwrap();
        let here = Origin { source: SourceId::BUILT_IN, start: 1, end: 2 };
        table.set("a", Node { value: NodeValue::Bool(true), origin: here, key_origin: None });
        table.set("c", Node { value: NodeValue::Bool(false), origin: here, key_origin: None });
        assert_eq!(table.iter().map(|(key, _)| key).collect::<Vec<_>>(), ["a", "b", "c"]);
        assert_eq!(table.get("a").unwrap().origin, here);
    }

    #[test]
    fn long_values_are_shown_short() {
        let root = node(
            "a = [1,2,3,4,5]\nb = {x = 1}\nc = 'hi'\nd = 'äääääääääääääääääääääääääääääääääääääääääääääääääääääääääääääääää'",
        );
        assert_eq!(root.nearest("a").shown(), "a list of 5 items");
        assert_eq!(root.nearest("b").shown(), "a table");
        assert_eq!(root.nearest("c").shown(), "\"hi\"");
        assert!(root.nearest("d").shown().ends_with("ä..."));
    }
}
