//! A crate that somebody else could have written: built by its own cargo, loaded as a file, at work like any shipped
//! plugin.

use crate::nested::{root, rumbo, scratch, third_party};
use rumbo_core::registry::{Registry, Stage};
use std::path::{Path, PathBuf};

/// The crate's own pipeline in a folder of a test's own, with `change` made to it.
fn office(name: &str, change: impl Fn(String) -> String) -> PathBuf {
    let text = std::fs::read_to_string(root().join("examples/third_party_rust/office.toml")).unwrap();
    let named = "target/release/libthird_party_rust.so";
    assert!(text.contains(named));
    let text = text.replace(named, &third_party().display().to_string());
    let text = text.replace("../..", &root().display().to_string());
    let file = scratch(name).join("office.toml");
    std::fs::write(&file, change(text)).unwrap();
    file
}

fn unchanged(text: String) -> String {
    text
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn the_library_is_listed_and_described_like_what_is_shipped() {
    let mut registry = Registry::linked().unwrap();
    let library = registry.load(third_party(), None).unwrap();
    let found: Vec<_> =
        library.entries.iter().map(|e| (e.stage, e.name.as_str(), e.version.as_str())).collect();
    assert_eq!(found, [(Stage::Planner, "theta_star", "0.3.0"), (Stage::Avoider, "follow_gap", "0.3.0")]);
    assert!(library.info.build_info.contains("rumbo-core"), "{}", library.info.build_info);
    let schema = library.entries[0].source.schema();
    let said = schema["properties"]["clearance_m"]["description"].as_str().unwrap();
    assert!(said.starts_with("Free space between"), "{said}");
    let plugin = ["--plugin", text(third_party())];
    let (code, list, _) = rumbo(&[&["plugins", "list"][..], &plugin].concat());
    assert!(code == 0 && list.contains("follow_gap") && list.contains("sha256"), "{list}");
    let (code, described, _) = rumbo(&[&["plugins", "describe", "theta_star"][..], &plugin].concat());
    assert!(code == 0 && described.contains("greediness"), "{described}");
}

#[test]
fn its_pipeline_drives_across_the_office_twice_with_the_same_bytes() {
    let file = office("office", unchanged);
    let (code, _, told) = rumbo(&["check", text(&file)]);
    assert_eq!(code, 0, "{told}");
    let recorded = |name: &str| {
        let bag = file.with_file_name(name);
        let (code, _, told) = rumbo(&["run", text(&file), "--no-report", "--record", text(&bag)]);
        assert!(code == 0 && told.contains("arrived"), "{told}");
        std::fs::read(bag).unwrap()
    };
    assert!(recorded("one.mcap") == recorded("two.mcap"), "two runs differ");
    let (code, _, told) = rumbo(&["test", text(&file)]);
    assert_eq!(code, 0, "{told}");
}

#[test]
fn a_comparison_swaps_it_for_shipped_plugins_and_back() {
    let file = office("compare", |text| {
        text.replace("x_m = 24.5, y_m = 19.5", "x_m = 3.0, y_m = 7.0")
            .replace("clearance_m = 0.35", "variants = { dp = {}, theta_star = { clearance_m = 0.35 } }")
            .replace("look_ahead_m = 0.6", "variants = { stop_and_replan = {}, follow_gap = {} }")
    });
    let output = file.with_file_name("compared");
    let swaps =
        ["--swap", "planner=dp,theta_star", "--swap", "avoider=stop_and_replan,follow_gap", "--seeds", "2"];
    let (code, _, told) = rumbo(&[&["compare", text(&file), "--output", text(&output)][..], &swaps].concat());
    assert_eq!(code, 0, "{told}");
    let csv = std::fs::read_to_string(output.join("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 4 * 2, "{csv}");
}

#[test]
fn it_keeps_the_laws_of_its_stages() {
    let (code, _, told) = rumbo(&["plugins", "verify", "--broken", text(third_party())]);
    assert_eq!(code, 0, "{told}");
}

/// The faults that `check` tells, without the file's name.
fn faults(planner: &str, keys: &str) -> String {
    let file = office(&format!("faults_{planner}_{}", keys.len()), |text| {
        let keys = format!("plugin = \"{planner}\"\n{keys}");
        text.replace("plugin = \"theta_star\"\nclearance_m = 0.35", &keys)
    });
    let (code, _, told) = rumbo(&["check", text(&file)]);
    assert_eq!(code, 2, "{told}");
    told.replace(text(&file), "office.toml")
}

#[test]
fn a_mistake_in_its_keys_is_told_like_one_in_a_shipped_plugins() {
    for (keys, words) in [
        ("clearence_m = 0.35", "planner.clearence_m: unknown key, did you mean clearance_m?"),
        ("clearance_m = \"wide\"", "planner.clearance_m"),
        ("clearance_m = -1.0", "planner.clearance_m"),
    ] {
        let (theirs, ours) = (faults("theta_star", keys), faults("a_star", keys));
        assert!(theirs.contains(words) && theirs.contains("office.toml:23:"), "{theirs}");
        // Word for word but for the kind of fault (one of both has its range in its schema) and what each expects.
        let place =
            |told: &str| told.lines().find(|line| line.contains("-->")).unwrap_or_default().to_owned();
        assert_eq!(place(&theirs), place(&ours));
        let head = |told: &str| {
            let words = told.lines().next().and_then(|line| line.split_once("]: "));
            words.and_then(|(_, words)| words.split(" is ").next()).map(str::to_owned)
        };
        assert!(head(&theirs).is_some());
        assert_eq!(head(&theirs), head(&ours), "{theirs}\n{ours}");
    }
}

#[test]
fn a_library_with_another_checksum_is_refused() {
    let sha256 = "0".repeat(64);
    let pinned = format!("{{ file = {:?}, sha256 = \"{sha256}\" }}", third_party().display().to_string());
    let file = office("pinned", |text| text.replace(&format!("\"{}\"", third_party().display()), &pinned));
    let (code, _, told) = rumbo(&["check", text(&file)]);
    assert!(code == 2 && told.contains("plugin_path[0]") && told.contains("sha256"), "{told}");
}
