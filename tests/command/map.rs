//! `rumbo map` as the end of a visit: the map, and beside it what the next visit must know.

use super::*;

/// To the door of the first room.
const STEPS: &str = "mission.waypoints=[{ x_m = 1.5, y_m = 7.6 }]";
const VISIT: &str = "pipelines/learning_visit.toml";

fn memory_key(path: &str) -> String {
    format!("map_builder.changes.memory={path:?}")
}

fn visit(map: &Path, more: &[&str]) -> Given {
    let map = map.display().to_string();
    let mut args = vec!["map", VISIT, "--set", STEPS, "-o", &map, "--format", "png", "--no-report", "--json"];
    args.extend(more);
    give(&args)
}

#[test]
fn a_visit_leaves_the_map_and_beside_it_what_the_next_one_must_know() {
    let folder = scratch("visits");
    let first = folder.join("first.yaml");
    let memory = folder.join("first.yaml.changes").display().to_string();
    let made = visit(&first, &[]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    assert_eq!(made.json()["kept"], serde_json::json!([memory]));
    assert!(first.is_file() && folder.join("first.png").is_file());
    let names = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
    assert_eq!(names(&folder), 3, "nothing else lies about");
    let n_visits = |path: &Path| u32::from_le_bytes(std::fs::read(path).unwrap()[84..88].try_into().unwrap());
    assert_eq!(n_visits(Path::new(&memory)), 1);
    // With the saved map, or with the first one.
    let with_memory = memory_key(&memory);
    let saved_map = format!("map_builder.floor.file={:?}", first.display().to_string());
    for (name, sets) in [("second", vec![&with_memory, &saved_map]), ("also", vec![&with_memory])] {
        let map = folder.join(format!("{name}.yaml"));
        let sets: Vec<&str> = sets.into_iter().flat_map(|set| ["--set", set.as_str()]).collect();
        let made = visit(&map, &sets);
        assert_eq!(made.code, 0, "{}", made.stderr);
        assert_eq!(n_visits(&folder.join(format!("{name}.yaml.changes"))), 2);
    }
    let same = |ending: &str| {
        let bytes =
            ["second", "also"].map(|name| std::fs::read(folder.join(name.to_owned() + ending)).unwrap());
        assert_eq!(bytes[0], bytes[1], "{ending}");
    };
    same(".png");
    same(".yaml.changes");
}

#[test]
fn a_memory_that_is_missing_damaged_or_of_another_map_is_refused_with_what_to_do() {
    let folder = scratch("bad-memories");
    let map = folder.join("floor.yaml");
    assert_eq!(visit(&map, &[]).code, 0);
    let memory = folder.join("floor.yaml.changes");
    let bytes = std::fs::read(&memory).unwrap();
    let refused = |name: &str, content: Option<&[u8]>, more: &[&str], words: &str| {
        let path = folder.join(name);
        if let Some(content) = content {
            std::fs::write(&path, content).unwrap();
        }
        let key = memory_key(&path.display().to_string());
        for verb in ["check", "run"] {
            let mut args = vec![verb, VISIT, "--set", &key, "--set", STEPS];
            args.extend(more);
            let told = give(&args);
            assert_ne!(told.code, 0, "{name}: {verb}");
            assert!(told.stderr.contains(words) && told.stderr.contains(name), "{name}: {}", told.stderr);
        }
    };
    refused("missing", None, &[], "leave `memory` out at the first visit");
    refused("cut", Some(&bytes[..bytes.len() / 2]), &[], "damaged or cut off");
    refused("empty", Some(b""), &[], "no memory of visits");
    refused("picture", Some(&std::fs::read(folder.join("floor.png")).unwrap()), &[], "no memory of visits");
    let mut newer = bytes.clone();
    newer[8] = 9;
    refused("newer", Some(&newer), &[], "its version is 9");
    let other = ["--set", "map_builder.floor.file=worlds/natural_landmark_5x5.yaml"];
    refused("foreign", Some(&bytes), &other, "another map");
}

#[test]
fn a_builder_may_have_any_name() {
    let folder = scratch("odd-names");
    let map = folder.join("floor.yaml");
    let made = visit(&map, &["--set", "map_builder.changes.name=\"../odd name\""]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    assert!(folder.join("floor.yaml.___odd_name").is_file());
}

#[test]
fn a_run_writes_no_memory() {
    let folder = scratch("no-memory");
    let report = folder.join("report.html").display().to_string();
    let picture = folder.join("picture.png").display().to_string();
    let given = give(&["run", VISIT, "--set", STEPS, "--report", &report, "--picture", &picture]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
}
