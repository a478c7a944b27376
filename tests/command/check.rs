use super::*;

#[test]
fn the_shipped_pipelines_have_no_faults() {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let given = give(&["check", path.to_str().unwrap()]);
            assert_eq!(given.code, 0, "{}", given.stderr);
        }
    }
}

#[test]
fn all_faults_come_at_once_with_line_and_advice() {
    let text = "name = 'x'\n[world]\nplugin = 'simm'\n[localizer]\nplugin = 'odometry'\njumpm = 1.0\n";
    let path = file("all_faults", text);
    let given = give(&["check", &path]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("sim") && given.stderr.contains("jump_m"), "{}", given.stderr);
    let json = give(&["check", &path, "--json"]);
    assert_eq!(json.code, 2);
    let faults = json.json()[0]["faults"].as_array().unwrap().clone();
    assert!(faults.len() >= 2, "{faults:?}");
    let world = faults.iter().find(|fault| fault["code"] == "unknown_plugin").unwrap();
    assert_eq!(world["place"]["line"], 3);
}

#[test]
fn every_verb_that_reads_a_pipeline_refuses_a_bad_one_with_the_same_code() {
    let path = file("bad", "name = 'x'\n[world]\nplugin = 'simm'\n");
    for verb in ["check", "run", "config", "plot", "test"] {
        let given = give(&[verb, &path]);
        assert_eq!((given.code, given.stdout.as_str()), (2, ""), "{verb}");
        assert!(given.stderr.contains("simm"), "{verb}: {}", given.stderr);
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let given = give(&["run", "pipelines/offce.toml"]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("pipelines/offce.toml"), "{}", given.stderr);
}

#[test]
fn a_missing_map_is_a_fault_with_the_line_that_names_it() {
    let given = give(&["run", OFFICE, "--set", "world.map=worlds/nowhere.yaml", "--no-report"]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("nowhere.yaml") && given.stderr.contains("world.map"), "{}", given.stderr);
}

#[test]
fn the_effective_file_is_toml_that_means_the_same() {
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/worlds/office-20m.yaml");
    let map = format!("world.map={}", map.display());
    let printed = give(&["config", OFFICE, "--set", &map, "--set", "planner.minimum_clearance_m=0.25"]);
    assert_eq!(printed.code, 0);
    assert!(printed.stdout.contains("minimum_clearance_m = 0.25"), "{}", printed.stdout);
    let path = file("effective", &printed.stdout);
    let again = give(&["config", &path]);
    let values = |text: &str| toml::from_str::<toml::Table>(text).unwrap();
    assert_eq!(again.code, 0, "{}", again.stderr);
    assert_eq!(values(&printed.stdout), values(&again.stdout));
}

#[test]
fn the_schema_knows_the_sections_and_the_plugins() {
    let schema = give(&["schema"]).json();
    assert!(schema["properties"]["planner"].is_object(), "{schema}");
    assert!(schema.to_string().contains("minimum_clearance_m"));
}
