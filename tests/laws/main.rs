//! Every plugin of the shipped registry keeps the laws of its stage.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod planners;
mod steering;
mod text_world;
mod worlds;

use rumbo_core::registry::{Built, Entry, Registry, Stage};
use rumbo_core::stages::BuildContext;
use std::sync::Arc;
use {
    rumbo_avoiders as _, rumbo_localizers as _, rumbo_maps as _, rumbo_planners as _, rumbo_sensors as _,
    rumbo_slam as _, rumbo_worlds as _,
};

pub fn entries(stage: Stage) -> Vec<Arc<Entry>> {
    let entries: Vec<_> = Registry::linked().unwrap().of_stage(stage).cloned().collect();
    assert!(!entries.is_empty() || stage == Stage::Slam, "no {} in the registry", stage.section());
    entries
}

/// What an entry cannot do without; everything else is built from its defaults.
fn keys(entry: &Entry) -> toml::Table {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/logs/corridor.clf");
    match (entry.stage, entry.name.as_str()) {
        (Stage::World, "log") | (Stage::Localizer, "recorded_pose") => {
            toml::Table::from_iter([("file".to_owned(), file.into())])
        }
        _ => toml::Table::new(),
    }
}

/// The plugin with its defaults, built twice.
pub fn twins<T: TryFrom<Built>>(entry: &Entry, context: &BuildContext) -> (T, T)
where
    T::Error: std::fmt::Debug,
{
    let build = || {
        let configured = entry.source.parse(keys(entry)).unwrap_or_else(|f| panic!("{entry:?}: {f:?}"));
        assert!(
            configured.check().is_empty(),
            "{entry:?}: the defaults are refused: {:?}",
            configured.check()
        );
        let built = configured.build(context).unwrap_or_else(|e| panic!("{entry:?}: {e}"));
        T::try_from(built).unwrap()
    };
    (build(), build())
}

#[test]
fn every_entry_documents_every_parameter_and_its_defaults_read_back() {
    for entry in Registry::linked().unwrap().iter() {
        assert!(!entry.summary.is_empty() && !entry.summary.ends_with('.'), "{entry:?}: {}", entry.summary);
        let schema = entry.source.schema();
        let properties = schema["properties"].as_object().cloned().unwrap_or_default();
        for (name, property) in &properties {
            let documented = property["description"].as_str().is_some_and(|text| !text.trim().is_empty());
            assert!(documented, "{entry:?}: parameter `{name}` has no documentation");
        }
        assert_eq!(
            schema["additionalProperties"],
            serde_json::json!(false),
            "{entry:?} swallows unknown keys"
        );
        let again =
            entry.source.parse(entry.source.defaults()).unwrap_or_else(|f| panic!("{entry:?}: {f:?}"));
        assert_eq!(again.parameters(), entry.source.defaults(), "{entry:?}");
    }
}

#[test]
fn every_entry_refuses_numbers_that_are_not_finite() {
    for entry in Registry::linked().unwrap().iter() {
        for (key, value) in entry.source.defaults() {
            if !value.is_float() {
                continue;
            }
            for bad in [f64::NAN, f64::INFINITY] {
                let keys = toml::Table::from_iter([(key.clone(), toml::Value::Float(bad))]);
                let refused = entry.source.parse(keys).map_or(true, |configured| {
                    !configured.check().is_empty() || configured.build(&BuildContext::bare("bad")).is_err()
                });
                assert!(refused, "{entry:?} takes {key} = {bad}");
            }
        }
    }
}
