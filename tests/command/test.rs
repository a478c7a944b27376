use super::*;

fn office_with(tests: &str) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    let pipelines = Path::new(root).join("pipelines").display().to_string();
    format!(
        "name = 'short'\ninclude = ['{pipelines}/common/scout.toml']\n\
         [world]\nplugin = 'sim'\nmap = '{pipelines}/worlds/office-20m.yaml'\nstart = {{ x_m = 3.0, y_m = 4.5 }}\n\
         [map_builder]\nplugin = 'static_map'\n[localizer]\nplugin = 'odometry'\n[planner]\nplugin = 'dp'\n\
         [avoider]\nplugin = 'stop_and_replan'\n[mission]\nwaypoints = [{{ x_m = 3.5, y_m = 4.5 }}]\n{tests}"
    )
}

#[test]
fn tests_that_pass_and_fail_are_told_apart_with_the_reason() {
    let text = office_with(
        "[[test]]\nname = 'arrives'\nexpect = { arrives_within_s = 60.0, no_contact = true }\n\
         [[test]]\nname = 'flies'\nseed = 3\nexpect = { arrives_within_s = 0.5 }\n",
    );
    let path = file("tests_differ", &text);
    let given = give(&["test", &path]);
    assert_eq!(given.code, 1);
    assert!(given.stderr.contains("ok   ") && given.stderr.contains("FAIL"), "{}", given.stderr);
    assert!(given.stderr.contains("expected within 0.5 s") && given.stderr.contains("1 passed, 1 failed"));
    let json = give(&["test", &path, "--json"]).json();
    assert_eq!((&json["passed"], &json["failed"]), (&1.into(), &1.into()));
    assert_eq!(
        (&json["tests"][1]["name"], &json["tests"][1]["outcome"]["seed"]),
        (&"flies".into(), &3.into())
    );
    let filtered = give(&["test", &path, "--filter", "arri"]);
    assert_eq!(filtered.code, 0, "{}", filtered.stderr);
}

#[test]
fn a_folder_stands_for_its_pipelines_and_reports_are_written() {
    let text = office_with("[[test]]\nname = 'arrives'\nexpect = { arrives_within_s = 60.0 }\n");
    let path = file("tests_folder", &text);
    let folder = Path::new(&path).parent().unwrap();
    let given =
        give(&["test", folder.to_str().unwrap(), "--reports", folder.join("reports").to_str().unwrap()]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    assert!(folder.join("reports/pipeline.arrives.html").is_file());
}

#[test]
fn nothing_to_test_is_a_fault() {
    let path = file("tests_none", &office_with(""));
    let given = give(&["test", &path]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("nothing to test"), "{}", given.stderr);
    let path = file("tests_filtered", &office_with("[[test]]\nname = 'arrives'\nexpect = {}\n"));
    let given = give(&["test", &path, "--filter", "flies"]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("no [[test]] here has `flies` in its name"), "{}", given.stderr);
}
