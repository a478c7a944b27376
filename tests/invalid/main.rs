//! Every file of `tests/data/invalid` gives exactly the faults of its `.expected` file, all at once.
//!
//! `RUMBO_UPDATE=1 cargo test --test invalid` writes the expectations anew; read the difference before committing it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod doubles;

use rumbo::diagnostics;
use rumbo_core::macro_support::inventory;
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::{Linked, Registry};
use std::fs;
use std::path::{Path, PathBuf};

const FOLDER: &str = "tests/data/invalid";

/// The shipped plugins that the files name. Others are left out, so that a new plugin changes no expectation.
const PLUGINS: [&str; 8] =
    ["a_star", "dp", "lms200", "odometry", "sim", "static_map", "stop_and_replan", "wheel_encoders"];

fn registry() -> Registry {
    let mut registry = Registry::default();
    for linked in inventory::iter::<Linked> {
        if linked.name.starts_with("test_") || PLUGINS.contains(&linked.name) {
            registry.add(linked.entry()).unwrap();
        }
    }
    registry
}

fn pipelines() -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = fs::read_dir(FOLDER)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    paths.sort();
    paths
}

/// The arguments in a line such as `#! --set planner.plugin=dp`.
fn sets(path: &Path) -> Vec<String> {
    let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    let lines = text.lines().filter_map(|line| line.strip_prefix("#! "));
    lines.flat_map(|line| line.split("--set ").skip(1)).map(|set| set.trim().to_owned()).collect()
}

/// All faults as lines, with paths from the folder. The picture for the terminal has them, too.
fn faults(path: &Path, registry: &Registry) -> String {
    let mut loaded = Loaded::read(path, &sets(path), registry);
    loaded.check();
    if loaded.sound().is_some() {
        return "accepted\n".to_owned();
    }
    let drawn = diagnostics::render(&loaded.faults, &loaded.document.sources, false);
    for fault in loaded.faults.iter() {
        let first = fault.message.lines().next().unwrap();
        assert!(drawn.contains(first), "{}: {first} is not in\n{drawn}", path.display());
    }
    let lines = loaded.lines().join("\n").replace(&format!("{FOLDER}/"), "");
    lines + "\n"
}

#[test]
fn every_invalid_file_gives_exactly_its_messages() {
    let registry = registry();
    let update = std::env::var_os("RUMBO_UPDATE").is_some();
    let mut wrong = Vec::new();
    for path in pipelines() {
        let found = faults(&path, &registry);
        let expectation = path.with_extension("expected");
        if update {
            fs::write(&expectation, &found).unwrap();
        }
        let expected = fs::read_to_string(&expectation).unwrap_or_default();
        if expected != found {
            wrong.push(format!("{}\nexpected:\n{expected}found:\n{found}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{} files differ:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn there_is_a_file_for_every_expectation_and_no_lack_of_them() {
    assert!(pipelines().len() >= 45);
    for entry in fs::read_dir(FOLDER).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "expected") {
            assert!(path.with_extension("toml").exists(), "{} expects nothing", path.display());
        }
    }
}

#[test]
fn the_room_itself_is_a_sound_pipeline() {
    let text = fs::read_to_string(format!("{FOLDER}/parts/base.toml")).unwrap();
    let registry = registry();
    let mut loaded = Loaded::from_text(Path::new(&format!("{FOLDER}/room.toml")), &text, &[], &registry);
    loaded.check();
    assert_eq!(loaded.lines(), Vec::<String>::new());
}
