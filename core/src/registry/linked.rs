//! Plugins that are linked into this program, found by `inventory`.

use super::entry::{Built, Configured, Entry, EntrySource, ParseFault, Stage};
use super::manifest::{Manifest, Surroundings};
use crate::stages::{BuildContext, BuildError};
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::marker::PhantomData;

/// A plugin's parameters: one struct, `#[serde(default, deny_unknown_fields)]`, each field documented with effect and
/// unit, since these comments are the user's documentation.
pub trait Params:
    DeserializeOwned + Serialize + JsonSchema + Default + Clone + Send + Sync + 'static
{
    /// Every impossible value at once.
    fn check(&self) -> Vec<BuildError> {
        Vec::new()
    }

    /// Values that are possible, but will hardly do what their writer expects beside the rest of the pipeline. People are
    /// told of those whose key they wrote themselves, and the pipeline runs all the same.
    fn doubts(&self, _surroundings: &Surroundings) -> Vec<BuildError> {
        Vec::new()
    }
}

/// Parameters that a stage of the kind `S` can be built from.
pub trait Plugin<S: ?Sized>: Params {
    /// What the plugin needs and gives, with these parameters.
    fn manifest(&self) -> Manifest {
        Manifest::default()
    }

    /// Makes the stage.
    fn build(&self, context: &BuildContext) -> Result<Box<S>, BuildError>;
}

/// The line that a plugin leaves in the program.
pub struct Linked {
    /// The seat that it fills.
    pub stage: Stage,
    /// Its name in a pipeline.
    pub name: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Version of its package.
    pub version: &'static str,
    /// Its package.
    pub package: &'static str,
    /// Its parameters.
    pub source: fn() -> Box<dyn EntrySource>,
}
inventory::collect!(Linked);

impl Linked {
    /// The entry as the registry keeps it.
    pub fn entry(&self) -> Entry {
        Entry {
            stage: self.stage,
            name: self.name.to_owned(),
            summary: self.summary.to_owned(),
            version: self.version.to_owned(),
            origin: self.package.to_owned(),
            library: None,
            source: (self.source)(),
        }
    }
}

/// The source of a plugin with parameters `P` for the stage `S`.
pub fn source_of<P, S>() -> Box<dyn EntrySource>
where
    P: Plugin<S>,
    S: ?Sized + 'static,
    Built: From<Box<S>>,
{
    Box::new(Typed::<P, S>(PhantomData, PhantomData))
}

struct Typed<P, S: ?Sized>(PhantomData<P>, PhantomData<fn() -> Box<S>>);

impl<P, S> EntrySource for Typed<P, S>
where
    P: Plugin<S>,
    S: ?Sized + 'static,
    Built: From<Box<S>>,
{
    fn schema(&self) -> serde_json::Value {
        schemars::schema_for!(P).to_value()
    }

    fn defaults(&self) -> toml::Table {
        table_of(&P::default())
    }

    fn parse(&self, keys: toml::Table) -> Result<Box<dyn Configured>, ParseFault> {
        let params: P = serde_path_to_error::deserialize(keys).map_err(|fault| ParseFault {
            path: fault.path().to_string(),
            message: fault.inner().message().to_owned(),
        })?;
        Ok(Box::new(WithParams::<P, S> { params, stage: PhantomData }))
    }
}

struct WithParams<P, S: ?Sized> {
    params: P,
    stage: PhantomData<fn() -> Box<S>>,
}

impl<P, S> Configured for WithParams<P, S>
where
    P: Plugin<S>,
    S: ?Sized + 'static,
    Built: From<Box<S>>,
{
    fn manifest(&self) -> Manifest {
        self.params.manifest()
    }

    fn check(&self) -> Vec<BuildError> {
        self.params.check()
    }

    fn doubts(&self, surroundings: &Surroundings) -> Vec<BuildError> {
        self.params.doubts(surroundings)
    }

    fn parameters(&self) -> toml::Table {
        table_of(&self.params)
    }

    fn build(&self, context: &BuildContext) -> Result<Built, BuildError> {
        self.params.build(context).map(Built::from)
    }
}

/// The parameters as TOML; absent options are left out.
fn table_of<P: Serialize>(params: &P) -> toml::Table {
    toml::Table::try_from(params).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::Path;
    use crate::registry::Registry;
    use crate::stages::{PlanError, PlanRequest, Planner};
    use serde::Deserialize;

    /// Goes straight.
    #[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
    #[serde(default, deny_unknown_fields)]
    struct StraightParams {
        /// Weights of something.
        weights: Vec<f64>,
    }
    struct Straight;
    impl Planner for Straight {
        fn plan(&mut self, request: &PlanRequest) -> Result<Path, PlanError> {
            let start = request.start.translation.vector.into();
            Path::through([start, request.goal.position], 0.0).ok_or(PlanError::GivenUp)
        }
    }
    impl Params for StraightParams {}
    impl Plugin<dyn Planner> for StraightParams {
        fn build(&self, _: &BuildContext) -> Result<Box<dyn Planner>, BuildError> {
            Ok(Box::new(Straight))
        }
    }
    crate::register_planner!(StraightParams, "straight_in_test", "goes straight");

    #[test]
    fn a_registered_planner_is_found_parsed_and_built() {
        let registry = Registry::linked().unwrap();
        let entry = registry.get(Stage::Planner, "straight_in_test").unwrap();
        let keys = toml::from_str("weights = [1.0, 2]").unwrap();
        let configured = entry.source.parse(keys).unwrap();
        assert_eq!(configured.parameters().to_string().trim(), "weights = [1.0, 2.0]");
        assert!(matches!(configured.build(&BuildContext::bare("planner")), Ok(Built::Planner(_))));
    }

    #[test]
    fn a_key_that_cannot_be_understood_is_named_with_its_path() {
        let registry = Registry::linked().unwrap();
        let entry = registry.get(Stage::Planner, "straight_in_test").unwrap();
        let fault = entry.source.parse(toml::from_str("weights = [1.0, 'x']").unwrap()).err().unwrap();
        assert_eq!(fault.path, "weights[1]");
    }

    #[test]
    fn a_name_can_be_registered_only_once() {
        let mut registry = Registry::linked().unwrap();
        let twin =
            inventory::iter::<Linked>.into_iter().find(|l| l.name == "straight_in_test").unwrap().entry();
        assert!(registry.add(twin).unwrap_err().to_string().contains("straight_in_test"));
    }
}
