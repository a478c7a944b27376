use super::*;

#[test]
fn a_run_prints_one_object_with_the_promised_figures() {
    let folder = scratch("run_json");
    let report = folder.join("a/b/report.html");
    let given =
        give(&["run", OFFICE, "--set", SHORT, "--json", "--report", report.to_str().unwrap(), "--no-report"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let figures = given.json();
    for field in "time_s path_m goal_error_m final_error_m rms_error_m p95_error_m min_clearance_m contacts replans \
                  guard_interventions realtime_factor cpu_world_s cpu_sensors_s cpu_localizer_s cpu_planner_s \
                  cpu_avoider_s cpu_guard_s cpu_map_builders_s"
        .split_whitespace()
    {
        assert!(figures[field].is_number(), "{field}: {figures}");
    }
    assert_eq!((&figures["arrived"], &figures["reason"]), (&true.into(), &"arrived".into()));
    assert!(report.is_file() && std::fs::read_dir(&folder).unwrap().count() == 1);
    assert!(given.stderr.contains("arrived") && given.stderr.contains("report.html"));
}

#[test]
fn without_options_report_and_picture_are_named_after_the_pipeline() {
    let folder = scratch("run_files");
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join(OFFICE);
    let given =
        given(rumbo(&["run", office.to_str().unwrap(), "--set", SHORT, "--quiet"]).current_dir(&folder));
    assert_eq!((given.code, given.stdout.as_str(), given.stderr.as_str()), (0, "", ""));
    let page = std::fs::read_to_string(folder.join("out/office.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains("office crossing"));
    let picture = std::fs::read(folder.join("out/office.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}

#[test]
fn a_robot_that_does_not_arrive_is_no_success_and_says_what_to_try() {
    let given = give(&["run", OFFICE, "--duration", "5", "--no-report"]);
    assert_eq!(given.code, 1, "{}", given.stderr);
    assert!(given.stderr.contains("time limit") && given.stderr.contains("try:"), "{}", given.stderr);
}

#[test]
fn a_goal_in_a_closed_room_is_unreachable_with_the_reason() {
    let given = give(&["run", "pipelines/office_unreachable.toml", "--no-report", "--json"]);
    assert_eq!(given.code, 1, "{}", given.stderr);
    let figures = given.json();
    assert_eq!(figures["reason"], "unreachable");
    assert!(figures["detail"].as_str().unwrap().contains("narrowest passage"), "{figures}");
}

#[test]
fn a_seed_changes_what_chance_decides_and_nothing_else_is_needed() {
    let run = |seed| give(&["run", OFFICE, "--set", SHORT, "--json", "--no-report", "--seed", seed]).json();
    let (first, second) = (run("1"), run("2"));
    assert_eq!((&first["seed"], &second["seed"]), (&1.into(), &2.into()));
    assert_ne!(first["final_error_m"], second["final_error_m"]);
}

#[test]
fn impossible_options_are_refused_with_what_was_expected() {
    for option in [
        "--speed=0",
        "--speed=nan",
        "--duration=-1",
        "--duration=x",
        "--seed=-1",
        "--seed=9223372036854775808",
    ] {
        let given = give(&["run", OFFICE, option]);
        assert_eq!(given.code, 2, "{option}");
    }
}

#[test]
fn a_file_that_cannot_be_written_is_the_commands_own_failure() {
    let folder = scratch("run_not_writable");
    let in_the_way = folder.join("file");
    std::fs::write(&in_the_way, "").unwrap();
    let report = in_the_way.join("report.html");
    let given = give(&["run", OFFICE, "--set", SHORT, "--no-report", "--report", report.to_str().unwrap()]);
    assert_eq!(given.code, 3);
    assert!(given.stderr.contains("report.html"), "{}", given.stderr);
}

#[test]
#[cfg(unix)]
fn an_interrupt_stops_the_robot_and_still_says_how_it_went() {
    let mut command = rumbo(&["run", OFFICE, "--speed", "1", "--no-report", "--json"]);
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut child = command.spawn().unwrap();
    let pid = child.id().to_string();
    // The handler is set before the robot drives; ask again until the run has ended.
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(std::time::Duration::from_millis(400));
        Command::new("kill").args(["-INT", &pid]).status().unwrap();
    };
    assert_eq!(status.code(), Some(130));
    let output = child.wait_with_output().unwrap();
    let figures: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(figures["reason"], "interrupted");
}

#[test]
fn a_report_shows_the_last_plan_as_its_planner_saw_it_also_where_it_failed() {
    let folder = scratch("run_drawings");
    let report = folder.join("report.html");
    let shown = |more: &[&str]| {
        let path = report.to_str().unwrap();
        let mut words = vec![
            "run",
            "pipelines/warehouse_charges.toml",
            "--duration",
            "1",
            "--no-report",
            "--report",
            path,
        ];
        words.extend(more);
        give(&words);
        let page = std::fs::read_to_string(&report).unwrap();
        ["levels of the potential", "fictitious charge", "way before it was straightened"]
            .map(|words| page.contains(&format!("{words}</li>")))
    };
    assert_eq!(shown(&[]), [true; 3]);
    // The walk without charges ends in front of a rack, and another planner drives.
    assert_eq!(shown(&["--set", "planner.plugin=potential_field"]), [true, false, true]);
}
