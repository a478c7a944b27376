//! Both ways of growth: older plugins in this host, and plugins of a later minor.

use crate::compiler::{self, Language};
use crate::runs;
use rumbo_core::engine::EndReason;
use rumbo_core::registry::Stage;
use std::path::PathBuf;

fn record(name: &str, flags: &[&str]) -> PathBuf {
    let source = compiler::root().join("tests/boundary/fixtures/record.c");
    compiler::library(&source, Language::C, flags, name)
}

#[test]
fn a_plugin_of_a_later_minor_with_larger_structs_runs() {
    let name = "-DNAME=\"from_later\"";
    let flags = [
        name,
        "-DMINOR=7",
        "-DMODULE_SIZE=sizeof(rumbo_module)+48",
        "-DENTRY_SIZE=sizeof(rumbo_entry)+48",
        "-DTABLE_SIZE=sizeof(rumbo_planner_table)+48",
        "-DFLAGS=RUMBO_CATCHES|0x8000",
    ];
    let registry = runs::registry(&[&record("later", &flags)]);
    let entry = registry.get(Stage::Planner, "from_later").unwrap();
    assert_eq!(entry.library.as_ref().unwrap().abi, (1, 7));
    let text = runs::floor(&[("planner", "plugin = \"from_later\"")]);
    let (told, end) = runs::run(&text, &registry, 60.0).unwrap();
    assert_eq!(end.reason, EndReason::Arrived, "{:?}", told.events);
}

#[test]
fn functions_of_an_entry_that_ends_before_them_are_absent() {
    let upto = "-DENTRY_SIZE=offsetof(rumbo_entry,manifest)";
    let registry = runs::registry(&[&record("short_entry", &["-DNAME=\"short_entry\"", upto])]);
    let entry = registry.get(Stage::Planner, "short_entry").unwrap();
    let configured = entry.source.parse(toml::Table::new()).unwrap();
    assert!(configured.manifest().needs_layers.is_empty());
    assert!(configured.check().is_empty());
    let error = rumbo::registry()
        .unwrap()
        .load(&record("shorter_entry", &["-DENTRY_SIZE=offsetof(rumbo_entry,create)"]), None)
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("its entry 0 (`spoiled`) has no function `create`"), "{error}");
}

#[test]
fn a_table_that_ends_before_a_function_that_it_needs_is_refused() {
    let flags = ["-DTABLE_SIZE=offsetof(rumbo_planner_table,plan)"];
    let error =
        rumbo::registry().unwrap().load(&record("short_table", &flags), None).unwrap_err().to_string();
    assert!(error.ends_with("its entry 0 (`spoiled`) has no function `plan` in its table"), "{error}");
}
