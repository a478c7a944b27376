//! A pipeline file as text: where every value comes from, and every fault at once.
//!
//! This module knows TOML, not robots: [`Document::load`] reads a file with its includes and `--set` arguments into a
//! tree in which every value remembers its place; [`parse_table`] turns a table of that tree into a struct and reports
//! everything that is wrong with it; [`to_commented_toml`] prints the tree with the origin of each value.

mod effective;
mod fault;
mod include;
mod node;
mod parse;
mod read;
mod schema_terms;
mod set;
mod shape;
mod source;
mod suggest;

pub use effective::{fill_defaults, to_commented_toml, to_json};
pub use fault::{Fault, FaultCode, Faults, Note};
pub use node::{Node, NodeValue, Table, item_path, join_path};
pub use parse::{Parsed, parse_table, parse_with};
pub use set::drop_plugin_keys;
pub use source::{Origin, Source, SourceId, SourceName, Sources};
pub use suggest::{did_you_mean, unknown_key_message};

use std::path::Path;

/// Keys of a section that belong to the framework; every other key is the plugin's.
pub const RESERVED_KEYS: [&str; 10] = [
    "plugin",
    "name",
    "mount",
    "rate_hz",
    "every_s",
    "inputs",
    "latency_s",
    "variants",
    "duration_s",
    "resume",
];

/// Sections that are lists of tables, which are addressed and merged by their `name`.
pub const NAMED_LISTS: [&str; 2] = ["sensor", "map_builder"];

/// A pipeline file with everything that it includes and everything that was set on the command line.
#[derive(Debug, Clone)]
pub struct Document {
    /// Every text that a value may come from.
    pub sources: Sources,
    /// The merged table.
    pub root: Node,
}

impl Document {
    /// Reads `path`, its includes, and `--set` arguments such as `planner.minimum_clearance_m=0.2`. What cannot be
    /// understood is missing in the document and reported in the faults.
    pub fn load(path: &Path, sets: &[String]) -> (Document, Faults) {
        let mut faults = Faults::default();
        let mut sources = Sources::default();
        let root = include::load(path, &mut sources, &mut faults);
        Document::finish(sources, root, sets, faults)
    }

    /// As [`load`](Self::load) for a text that is not in a file; `name` is shown in messages and includes are looked
    /// for beside it.
    pub fn from_text(name: &Path, text: &str, sets: &[String]) -> (Document, Faults) {
        let mut faults = Faults::default();
        let mut sources = Sources::default();
        let root = include::load_text(name, text, &mut sources, &mut faults);
        Document::finish(sources, root, sets, faults)
    }

    fn finish(
        mut sources: Sources,
        mut root: Node,
        sets: &[String],
        mut faults: Faults,
    ) -> (Document, Faults) {
        set::apply(&mut root, sets, &mut sources, &mut faults);
        read::refuse_not_finite(&root, "", &mut faults);
        (Document { sources, root }, faults)
    }
}

/// The first thing that is wrong with values that come from no file: a number that is not finite, or another shape than
/// the schema says. Its key, and what was found and expected.
pub fn misfit(schema: &serde_json::Value, values: &toml::Table) -> Option<(String, String)> {
    let (document, mut faults) = Document::from_text(Path::new(""), &values.to_string(), &[]);
    faults.extend(shape::Shape { schema, also_known: &[] }.check(&document.root, ""));
    faults.iter().next().map(|fault| (fault.path.clone(), fault.message.clone()))
}

#[cfg(test)]
mod tests;

/// Faults of a text against a JSON schema.
#[cfg(test)]
pub(crate) fn schema_faults(schema: &serde_json::Value, text: &str) -> Vec<String> {
    let (document, _) = Document::from_text(Path::new("p.toml"), text, &[]);
    shape::Shape { schema, also_known: &[] }.check(&document.root, "").lines(&document.sources)
}
