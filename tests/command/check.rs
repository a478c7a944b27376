use super::*;

#[test]
fn the_shipped_pipelines_have_no_faults() {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let given = give(&["check", path.to_str().unwrap()]);
            assert_eq!(given.code, 0, "{}", given.stderr);
            assert!(!given.stderr.contains("warning["), "{}", given.stderr);
        }
    }
}

/// The source's own turn between insertions, 0.9 rad, leaves 9.5 % of overlap to its camera of 57 degrees.
#[test]
fn a_turn_beyond_the_view_of_the_camera_is_a_warning_at_its_line_and_the_pipeline_runs() {
    let camera = "pipelines/finder_depth_camera.toml";
    let wide = ["--set", "slam.map_update_angle_deg=51.6"];
    let told = "warning[doubtful]: slam.map_update_angle_deg: is 51.6, more than a quarter of the 57 degrees";
    let checked = give(&[["check", camera], wide].concat());
    assert_eq!(checked.code, 0, "{}", checked.stderr);
    assert!(checked.stderr.contains(told) && checked.stderr.contains("no faults"), "{}", checked.stderr);
    let json = give(&[&["check", camera, "--json"][..], &wide].concat()).json();
    assert_eq!(json[0]["warnings"][0]["code"], "doubtful");
    assert_eq!(json[0]["warnings"][0]["help"], "write 14.2 or less");
    assert_eq!(json[0]["faults"].as_array().unwrap().len(), 0);
    let run = give(&[&["run", camera, "--no-report", "--duration", "0.2"][..], &wide].concat());
    assert!(run.stderr.contains(told), "{}", run.stderr);
    // A scanner of 270 degrees sees enough, and a default is nobody's mistake.
    let laser = give(&[["check", "pipelines/finder_lidar_fast.toml"], wide].concat());
    assert!(!laser.stderr.contains("warning"), "{}", laser.stderr);
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
