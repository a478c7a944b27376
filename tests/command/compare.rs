use super::*;

const TWO_PLANNERS: &[&str] =
    &["compare", OFFICE, "--set", SHORT, "--swap", "planner=dp,a_star", "--seeds", "2"];

/// The sweep of two planners and two seeds into a folder of its own, with more arguments.
fn sweep(folder: &Path, more: &[&str]) -> Given {
    let output = ["--output", folder.to_str().unwrap()];
    give(&[TWO_PLANNERS, &output, more].concat())
}

fn csv(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("results.csv")).unwrap()
}

#[test]
fn the_same_sweep_gives_the_same_bytes_twice_and_with_any_number_of_threads() {
    let folder = scratch("compare_twice");
    let more = ["--set-range", "world.slip.speed=0.0..0.04", "--json", "--threads"];
    let run = |name: &str, threads: &str| {
        let given = sweep(&folder.join(name), &[&more[..], &[threads]].concat());
        assert_eq!(given.code, 0, "{}", given.stderr);
        (csv(&folder.join(name)), given.json())
    };
    let (first, json) = run("first", "1");
    assert_eq!(first, run("again", "1").0);
    assert_eq!(first, run("threads", "2").0);
    assert_eq!(first.lines().count(), 5);
    assert!(first.lines().nth(1).unwrap().starts_with("dp,its own,1,0,0.0"), "{first}");
    assert!(!first.lines().next().unwrap().contains("wall") && !first.contains("cpu"));
    let alternatives = json["alternatives"].as_array().unwrap();
    assert_eq!((alternatives.len(), &alternatives[0]["n"]), (2, &2.into()));
    for figure in [
        "time_s",
        "path_m",
        "detour",
        "turn_deg_m",
        "min_clearance_m",
        "rms_error_m",
        "rms_heading_error_deg",
    ] {
        let mean = &alternatives[1]["figures"][figure];
        assert!(mean["low"].as_f64() <= mean["value"].as_f64(), "{figure}: {mean}");
        assert!(json["differences"][0]["figures"][figure]["n"] == 2, "{figure}");
    }
    let page = std::fs::read_to_string(folder.join("first/report.html")).unwrap();
    for outside in ["http:", "https:", "src=", "<script", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for tag in ["svg", "table", "div", "figure", "p", "h2", "tr", "td", "th"] {
        let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    assert_eq!(std::fs::read_to_string(folder.join("first/timing.csv")).unwrap().lines().count(), 5);
}

#[test]
fn a_sweep_that_was_torn_anywhere_goes_on_to_the_same_result() {
    let folder = scratch("compare_torn");
    assert_eq!(sweep(&folder, &[]).code, 0);
    let (whole, runs) = (csv(&folder), folder.join("runs.jsonl"));
    let lines = std::fs::read(&runs).unwrap();
    let last = lines[..lines.len() - 1].iter().rposition(|byte| *byte == b'\n').unwrap() + 1;
    // Each byte is tested where the journal is read; here, the ends and a place between.
    for length in [last, last + 1, usize::midpoint(last, lines.len()), lines.len() - 1] {
        std::fs::write(&runs, &lines[..length]).unwrap();
        std::fs::remove_file(folder.join("results.csv")).unwrap();
        let given = sweep(&folder, &[]);
        assert_eq!(given.code, 0, "{}", given.stderr);
        assert!(given.stderr.contains("3 of 4 runs are done already"), "{}", given.stderr);
        assert_eq!(csv(&folder), whole);
    }
    let given = sweep(&folder, &["--seeds=3"]);
    assert_eq!(given.code, 2, "an option that stands twice is refused");
    let more = give(&[
        "compare",
        OFFICE,
        "--set",
        SHORT,
        "--swap",
        "planner=dp,a_star",
        "--seeds",
        "3",
        "--output",
        folder.to_str().unwrap(),
    ]);
    assert!(more.code == 0 && more.stderr.contains("4 of 6 runs are done already"), "{}", more.stderr);
}

#[test]
fn another_design_in_the_same_folder_is_refused_with_what_to_do() {
    let folder = scratch("compare_changed");
    assert_eq!(sweep(&folder, &[]).code, 0);
    let before = csv(&folder);
    let given = sweep(&folder, &["--set", "robot.max_speed_m_s=0.15"]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("another design") && given.stderr.contains("--output"), "{}", given.stderr);
    assert_eq!(csv(&folder), before);
    let runs = folder.join("runs.jsonl");
    let text = std::fs::read_to_string(&runs).unwrap();
    std::fs::write(&runs, text.replacen("{\"design\"", "{design", 1)).unwrap();
    let given = sweep(&folder, &[]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("line 1 is damaged"), "{}", given.stderr);
}

#[test]
fn an_alternative_that_cannot_run_is_a_row_with_its_reason() {
    let folder = scratch("compare_fails");
    let given = give(&[
        "compare",
        OFFICE,
        "--set",
        SHORT,
        "--seeds",
        "1",
        "--swap",
        "localizer=recorded_pose,odometry",
        "--output",
        folder.to_str().unwrap(),
        "--json",
    ]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let json = given.json();
    let alternatives = json["alternatives"].as_array().unwrap();
    assert_eq!(alternatives[0]["success"]["value"], 0.0);
    assert!(alternatives[0]["trouble"].is_string(), "{json}");
    assert_eq!(alternatives[1]["ends"]["arrived"], 1);
    assert!(csv(&folder).contains("recorded_pose,its own,1,0,not_built,0,"), "{}", csv(&folder));
    assert!(given.stderr.contains("did not drive:"), "{}", given.stderr);
}

#[test]
fn worlds_bring_their_mission_or_draw_one_that_all_alternatives_share() {
    let folder = scratch("compare_worlds");
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/worlds/office-20m.yaml");
    for name in ["given", "drawn"] {
        std::fs::write(
            folder.join(name).with_extension("toml"),
            format!("map = {:?}\n", map.display().to_string()),
        )
        .unwrap();
    }
    std::fs::write(
        folder.join("given.mission.toml"),
        "[world]\nstart = { x_m = 3.0, y_m = 4.5 }\n[mission]\nwaypoints = [{ x_m = 3.5, y_m = 4.5 }]\n",
    )
    .unwrap();
    let pattern = format!("{}/*.toml", folder.display());
    let output = folder.join("out");
    let given = give(&[
        "compare",
        OFFICE,
        "--set",
        "mission.time_limit_s=20.0",
        "--swap",
        "planner=dp,a_star",
        "--worlds",
        &pattern,
        "--seeds",
        "2",
        "--missions",
        "2",
        "--output",
        output.to_str().unwrap(),
    ]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    let text = csv(&output);
    // Two drawn missions and a given one, two seeds, two planners.
    assert_eq!(text.lines().count(), 1 + 3 * 2 * 2, "{text}");
    assert_eq!(text.matches(",3.000000,4.500000,0.000000,3.500000,4.500000,").count(), 4, "{text}");
    let ends = |line: &str| line.split(',').skip(6).take(5).map(str::to_owned).collect::<Vec<_>>();
    let of = |planner: &str| text.lines().filter(|l| l.starts_with(planner)).map(ends).collect::<Vec<_>>();
    assert_eq!(of("dp,"), of("a_star,"));
    assert_ne!(of("dp,drawn,1,0,"), of("dp,drawn,1,1,"));
    assert_ne!(of("dp,drawn,1,0,"), of("dp,drawn,2,0,"));
}

#[test]
fn faults_of_the_design_are_named_before_anything_runs() {
    let folder = scratch("compare_faults");
    let output = folder.join("out");
    for (args, words) in [
        (&["--swap", "planer=dp"][..], "no such part, did you mean `planner`?"),
        (&["--swap", "sensor.front_lasr=lms200"], "did you mean `sensor.front_laser`?"),
        (&["--swap", "planner=dpp"], "did you mean dp?"),
        (&["--swap", "planner"], "expected SECTION=PLUGIN,PLUGIN"),
        (&["--swap", "planner=dp", "--swap", "planner=a_star"], "stands twice"),
        (&["--worlds", "pipelines/worlds/nothing*.toml"], "no world matches"),
        (&["--seeds", "0"], "0 is not in 1.."),
        (&["--set-range", "world.slip.speed=0.2..0.1"], "is reversed"),
        (&["--set-range", "planner.nothing=0..1"], "unknown key"),
        (&["--set", "planner.nothing=0"], "unknown key"),
    ] {
        let given = give(&[&["compare", OFFICE, "--output", output.to_str().unwrap()], args].concat());
        assert_eq!(given.code, 2, "{args:?}: {}", given.stderr);
        assert!(given.stderr.contains(words), "{args:?}: {}", given.stderr);
        assert!(!output.join("runs.jsonl").exists(), "{args:?}");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupt_ends_the_sweep_and_the_same_command_goes_on() {
    let folder = scratch("compare_interrupt");
    let args = [
        "compare",
        OFFICE,
        "--swap",
        "planner=dp,a_star",
        "--seeds",
        "400",
        "--threads",
        "1",
        "--output",
        folder.to_str().unwrap(),
    ];
    let mut child = rumbo(&args).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let runs = folder.join("runs.jsonl");
    while std::fs::metadata(&runs).map_or(0, |data| data.len()) == 0 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let kept = std::fs::read_to_string(&runs).unwrap();
    let n_kept = kept.lines().count();
    assert!(kept.ends_with('\n') && n_kept < 800 && !kept.contains("interrupted"), "{n_kept}");
    assert_eq!(csv(&folder).lines().count(), n_kept + 1);
}
