use super::*;

/// Five poses on a bent way, as `t x y theta`.
const TRUTH: &str = "10 0 0 0\n11 1 0 0\n12 2 0 0.5\n13 2.8 0.6 1.0\n14 3 1.5 1.5\n";

/// Files in a folder of this test's own.
struct Files(PathBuf);

impl Files {
    fn new(name: &str) -> Files {
        Files(scratch(&format!("eval_{name}")))
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.0.join(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }

    /// A map from a picture of `#`, `.` and spaces; the first line is the top.
    fn map(&self, name: &str, lines: &[&str], keys: &str) -> String {
        let gray = |letter| match letter {
            '#' => 0_u8,
            '.' => 254,
            _ => 205,
        };
        let mut picture = format!("P5\n{} {}\n255\n", lines[0].len(), lines.len()).into_bytes();
        picture.extend(lines.iter().flat_map(|line| line.chars().map(gray)));
        self.write(&format!("{name}.pgm"), picture);
        self.write(&format!("{name}.yaml"), format!("image: {name}.pgm\n{keys}\n"))
    }
}

/// A number somewhere in the figures.
fn number(figures: &serde_json::Value, pointer: &str) -> f64 {
    figures
        .pointer(pointer)
        .and_then(serde_json::Value::as_f64)
        .unwrap_or_else(|| panic!("{pointer}: {figures}"))
}

/// It must refuse with code 2, nothing on standard output, and these words.
fn refuses(args: &[&str], words: &[&str]) {
    let given = give(args);
    assert_eq!((given.code, given.stdout.as_str()), (2, ""), "{args:?}: {}", given.stderr);
    for word in words {
        assert!(given.stderr.contains(word), "{args:?}: {word}: {}", given.stderr);
    }
}

#[test]
fn a_trajectory_beside_itself_moved_and_turned_has_no_error_once_aligned() {
    let files = Files::new("moved");
    let truth = files.write("truth.txt", TRUTH);
    // Turned by a quarter and moved by (5, -3): (x, y) becomes (5 - y, x - 3).
    let moved: String = TRUTH
        .lines()
        .map(|line| {
            let [t, x, y, yaw] = line
                .split(' ')
                .map(|word| word.parse::<f64>().unwrap())
                .collect::<Vec<_>>()
                .try_into()
                .unwrap();
            format!("{} {} {} {}\n", t + 0.004, 5.0 - y, x - 3.0, yaw + std::f64::consts::FRAC_PI_2)
        })
        .collect();
    let moved = files.write("moved.txt", moved);
    for how in ["se3", "sim3", "yaw", "first"] {
        let given = give(&["eval", "trajectory", &moved, &truth, "--align", how, "--json"]);
        assert_eq!(given.code, 0, "{}", given.stderr);
        let figures = given.json();
        assert_eq!(figures["n_pairs"], 5);
        for pointer in ["/ate_m/max", "/rpe_m/max", "/rpe_rad/max"] {
            assert!(number(&figures, pointer) < 1e-7, "{how} {pointer}: {figures}");
        }
        assert!((number(&figures, "/scale") - 1.0).abs() < 1e-9);
    }
    let as_it_is = give(&["eval", "trajectory", &moved, &truth, "--align", "none", "--json"]).json();
    // The pose at the origin is moved farthest.
    assert!((number(&as_it_is, "/ate_m/max") - 34.0_f64.sqrt()).abs() < 1e-9);
    assert!(number(&as_it_is, "/ate_m/rmse") > 3.0 && number(&as_it_is, "/rpe_m/max") < 1e-7);
}

#[test]
fn people_get_a_table_and_a_picture_and_programs_get_nothing_else() {
    let files = Files::new("table");
    let truth = files.write("truth.txt", TRUTH);
    let estimate = files.write("estimate.txt", TRUTH.replace("2.8 0.6", "2.9 0.6"));
    let picture = files.0.join("a/both.png");
    let given = give(&[
        "eval",
        "trajectory",
        &estimate,
        &truth,
        "--align",
        "none",
        "--picture",
        picture.to_str().unwrap(),
        "--rpe-delta",
        "2",
        "--rpe-unit",
        "s",
        "--rpe-pairs",
        "overlapping",
    ]);
    assert_eq!((given.code, given.stdout.as_str()), (0, ""), "{}", given.stderr);
    for words in
        ["5 of 5 and 5 poses", "100.0 % of the truth's time", "ATE, m", "0.100000", "RPE rotation, deg"]
    {
        assert!(given.stderr.contains(words), "{words}: {}", given.stderr);
    }
    assert!(image::open(&picture).unwrap().width() > 1000);
}

#[test]
fn trajectories_that_cannot_be_compared_are_refused_with_what_to_do() {
    let files = Files::new("faults");
    let truth = files.write("truth.txt", TRUTH);
    let refuse = |estimate: &str, more: &[&str], words: &[&str]| {
        refuses(&[&["eval", "trajectory", estimate, &truth], more].concat(), words);
    };
    refuse("no/such.txt", &[], &["no/such.txt: cannot read the file", "plain or gzip"]);
    refuse(&files.0.display().to_string(), &[], &["is a folder"]);
    refuse(&files.write("empty.txt", ""), &[], &["the file is empty"]);
    refuse(&files.write("word.txt", "10 0 0 0\n11 x 0 0\n"), &[], &["word.txt:2: pose.x is `x`"]);
    refuse(&files.write("nan.txt", "10 nan 0 0\n11 inf 0 0\n"), &[], &["no pose (2 lines were left out"]);
    let other = files.write("other.txt", "100 0 0 0\n101 1 0 0\n");
    let ranges =
        ["no two stamps closer than 0.02 s", "from 100.000000 s to 101", "5 poses from 10.000000 s to 14"];
    refuse(&other, &[], &ranges);
    refuse(&files.write("one.txt", "10 0 0 0\n20 1 0 0\n"), &[], &["only one pair", "at least 2 pairs"]);
    let line = files.write("line.txt", "10 0 0 0\n11 1 0 0\n12 2 0 0\n");
    refuse(&line, &[], &["on one line", "align with `yaw`"]);
    let still = files.write("still.txt", "10 1 2 0\n11 1 2 0\n12 1 2 0\n");
    refuse(&still, &["--align", "yaw"], &["the estimate stays in one place"]);
    let kitti = files.write("kitti.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n");
    refuse(&kitti, &[], &["kitti.txt has no stamps", "--times"]);
    refuses(&["eval", "trajectory", &kitti, &kitti, "--rpe-unit", "s"], &["needs stamps", "--times"]);
    refuse(&truth, &["--rpe-delta", "1.5"], &["a whole number of frames"]);
    for option in ["--max-gap=0", "--max-gap=nan", "--rpe-delta=-1", "--align=best", "--rpe-unit=feet"] {
        refuse(&truth, &[option], &[option.split('=').next().unwrap()]);
    }
}

#[test]
fn what_was_mended_in_a_file_is_told_and_not_an_error() {
    let files = Files::new("mended");
    let truth = files.write("truth.txt", TRUTH);
    let mixed =
        files.write("mixed.txt", "11 1 0 0\n10 0 0 0\n12 nan 0 0\n13 2.8 0.6 1.0\n13 9 9 9\n14 3 1.5 1.5\n");
    let given = give(&["eval", "trajectory", &mixed, &truth, "--align", "none", "--rpe-delta", "9"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
    for words in
        ["step backwards in 1 places", "first line 3: pose.x is NaN", "1 of 5 poses have the stamp", "no RPE"]
    {
        assert!(given.stderr.contains(words), "{words}: {}", given.stderr);
    }
}

#[test]
fn relations_are_judged_from_poses_and_with_odometry_between_them() {
    let files = Files::new("relations");
    let relations = files.write("relations.txt", "1 2 1 0 0 0 0 0\n1 3 2.1 0 0 0 0 0.1\n3 4 1 0 0 0 0 0\n");
    let poses = files.write("poses.txt", "1 5 5 0\n3 7 5 0\n");
    let log: String = (0..5).map(|t| format!("ODOM {t} 0 0 1 0 0 {t}.0 x 0\n")).collect();
    let log = files.write("robot.log", log);
    let sparse = give(&["eval", "relations", &poses, &relations, "--json"]).json();
    assert_eq!((&sparse["n_used"], &sparse["n_relations"]), (&1.into(), &3.into()));
    // Seen from the true second pose, which is turned by 0.1.
    assert!((number(&sparse, "/translation_m/mean") - 0.1).abs() < 1e-9);
    assert!((number(&sparse, "/rotation_rad/mean") - 0.1).abs() < 1e-9);
    assert!((number(&sparse, "/translation_squared_m2/mean") - 0.01).abs() < 1e-9);
    let dense = give(&["eval", "relations", &poses, &relations, "--odometry", &log, "--json"]).json();
    assert_eq!(dense["n_used"], 3);
    assert!((number(&dense, "/translation_m/mean") - 0.1 / 3.0).abs() < 1e-9);
    let raw = give(&["eval", "relations", &log, &relations, "--format", "odometry"]);
    assert_eq!((raw.code, raw.stdout.as_str()), (0, ""));
    assert!(raw.stderr.contains("3 of 3 have both poses") && raw.stderr.contains(" +- "), "{}", raw.stderr);
}

#[test]
fn a_run_on_a_log_is_judged_by_relations_in_the_logs_own_time() {
    let files = Files::new("run_relations");
    // Along x by 10 cm every half a second, from stamp 1000 on.
    let line = |k: usize| {
        let (x, stamp) = (0.1 * k as f64, 1000.0 + 0.5 * k as f64);
        format!("FLASER 3 1.0 1.0 1.0 {x:.3} 0 0 {x:.3} 0 0 {stamp:.3} robot {stamp:.3}\n")
    };
    let log = files.write("way.clf", (0..20).map(line).collect::<String>());
    let relations = files
        .write("r.txt", "1000.5 1005 0.9 0 0 0 0 0\n1001 1009.5 1.7 0 0 0 0 0\n1001 1002 0.5 0 0 0 0 0\n");
    let poses = files.0.join("poses.txt").display().to_string();
    let set = format!("world.file={log}");
    let run =
        ["run", "pipelines/mapping_log.toml", "--set", &set, "--poses", &poses, "--no-report", "--quiet"];
    let ran = give(&run);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(std::fs::read_to_string(&poses).unwrap().starts_with("0.500000 0.100000 0.000000 "));
    let judged = give(&["eval", "relations", &poses, &relations, "--since", &log, "--json"]).json();
    assert_eq!(judged["n_used"], 3);
    // The third one says 50 cm where there were 20.
    assert!((number(&judged, "/translation_m/mean") - 0.1).abs() < 1e-5, "{judged}");
    refuses(&["eval", "relations", &poses, &relations], &["none of 3 relations"]);
    refuses(&["eval", "relations", &poses, &relations, "--since", &poses], &["no record found"]);
}

#[test]
fn relations_that_cannot_be_judged_are_refused_with_what_to_do() {
    let files = Files::new("relation_faults");
    let (poses, relations) = (files.write("poses.txt", TRUTH), files.write("r.txt", "1 2 1 0 0 0 0 0\n"));
    let none = ["none of 1 relations", "from 1.000000 s to 2.000000 s", "from 10.000000 s", "--odometry LOG"];
    refuses(&["eval", "relations", &poses, &relations], &none);
    refuses(
        &["eval", "relations", &poses, &files.write("bad.txt", "1 2 3\n")],
        &["bad.txt:1: relation.y is missing"],
    );
    refuses(&["eval", "relations", &poses, "no/such.relations"], &["no/such.relations: cannot read"]);
    refuses(&["eval", "relations", &poses, &relations, "--odometry", &poses], &["no record found", "CARMEN"]);
    let kitti = files.write("kitti.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
    refuses(&["eval", "relations", &kitti, &relations], &["has no stamps"]);
}

#[test]
fn a_map_is_judged_by_its_walls_and_its_area() {
    let files = Files::new("maps");
    let keys = "resolution: 0.5\norigin: [1.0, 2.0, 0.0]";
    let reference = files.map("reference", &["#.......#", "#.......#"], keys);
    let map = files.map("map", &["#..#.... ", "#.......#"], keys);
    let figures = give(&["eval", "map", &map, &reference, "--tolerance", "0.4", "--json"]).json();
    assert_eq!((number(&figures, "/precision"), number(&figures, "/recall")), (0.75, 0.75));
    assert_eq!(number(&figures, "/reference_to_map/max_m"), 0.5);
    assert_eq!(number(&figures, "/agreement"), 16.0 / 17.0);
    let usual = give(&["eval", "map", &map, &reference]);
    assert_eq!((usual.code, usual.stdout.as_str()), (0, ""));
    for words in ["75.00 % within 1.000 m", "100.00 % within 1.000 m", "94.44 % of what the reference knows"]
    {
        assert!(usual.stderr.contains(words), "{words}: {}", usual.stderr);
    }
}

#[test]
fn maps_that_cannot_be_compared_are_refused_with_what_to_do() {
    let files = Files::new("map_faults");
    let keys = "resolution: 0.5\norigin: [0, 0, 0]";
    let (map, open) = (files.map("map", &["#."], keys), files.map("open", &[".."], keys));
    refuses(&["eval", "map", &map, &open], &["the reference has no occupied cell"]);
    refuses(&["eval", "map", &open, &map], &["the map has no occupied cell"]);
    let far = files.map("far", &["#."], "resolution: 0.5\norigin: [1e9, 0, 0]");
    refuses(&["eval", "map", &map, &far], &["lie too far apart", "in the same frame"]);
    refuses(&["eval", "map", &map, "no/map.yaml"], &["no/map.yaml: cannot read the map file"]);
    let broken = files.map("broken", &["#."], "resolution: -1\norigin: [0, 0, 0]");
    refuses(&["eval", "map", &map, &broken], &["resolution is -1"]);
    refuses(&["eval", "map", &map, &map, "--tolerance", "0"], &["--tolerance"]);
}

#[test]
fn a_pose_graph_is_optimized_from_every_start() {
    let files = Files::new("graph");
    // A square that closes but for 0.1 m.
    let edge =
        |from: u32, to: u32, x: f64| format!("EDGE_SE2 {from} {to} {x} 0 1.5707963267948966 1 0 0 1 0 1\n");
    let text = edge(0, 1, 1.0) + &edge(1, 2, 1.0) + &edge(2, 3, 1.0) + &edge(3, 0, 1.1);
    let graph = give(&["eval", "graph", &files.write("square.g2o", text), "--json"]).json();
    assert_eq!((&graph["n_poses"], &graph["n_constraints"]), (&4.into(), &4.into()));
    let costs = ["/starts/0/cost", "/starts/1/cost"].map(|pointer| number(&graph, pointer));
    assert!((costs[0] - costs[1]).abs() < 1e-9 && costs[0] > 1e-4 && costs[0] < 0.01, "{costs:?}");
    refuses(
        &["eval", "graph", &files.write("bad.g2o", "EDGE_SE2 0\n")],
        &["bad.g2o:1: EDGE_SE2.to is missing"],
    );
}
