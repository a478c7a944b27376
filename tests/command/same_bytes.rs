use super::*;

/// The figures but for those that measure wall time.
fn figures(threads: Option<&str>, pipeline: &str) -> String {
    let mut command = rumbo(&["run", pipeline, "--json", "--no-report"]);
    if let Some(threads) = threads {
        command.env("RAYON_NUM_THREADS", threads);
    }
    let given = given(&mut command);
    let measured = |line: &&str| line.contains("\"realtime_factor\"") || line.contains("\"cpu_");
    let (times, kept): (Vec<&str>, Vec<&str>) = given.stdout.lines().partition(measured);
    assert!(times.len() >= 8 && kept.len() >= 18, "{}", given.stdout);
    kept.join("\n")
}

#[test]
fn the_same_pipeline_gives_the_same_bytes_twice_and_with_any_number_of_threads() {
    for pipeline in [OFFICE, "pipelines/office_blocked.toml", "pipelines/follow_person.toml"] {
        let first = figures(None, pipeline);
        for threads in [None, Some("1"), Some("2")] {
            assert_eq!(figures(threads, pipeline), first, "{pipeline} with {threads:?}");
        }
    }
}

#[test]
fn a_saved_run_is_the_same_twice_but_for_the_times() {
    let folder = scratch("saved_twice");
    let saved = |name: &str| {
        let path = folder.join(name);
        let path = path.to_str().unwrap();
        assert_eq!(give(&["run", OFFICE, "--set", SHORT, "--no-report", "--save-run", path]).code, 0);
        let mut run: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let outcome = run["outcome"].as_object_mut().unwrap();
        outcome.retain(|key, _| key != "realtime_factor" && !key.starts_with("cpu_"));
        run
    };
    assert_eq!(saved("a.json"), saved("b.json"));
}
