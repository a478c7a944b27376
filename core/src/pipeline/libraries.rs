//! `plugin_path`: libraries with more plugins.
//!
//! A file is loaded because the pipeline names it. A folder is no permission to load what lies in it: it is searched only
//! for the library of a plugin that the pipeline names and nobody has yet.

use super::Seat;
use super::own_sections::Head;
use crate::document::{Fault, FaultCode, Faults, Node};
use crate::registry::{Registry, Stage};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// One entry of `plugin_path`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PluginFile {
    /// A shared library, or a folder that is searched for `libNAME` of a plugin NAME that the pipeline uses.
    Path(PathBuf),
    /// A shared library that must be this very file.
    Pinned(Pinned),
}

/// A library with its checksum.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pinned {
    /// The shared library.
    pub file: PathBuf,
    /// Its SHA-256, 64 hexadecimal digits.
    pub sha256: String,
}

/// The registry with the plugins of the libraries that the pipeline names.
pub(super) fn with_libraries(
    root: &Node,
    head: &Head,
    folder: &Path,
    registry: &Registry,
    faults: &mut Faults,
) -> Registry {
    let mut registry = registry.clone();
    for (idx, named) in head.plugin_path.iter().enumerate() {
        let path = format!("plugin_path[{idx}]");
        let fault = |message: String| {
            Fault::new(FaultCode::Library, path.clone(), root.nearest(&path).origin, message)
        };
        let (file, sha256) = match named {
            PluginFile::Path(file) => (folder.join(file), None),
            PluginFile::Pinned(Pinned { file, sha256 }) => (folder.join(file), Some(sha256.as_str())),
        };
        if file.is_dir() && sha256.is_none() {
            registry.search(file);
        } else if let Err(error) = registry.load(&file, sha256) {
            faults.push(fault(error.to_string()));
        }
    }
    for (stage, name, node) in used(root) {
        if let Err(error) = registry.seek(stage, name) {
            let place = node.origin;
            faults.push(Fault::new(FaultCode::Library, "plugin_path", place, error.to_string()));
        }
    }
    registry
}

/// Every plugin that the pipeline names, variants included.
fn used(root: &Node) -> Vec<(Stage, &str, &Node)> {
    let mut used = Vec::new();
    for seat in Seat::ALL {
        let Some(node) = root.get(seat.section()) else { continue };
        let sections = node.as_array().unwrap_or(std::slice::from_ref(node));
        for section in sections {
            if let Some(plugin) = section.get("plugin")
                && let Some(name) = plugin.as_str()
            {
                used.push((seat.stage(), name, plugin));
            }
            let variants = section.get("variants").and_then(Node::as_table);
            for (name, variant) in variants.into_iter().flat_map(|variants| variants.iter()) {
                used.push((seat.stage(), name, variant));
            }
        }
    }
    used
}
