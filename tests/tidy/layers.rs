use super::*;

/// What stands below `[dependencies]`.
fn dependencies(manifest: &str) -> Vec<String> {
    let manifest: toml::Table = toml::from_str(&text(&root().join(manifest))).unwrap();
    manifest["dependencies"].as_table().unwrap().keys().cloned().collect()
}

#[test]
fn core_depends_on_no_plugin_and_plugins_on_core_and_kit_only() {
    let ours =
        |names: Vec<String>| names.into_iter().filter(|name| name.starts_with("rumbo")).collect::<Vec<_>>();
    assert!(ours(dependencies("core/Cargo.toml")).is_empty());
    for package in ["worlds", "sensors", "maps", "localizers", "slam", "planners", "avoiders"] {
        let names = ours(dependencies(&format!("plugins/{package}/Cargo.toml")));
        assert_eq!(names, ["rumbo-core", "rumbo-kit"], "{package}");
    }
}

#[test]
fn every_plugin_has_its_rooms() {
    for path in files("plugins", &["plugin.rs"]) {
        let folder = path.parent().unwrap();
        assert!(folder.join("params.rs").is_file(), "{}: where are the parameters?", short(folder));
    }
}

#[test]
fn an_algorithm_knows_messages_and_maps_and_nothing_else_of_the_framework() {
    let framework = ["registry", "engine", "pipeline", "document"];
    let mut wrong = Vec::new();
    for plugin in files("plugins", &["plugin.rs"]) {
        for path in files(&short(plugin.parent().unwrap()), &[".rs"]) {
            let name = short(&path);
            let is_rim =
                name.ends_with("/plugin.rs") || name.contains("/plugin/") || name.ends_with("/params.rs");
            let text = text(&path);
            let named =
                framework.iter().filter(|part| production(&text).contains(&format!("rumbo_core::{part}")));
            if !is_rim && is_shipped(&name) {
                wrong.extend(named.map(|part| format!("{name}: rumbo_core::{part}")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Files that measure how long something took: for observers, for the pace and progress of the command, and for reports
/// on how soon a plugin gives up. And those that have to do with what is real: scans of a real device are stamped by when
/// their bytes came, and the world `robot` has the time of the wall.
const MAY_READ_CLOCKS: [&str; 8] = [
    "core/src/engine/",
    "src/run/",
    "src/drive.rs",
    "src/eval/graph.rs",
    "src/eval/slam.rs",
    "src/laws/stopwatch.rs",
    "plugins/kit/benches/",
    "plugins/kit/src/wall_clock.rs",
];

#[test]
fn nothing_but_observers_reads_a_clock_and_nothing_but_seeds_feeds_chance() {
    let mut wrong = Vec::new();
    for path in rust_files() {
        let (name, text) = (short(&path), text(&path));
        if !is_shipped(&name) {
            continue;
        }
        let code = production(&text);
        let reads_clock = code.contains("Instant::now") || code.contains("SystemTime");
        if reads_clock && !MAY_READ_CLOCKS.iter().any(|place| name.starts_with(place)) {
            wrong.push(format!("{name} reads a clock"));
        }
        for chance in
            ["rand::rng()", "thread_rng", "from_os_rng", "rand::random", "RandomState", "HashMap::new()"]
        {
            if code.contains(chance) {
                wrong.push(format!("{name} uses {chance}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
