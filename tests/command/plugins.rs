use super::*;
use std::collections::BTreeSet;

/// `stage crate` and name of every folder that has a `plugin.rs`.
fn folders() -> BTreeSet<(String, String)> {
    let mut found = BTreeSet::new();
    let plugins = Path::new(env!("CARGO_MANIFEST_DIR")).join("plugins");
    for package in std::fs::read_dir(plugins).unwrap() {
        let package = package.unwrap().path();
        let name = format!("rumbo-{}", package.file_name().unwrap().to_str().unwrap());
        let Ok(folders) = std::fs::read_dir(package.join("src")) else { continue };
        for folder in folders {
            let folder = folder.unwrap().path();
            if folder.join("plugin.rs").is_file() {
                found.insert((name.clone(), folder.file_name().unwrap().to_str().unwrap().to_owned()));
            }
        }
    }
    found
}

#[test]
fn every_plugin_of_the_tree_is_in_the_shipped_registry_and_every_entry_has_its_folder() {
    let list = give(&["plugins", "list", "--json"]).json();
    let text = |entry: &serde_json::Value, field: &str| entry[field].as_str().unwrap().to_owned();
    let listed: BTreeSet<(String, String)> =
        list.as_array().unwrap().iter().map(|entry| (text(entry, "origin"), text(entry, "name"))).collect();
    assert!(listed.len() >= 9, "{listed:?}");
    assert_eq!(listed, folders());
}

#[test]
fn plugins_are_listed_by_section_and_described() {
    let planners = give(&["plugins", "list", "--stage", "planner"]);
    assert!(planners.stdout.contains("a_star") && !planners.stdout.contains("lms200"));
    let described = give(&["plugins", "describe", "dp"]);
    assert!(described.stdout.contains("preferred_clearance_m (number, m) = 0.45"), "{}", described.stdout);
    let json = give(&["plugins", "describe", "planner.dp", "--json"]).json();
    assert_eq!(json["manifest"]["needs_layers"], serde_json::json!(["grid"]));
}

#[test]
fn a_near_name_is_suggested() {
    let given = give(&["plugins", "describe", "lms20"]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("did you mean `lms200`?"), "{}", given.stderr);
    let given = give(&["plugins", "list", "--stage", "planer"]);
    assert!(given.code == 2 && given.stderr.contains("`planner`"), "{}", given.stderr);
}

#[test]
fn the_pages_of_the_plugins_are_up_to_date() {
    let given = give(&["plugins", "docs", "docs/plugins", "--check"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
}

#[test]
fn the_schema_beside_the_pipelines_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/rumbo.schema.json");
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    assert_eq!(
        give(&["schema"]).stdout,
        committed,
        "write it with `rumbo schema > pipelines/rumbo.schema.json`"
    );
}

#[test]
fn laws_are_told_line_by_line_and_as_json() {
    let told = give(&["plugins", "verify", "a_star", "localizer.odometry"]);
    assert_eq!((told.code, told.stdout.as_str()), (0, ""), "{}", told.stderr);
    assert!(told.stderr.contains("planner.a_star") && told.stderr.contains("\n  ✓ a path touches nothing"));
    assert!(told.stderr.contains("2 plugins: ") && told.stderr.contains(" 0 broken, "), "{}", told.stderr);
    assert!(!told.stderr.contains('\u{1b}'));
    let json = give(&["plugins", "verify", "odometry", "--json"]).json();
    assert_eq!((&json["broken"], &json["plugins"][0]["name"]), (&0.into(), &"odometry".into()));
    let laws = json["plugins"][0]["findings"].as_array().unwrap();
    assert!(laws.iter().any(|law| law["law"].as_str().unwrap().starts_with("covariances are symmetric")));
}

#[test]
fn a_law_that_is_broken_ends_with_1_and_what_cannot_be_asked_with_2() {
    let broken = give(&["plugins", "verify", "a_star", "--set", "clearance_m=-1.0", "--broken"]);
    assert_eq!(broken.code, 1, "{}", broken.stderr);
    assert!(broken.stderr.contains("✗ it can be built from its defaults"), "{}", broken.stderr);
    for args in [&["a_sta"] as &[&str], &["./nothing.so"], &["--set", "gain=1"], &["dp", "--set", "gain"]] {
        let refused = give(&[&["plugins", "verify"], args].concat());
        assert_eq!(refused.code, 2, "{args:?}: {}", refused.stderr);
    }
}
