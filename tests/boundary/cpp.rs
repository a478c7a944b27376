//! Nothing that a C++ plugin throws leaves its library.

use crate::compiler::{self, Language};
use crate::runs;
use rumbo_core::map::Map;
use rumbo_core::messages::Prior;
use rumbo_core::registry::{Built, Configured, Registry, Stage};
use rumbo_core::stages::{BuildContext, BuildError};
use std::path::PathBuf;
use std::sync::OnceLock;

fn library() -> &'static PathBuf {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let source = compiler::root().join("tests/boundary/fixtures/throwing.cpp");
        compiler::library(&source, Language::Cpp, &[], "throwing")
    })
}

fn configured(stage: Stage, how: &str) -> Box<dyn Configured> {
    let mut registry = Registry::default();
    registry.load(library(), None).unwrap();
    let keys = toml::from_str(&format!("how = '{how}'")).unwrap();
    registry.get(stage, "throwing").unwrap().source.parse(keys).unwrap()
}

fn build(how: &str) -> Result<Built, BuildError> {
    configured(Stage::Planner, how).build(&BuildContext::bare("planner"))
}

#[test]
fn what_a_constructor_throws_is_told() {
    let error = build("in the constructor").err().unwrap();
    let words = "panicked when it was made: thrown in the constructor";
    assert!(error.message.ends_with(words), "{error:?}");
    assert_eq!(build("bad key").err(), Some(BuildError::at("n", "is odd").help("take an even number")));
    assert_eq!(build("missing key").err(), Some(BuildError::at("no_such_key", "is missing")));
}

#[test]
fn what_a_destructor_throws_is_caught() {
    for stage in
        [Stage::Planner, Stage::Avoider, Stage::Localizer, Stage::MapBuilder, Stage::Slam, Stage::Sensor]
    {
        let built = configured(stage, "in the destructor").build(&BuildContext::bare("stage")).unwrap();
        drop(built);
    }
}

#[test]
fn what_a_stage_throws_is_told_and_stops_the_robot() {
    let registry = runs::registry(&[library()]);
    let plugin = format!("plugin `throwing` of {}", library().display());
    for (section, seat) in [("avoider", "avoider"), ("sensor", "front")] {
        for (how, words) in [
            ("standard", "panicked: an index of 7 in a list of 3"),
            ("odd", "panicked: an exception that is no std::exception"),
            ("number", "panicked: an exception that is no std::exception"),
            ("null", "panicked: an exception that is no std::exception"),
        ] {
            let line = format!("plugin = \"throwing\"\nhow = \"{how}\"");
            let (told, _) = runs::run(&runs::floor(&[(section, &line)]), &registry, 4.0).unwrap();
            assert_eq!(told.failures[0], (seat.to_owned(), format!("{plugin} {words}")), "{how}");
            assert_eq!(told.fastest, 0.0, "{how}");
        }
    }
}

#[test]
fn a_failure_keeps_its_status_and_its_words() {
    let registry = runs::registry(&[library()]);
    let line = "plugin = \"throwing\"\nhow = \"failure\"";
    let (told, _) = runs::run(&runs::floor(&[("planner", line)]), &registry, 4.0).unwrap();
    let is_told = |event: &String| event.starts_with("no path: ") && event.contains("a closed door");
    assert!(told.events.iter().any(is_told), "{:?}", told.events);
}

#[test]
fn what_a_map_builder_keeps_is_given_or_the_reason_told() {
    let save = |how: &str| match configured(Stage::MapBuilder, how).build(&BuildContext::bare("map")).unwrap()
    {
        Built::MapBuilder(builder) => builder.save(&mut Map::default()).map_err(|error| error.to_string()),
        _ => panic!("no map builder"),
    };
    assert_eq!(save("well"), Ok(Some(b"kept".to_vec())));
    assert!(save("standard").unwrap_err().ends_with("panicked: an index of 7 in a list of 3"));
}

#[test]
fn a_state_is_saved_or_the_reason_told() {
    let save = |how: &str| match configured(Stage::Slam, how).build(&BuildContext::bare("slam")).unwrap() {
        Built::Slam(mut slam) => {
            slam.start(&Prior::Unknown, &mut Map::default()).unwrap();
            let first = slam.save().map_err(|error| error.to_string());
            (first, slam.save().map_err(|error| error.to_string()))
        }
        _ => panic!("no SLAM"),
    };
    assert_eq!(save("well").0, Ok(b"saved".to_vec()));
    let (first, second) = save("standard");
    assert!(first.unwrap_err().ends_with("panicked: an index of 7 in a list of 3"));
    let again = second.unwrap_err();
    assert!(again.contains("is not called again: it panicked: an index of 7"), "{again}");
}
