//! The registry: everything that a pipeline can name.
//!
//! A plugin writes one line (`register_planner!(DpParams, "dp", "…")`); what lists, documents, checks, builds or tests
//! plugins walks this registry, so that nothing about a plugin is written twice.

mod entry;
mod libraries;
mod linked;
mod manifest;

pub use entry::{Built, Configured, Entry, EntrySource, LibraryInfo, ParseFault, Stage};
pub use libraries::AddError;
pub use linked::{Linked, Params, Plugin, source_of};
pub use manifest::{Manifest, Surroundings};

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Everything that a pipeline can name, sorted by stage and name.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    entries: BTreeMap<(Stage, String), Arc<Entry>>,
    folders: Vec<PathBuf>,
}

/// Why an entry cannot be added.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("two {stage} plugins are called `{name}`: one in {first}, one in {second}; rename or remove one")]
pub struct DuplicateEntry {
    /// The stage.
    pub stage: &'static str,
    /// The name.
    pub name: String,
    /// Where the first comes from.
    pub first: String,
    /// Where the second comes from.
    pub second: String,
}

impl Registry {
    /// The plugins that are linked into this program.
    pub fn linked() -> Result<Registry, DuplicateEntry> {
        let mut registry = Registry::default();
        for linked in inventory::iter::<Linked> {
            registry.add(linked.entry())?;
        }
        Ok(registry)
    }

    /// Adds one more plugin.
    pub fn add(&mut self, entry: Entry) -> Result<(), DuplicateEntry> {
        self.add_shared(Arc::new(entry))
    }

    fn add_shared(&mut self, entry: Arc<Entry>) -> Result<(), DuplicateEntry> {
        let key = (entry.stage, entry.name.clone());
        if let Some(first) = self.entries.get(&key) {
            let (stage, name) = (entry.stage.section(), entry.name.clone());
            return Err(DuplicateEntry {
                stage,
                name,
                first: first.origin.clone(),
                second: entry.origin.clone(),
            });
        }
        self.entries.insert(key, entry);
        Ok(())
    }

    /// Adds the plugins of one stage that another registry has.
    pub fn add_stage_of(&mut self, other: &Registry, stage: Stage) {
        let theirs = other.entries.iter().filter(|((of, _), _)| *of == stage);
        self.entries.extend(theirs.map(|(key, entry)| (key.clone(), entry.clone())));
    }

    /// The plugin of this stage and name.
    pub fn get(&self, stage: Stage, name: &str) -> Option<&Arc<Entry>> {
        self.entries.get(&(stage, name.to_owned()))
    }

    /// All plugins, sorted by stage and name.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<Entry>> {
        self.entries.values()
    }

    /// All plugins of one stage, sorted by name.
    pub fn of_stage(&self, stage: Stage) -> impl Iterator<Item = &Arc<Entry>> {
        self.iter().filter(move |entry| entry.stage == stage)
    }
}

/// Registers a plugin of any stage; the macros named after the stages call this one.
#[doc(hidden)]
#[macro_export]
macro_rules! register_plugin {
    ($stage:ident, $seam:ty, $params:ty, $name:literal, $summary:literal) => {
        $crate::macro_support::inventory::submit! {
            $crate::registry::Linked {
                stage: $crate::registry::Stage::$stage,
                name: $name,
                summary: $summary,
                version: env!("CARGO_PKG_VERSION"),
                package: env!("CARGO_PKG_NAME"),
                source: $crate::registry::source_of::<$params, $seam>,
            }
        }
    };
}

/// Registers a sensor: `register_sensor!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_sensor {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(Sensor, dyn $crate::stages::Sensor, $params, $name, $summary);
    };
}

/// Registers a map builder: `register_map_builder!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_map_builder {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(MapBuilder, dyn $crate::stages::MapBuilder, $params, $name, $summary);
    };
}

/// Registers a localizer: `register_localizer!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_localizer {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(Localizer, dyn $crate::stages::Localizer, $params, $name, $summary);
    };
}

/// Registers a planner: `register_planner!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_planner {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(Planner, dyn $crate::stages::Planner, $params, $name, $summary);
    };
}

/// Registers an avoider: `register_avoider!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_avoider {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(Avoider, dyn $crate::stages::Avoider, $params, $name, $summary);
    };
}

/// Registers a SLAM plugin: `register_slam!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_slam {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(Slam, dyn $crate::stages::Slam, $params, $name, $summary);
    };
}

/// Registers a world: `register_world!(Params, "name", "one line")`.
#[macro_export]
macro_rules! register_world {
    ($params:ty, $name:literal, $summary:literal $(,)?) => {
        $crate::register_plugin!(World, dyn $crate::stages::World, $params, $name, $summary);
    };
}
