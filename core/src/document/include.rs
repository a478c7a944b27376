//! `include = ["common/robot.toml"]`: what a file includes is laid below it, so that the including file has the last
//! word.

use super::NAMED_LISTS;
use super::fault::{Fault, FaultCode, Faults};
use super::node::{Node, NodeValue, Table};
use super::read::read_table;
use super::source::{Origin, SourceName, Sources};
use std::path::{Path, PathBuf};

/// A pipeline file is text that people write; a larger file was named by mistake.
const MAX_BYTES: u64 = 4 << 20;

/// Reads a file and all that it includes.
pub(super) fn load(path: &Path, sources: &mut Sources, faults: &mut Faults) -> Node {
    match read_file(path) {
        Ok(text) => load_text(path, &text, sources, faults),
        Err(reason) => {
            let message = format!("cannot read the pipeline file {}: {reason}", path.display());
            faults.push(Fault::new(FaultCode::File, "", None, message));
            Node::empty_table(Origin::BUILT_IN)
        }
    }
}

/// Reads a text as if it were the file `path`, and all that it includes.
pub(super) fn load_text(path: &Path, text: &str, sources: &mut Sources, faults: &mut Faults) -> Node {
    let chain = vec![(path.to_path_buf(), identity(path))];
    Loader { sources, faults, chain }.text(path, text)
}

/// A file by another name is still the same file.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

fn read_file(path: &Path) -> Result<String, String> {
    let about = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        _ => error.to_string(),
    })?;
    if about.is_dir() {
        return Err("it is a folder, expected a TOML file".into());
    }
    if about.len() > MAX_BYTES {
        return Err(format!("it has {} bytes, expected at most {MAX_BYTES}", about.len()));
    }
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    String::from_utf8(bytes).map_err(|error| {
        format!("byte {} is not UTF-8 text, expected a TOML file", error.utf8_error().valid_up_to())
    })
}

struct Loader<'a> {
    sources: &'a mut Sources,
    faults: &'a mut Faults,
    /// The files on the way to this one: as written, and as the system knows them.
    chain: Vec<(PathBuf, PathBuf)>,
}

impl Loader<'_> {
    fn text(&mut self, path: &Path, text: &str) -> Node {
        let source = self.sources.add(SourceName::File(path.to_path_buf()), text);
        let mut node = read_table(text, source, self.faults);
        let Some(include) = node.as_table_mut().and_then(|table| table.remove("include")) else {
            return node;
        };
        let mut below: Option<Node> = None;
        for (entry, wanted) in self.entries(&include) {
            if let Some(included) = self.included(path, &entry, &wanted) {
                below = Some(match below {
                    None => included,
                    Some(earlier) => merged(earlier, included, ""),
                });
            }
        }
        match below {
            None => node,
            Some(below) => merged(below, node, ""),
        }
    }

    /// The entries of `include` that are text, with their places.
    fn entries(&mut self, include: &Node) -> Vec<(Node, PathBuf)> {
        let mut entries = Vec::new();
        let items = match &include.value {
            NodeValue::Array(items) => items.as_slice(),
            _ => std::slice::from_ref(include),
        };
        for (idx, item) in items.iter().enumerate() {
            match item.as_str() {
                Some(text) => entries.push((item.clone(), PathBuf::from(text))),
                None => {
                    let message = format!("is {}, expected the path of a file in quotes", item.shown());
                    let path = format!("include[{idx}]");
                    self.faults.push(Fault::new(FaultCode::File, path, item.origin, message));
                }
            }
        }
        entries
    }

    fn included(&mut self, including: &Path, entry: &Node, wanted: &Path) -> Option<Node> {
        let path = including.parent().unwrap_or(Path::new("")).join(wanted);
        let known = identity(&path);
        if let Some(first) = self.chain.iter().position(|(_, earlier)| *earlier == known) {
            let mut names: Vec<String> =
                self.chain[first..].iter().map(|(name, _)| name.display().to_string()).collect();
            names.push(path.display().to_string());
            let message = format!("a file includes itself: {}", names.join(" -> "));
            let fault = Fault::new(FaultCode::RecursiveInclude, "include", entry.origin, message);
            self.faults.push(fault.help("remove one of these includes"));
            return None;
        }
        match read_file(&path) {
            Ok(text) => {
                self.chain.push((path.clone(), known));
                let node = self.text(&path, &text);
                self.chain.pop();
                Some(node)
            }
            Err(reason) => {
                let message = format!("cannot read {}: {reason}", path.display());
                let fault = Fault::new(FaultCode::File, "include", entry.origin, message);
                self.faults.push(fault.help("a path is relative to the file that includes it"));
                None
            }
        }
    }
}

/// `over` laid on `below`: tables are merged key by key, parts of a pipeline by their name, everything else is replaced.
fn merged(below: Node, over: Node, path: &str) -> Node {
    let Node { origin, key_origin, .. } = over;
    let value = match (below.value, over.value) {
        (NodeValue::Table(below), NodeValue::Table(over)) => {
            NodeValue::Table(merged_tables(below, over, path))
        }
        (NodeValue::Array(below), NodeValue::Array(over)) if NAMED_LISTS.contains(&path) => {
            NodeValue::Array(merged_lists(below, over))
        }
        (_, over) => over,
    };
    Node { value, origin, key_origin }
}

fn merged_tables(mut below: Table, over: Table, parent: &str) -> Table {
    for (key, node) in over.into_entries() {
        let path = if parent.is_empty() { key.clone() } else { format!("{parent}.{key}") };
        let node = match below.take(&key) {
            Some(old) => merged(old, node, &path),
            None => node,
        };
        below.set(&key, node);
    }
    below
}

fn merged_lists(mut below: Vec<Node>, over: Vec<Node>) -> Vec<Node> {
    let name_of = |node: &Node| node.get("name").and_then(Node::as_str).map(str::to_owned);
    for node in over {
        let name = name_of(&node);
        let same = below.iter().position(|old| name.is_some() && name_of(old) == name);
        match same {
            Some(idx) => {
                let old = std::mem::replace(&mut below[idx], Node::empty_table(Origin::BUILT_IN));
                below[idx] = merged(old, node, "item");
            }
            None => below.push(node),
        }
    }
    below
}
