//! What `rumbo check` costs: parse, prove, build every stage dry, load the map.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rumbo::load;
use rumbo_core::pipeline::{Loaded, schema};
use std::path::Path;

const OFFICE: &str = "pipelines/office.toml";

fn main() {
    divan::main();
}

/// The registry, the file and its includes, and everything that can be said without opening the map.
#[divan::bench]
fn read_office() {
    let registry = load::registry().ok().unwrap();
    let loaded = Loaded::read(Path::new(OFFICE), &[], &registry);
    assert!(loaded.sound().is_some());
}

/// All of `rumbo check pipelines/office.toml`; the bar is 100 ms.
#[divan::bench]
fn check_office() {
    let registry = load::registry().ok().unwrap();
    let mut loaded = Loaded::read(Path::new(OFFICE), &[], &registry);
    loaded.check();
    assert!(loaded.sound().is_some());
}

/// The schema of the whole file, for editors.
#[divan::bench]
fn schema_of_all_plugins() -> serde_json::Value {
    schema(&load::registry().ok().unwrap())
}
