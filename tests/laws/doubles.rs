//! Plugins made for tests: a stage from a function, without parameters unless a test gives some.

use super::*;
use rumbo_core::registry::{Built, Configured, EntrySource, Manifest, ParseFault};
use rumbo_core::stages::{BuildContext, BuildError};
use serde_json::json;

/// How a double makes its stage.
pub type Make = fn(&BuildContext) -> Built;

#[derive(Clone)]
pub struct Double {
    pub manifest: Manifest,
    pub make: Make,
    pub schema: serde_json::Value,
    pub defaults: toml::Table,
    pub fault: fn(&BuildContext) -> Option<BuildError>,
}

impl Double {
    /// A plugin without parameters.
    pub fn entry(stage: Stage, name: &str, manifest: Manifest, make: Make) -> Entry {
        let schema = json!({ "type": "object", "additionalProperties": false, "properties": {} });
        Double { manifest, make, schema, defaults: toml::Table::new(), fault: |_| None }.called(stage, name)
    }

    pub fn called(self, stage: Stage, name: &str) -> Entry {
        Entry {
            stage,
            name: name.into(),
            summary: "made for a test".into(),
            version: "0.0.0".into(),
            origin: "tests".into(),
            library: None,
            source: Box::new(self),
        }
    }
}

impl EntrySource for Double {
    fn schema(&self) -> serde_json::Value {
        self.schema.clone()
    }

    fn defaults(&self) -> toml::Table {
        self.defaults.clone()
    }

    fn parse(&self, keys: toml::Table) -> Result<Box<dyn Configured>, ParseFault> {
        match keys.keys().find(|key| !self.defaults.contains_key(*key)) {
            Some(key) => Err(ParseFault { path: key.clone(), message: "unknown key".into() }),
            None => Ok(Box::new(self.clone())),
        }
    }
}

impl Configured for Double {
    fn manifest(&self) -> Manifest {
        self.manifest.clone()
    }

    fn check(&self) -> Vec<BuildError> {
        Vec::new()
    }

    fn parameters(&self) -> toml::Table {
        self.defaults.clone()
    }

    fn build(&self, context: &BuildContext) -> Result<Built, BuildError> {
        (self.fault)(context).map_or_else(|| Ok((self.make)(context)), Err)
    }
}

/// A plugin that is shipped, built from its defaults.
pub fn build<T: TryFrom<Built, Error = BuildError>>(stage: Stage, name: &str, context: &BuildContext) -> T {
    let configured = shipped(stage, name).source.parse(toml::Table::new()).ok().unwrap();
    T::try_from(configured.build(context).unwrap()).unwrap()
}

/// What a plugin that is shipped needs and gives.
pub fn manifest(stage: Stage, name: &str) -> Manifest {
    shipped(stage, name).source.parse(toml::Table::new()).ok().unwrap().manifest()
}
