use super::*;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng as _, SeedableRng};
use std::path::PathBuf;

const GOOD: &str = r#"
name = "office ä"
seed = 7
plugin_path = []

[robot]
drive = { kind = "differential", track_m = 0.36 } # wheels
radius_m = 2.0e-1
hex = 0x1F

[[sensor]]
name = "front"
plugin = "laser"
mount = { x_m = -0.1, z_m = 0.30 }

[[sensor]]
name = "wheels"
plugin = "encoders"
on = 1979-05-27T07:32:00Z

[planner]
plugin = "dp"
weights = [1.0, 2, +3.5]
text = """
two
lines"""
variants.a_star.clearance_m = 0.2

[mission]
waypoints = [{ x_m = 15.0, y_m = 12.0 }, { x_m = 1_000.0, y_m = -2 }]
"#;

fn load(text: &str, sets: &[&str]) -> (Document, Vec<String>) {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let (document, mut faults) = Document::from_text(Path::new("a.toml"), text, &sets);
    faults.sort();
    let lines = faults.lines(&document.sources);
    (document, lines)
}

/// A folder that is gone when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, files: &[(&str, &str)]) -> Folder {
        let folder = std::env::temp_dir().join(format!("rumbo-document-{}-{name}", std::process::id()));
        for (file, text) in files {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Folder(folder)
    }

    fn load(&self, file: &str) -> (Document, Vec<String>) {
        let (document, faults) = Document::load(&self.0.join(file), &[]);
        let folder = format!("{}/", self.0.display());
        let lines = faults.lines(&document.sources).iter().map(|line| line.replace(&folder, "")).collect();
        (document, lines)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_good_file_reads_as_the_toml_crate_reads_it() {
    let (document, lines) = load(GOOD, &[]);
    assert_eq!(lines, Vec::<String>::new());
    let expected: toml::Table = toml::from_str(GOOD).unwrap();
    assert_eq!(document.root.as_table().unwrap().to_toml(), expected);
}

#[test]
fn values_and_keys_know_their_places() {
    let (document, _) = load(GOOD, &[]);
    let node = document.root.nearest("planner.weights[2]");
    assert_eq!(&GOOD[node.origin.start..node.origin.end], "+3.5");
    let node = document.root.nearest("robot.drive.track_m");
    assert_eq!(&GOOD[node.place().start..node.place().end], "track_m");
    assert_eq!(document.sources.line_column(node.origin), Some((7, 44)));
    let section = document.root.nearest("mission");
    assert_eq!(&GOOD[section.place().start..section.place().end], "mission");
}

#[test]
fn keys_keep_the_order_of_the_file() {
    let (document, _) = load("z = 1\na = 2\n[m]\n[b]\n", &[]);
    let keys: Vec<&str> = document.root.as_table().unwrap().iter().map(|(key, _)| key).collect();
    assert_eq!(keys, ["z", "a", "m", "b"]);
}

#[test]
fn every_syntax_error_is_reported_and_the_rest_is_read() {
    let (document, lines) = load("a = \nb = 2\nc = 'x\nd = 4\na = 5\n", &[]);
    assert!(lines.len() >= 3, "{lines:#?}");
    assert!(lines[0].starts_with("a.toml:1:"), "{lines:#?}");
    assert!(lines.iter().any(|line| line.starts_with("a.toml:3:")), "{lines:#?}");
    assert!(lines.iter().any(|line| line.contains("duplicate key")), "{lines:#?}");
    assert_eq!(document.root.nearest("d").as_f64(), Some(4.0));
}

#[test]
fn numbers_that_no_machine_holds_are_refused_with_their_place() {
    let (_, lines) = load("a = 99999999999999999999\n[p]\nb = [1.0, nan]\nc = -inf\nd = 1e999\n", &[]);
    assert_eq!(
        lines,
        [
            "a.toml:1:5 a: is 99999999999999999999, expected a whole number of at most 64 bits with sign",
            "a.toml:3:11 p.b[1]: is NaN, expected a finite number",
            "a.toml:4:5 p.c: is -inf, expected a finite number",
            "a.toml:5:5 p.d: is inf, expected a finite number",
        ]
    );
}

#[test]
fn brackets_without_end_are_refused_not_recursed_into() {
    let text = format!("a = {}", "[".repeat(100_000));
    let (_, lines) = load(&text, &[]);
    assert_eq!(lines, ["a.toml:1:65 brackets are nested more than 60 deep"]);
    let dots = format!("{} = 1", vec!["a"; 50_000].join("."));
    assert_eq!(load(&dots, &[]).1.len(), 1);
    assert_eq!(load("a = 1", &[&dots]).1.len(), 1);
}

#[test]
fn a_random_document_survives_the_way_through_nodes_and_print() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for round in 0..300 {
        let table = random_table(&mut rng, 3);
        let text = toml::to_string(&table).unwrap();
        let (document, lines) = load(&text, &[]);
        assert_eq!(lines, Vec::<String>::new(), "round {round}: {text}");
        assert_eq!(document.root.as_table().unwrap().to_toml(), table, "round {round}");
        let printed = to_commented_toml(&document.root, &document.sources);
        let again: toml::Table =
            toml::from_str(&printed).unwrap_or_else(|e| panic!("{round}: {e}\n{printed}"));
        assert_eq!(again, table, "round {round}: {printed}");
    }
}

fn random_table(rng: &mut Xoshiro256PlusPlus, depth: u32) -> toml::Table {
    let n_keys = rng.next_u32() % 5;
    (0..n_keys).map(|_| (random_text(rng), random_value(rng, depth))).collect()
}

fn random_text(rng: &mut Xoshiro256PlusPlus) -> String {
    let letters: Vec<char> = "abz_-09 .\"'\\\n\tä€#=[]{}\u{7f}\u{1}".chars().collect();
    (0..1 + rng.next_u32() % 6).map(|_| letters[rng.next_u32() as usize % letters.len()]).collect()
}

fn random_value(rng: &mut Xoshiro256PlusPlus, depth: u32) -> toml::Value {
    let n_items = rng.next_u32() % 4;
    match rng.next_u32() % if depth == 0 { 5 } else { 8 } {
        0 => toml::Value::Integer(rng.next_u64() as i64),
        1 => toml::Value::Float(f64::from(rng.next_u32()) / 7.0 - 1e8),
        2 => toml::Value::Boolean(rng.next_u32().is_multiple_of(2)),
        3 => toml::Value::Datetime("2026-11-23T12:00:00Z".parse().unwrap()),
        4 => toml::Value::String(random_text(rng)),
        5 => toml::Value::Array((0..n_items).map(|_| random_value(rng, depth - 1)).collect()),
        6 => toml::Value::Array((0..n_items).map(|_| random_table(rng, depth - 1).into()).collect()),
        _ => toml::Value::Table(random_table(rng, depth - 1)),
    }
}

#[test]
fn a_mutilated_file_gives_faults_never_a_panic() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut n_faulty = 0;
    for _ in 0..3_000 {
        let mut bytes = GOOD.as_bytes().to_vec();
        for _ in 0..1 + rng.next_u32() % 4 {
            let at = rng.next_u64() as usize % bytes.len();
            match rng.next_u32() % 4 {
                0 => bytes[at] = rng.next_u32() as u8,
                1 if bytes.len() > 1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, b"[]{}\"'=.,#\n\xff"[rng.next_u32() as usize % 12]),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        let (document, lines) = load(&text, &["planner.plugin=a_star", "sensor.front.rate_hz=5"]);
        n_faulty += usize::from(!lines.is_empty());
        let _ = to_commented_toml(&document.root, &document.sources);
    }
    assert!(n_faulty > 1_000, "{n_faulty}");
}

#[test]
fn set_changes_adds_and_addresses_sensors_by_name_and_index() {
    let sets = [
        "planner.weights=[9.0]",
        "planner.new.deep=true",
        "sensor.front.mount.x_m = 0.5",
        "sensor[1].rate_hz=20",
        "sensor.0.rate_hz=10",
        "world.map=worlds/a b.yaml",
        "name=\"two words\"",
    ];
    let (document, lines) = load(GOOD, &sets);
    assert_eq!(lines, Vec::<String>::new());
    let value = |path: &str| document.root.nearest(path).to_toml().to_string();
    assert_eq!(value("planner.weights"), "[9.0]");
    assert_eq!(value("planner.new.deep"), "true");
    assert_eq!(value("sensor[0].mount.x_m"), "0.5");
    assert_eq!(value("sensor[1].rate_hz"), "20");
    assert_eq!(value("sensor[0].rate_hz"), "10");
    assert_eq!(value("world.map"), "\"worlds/a b.yaml\"");
    assert_eq!(value("name"), "\"two words\"");
    let origin = document.root.nearest("planner.weights[0]").origin;
    assert_eq!(document.sources.line_column(origin), Some((1, 18)));
    assert_eq!(document.sources.short(origin), "--set");
}

#[test]
fn a_swap_of_the_plugin_leaves_the_old_plugins_keys_behind() {
    let sets = ["planner.clearance_m=0.3", "planner.plugin=a_star"];
    let (document, lines) = load(GOOD, &sets);
    assert_eq!(lines, Vec::<String>::new());
    let planner = document.root.nearest("planner").as_table().unwrap();
    let keys: Vec<&str> = planner.iter().map(|(key, _)| key).collect();
    assert_eq!(keys, ["plugin", "variants", "clearance_m"]);
    let (document, _) = load(GOOD, &["planner.plugin=dp"]);
    assert!(document.root.nearest("planner").get("weights").is_some(), "the same plugin is no swap");
}

#[test]
fn a_bad_argument_is_its_own_source() {
    let sets = [
        "planner",
        "=5",
        "planner.weights=0.2m",
        "sensor.frnt.rate_hz=5",
        "name.x=1",
        "planner.weights[7]=1",
    ];
    let (_, lines) = load(GOOD, &sets);
    let starts = [
        "--set planner:1:1 has no `=`, expected KEY=VALUE; write --set planner.minimum_clearance_m=0.2",
        "--set =5:1:1 has an empty key",
        "--set planner.weights=0.2m:1:20 planner.weights: `0.2m` is no TOML value: ",
        "--set sensor.frnt.rate_hz=5:1:1 sensor.frnt.rate_hz: no sensor is called `frnt`, did you mean front?",
        "--set name.x=1:1:1 name.x: leads into `name`, which is \"office ä\", not a table",
        "--set planner.weights[7]=1:1:1 planner.weights[7]: `planner.weights` has 3 items",
    ];
    assert_eq!(lines.len(), starts.len(), "{lines:#?}");
    for (line, start) in lines.iter().zip(starts) {
        assert!(line.starts_with(start), "{line}\n{start}");
    }
    let (_, lines) = load("name = 'x'", &["sensor.front.rate_hz=5"]);
    assert!(lines[0].contains("a pipeline without sensors"), "{lines:#?}");
}

#[test]
fn includes_lie_below_the_including_file_and_later_ones_above_earlier() {
    let folder = Folder::new(
        "merge",
        &[
            (
                "main.toml",
                "include = ['parts/a.toml', 'parts/b.toml']\n[robot]\nx = 'main'\n[[sensor]]\nname = 'l'\nrate_hz = 3\n[[sensor]]\nname = 'new'\n",
            ),
            (
                "parts/a.toml",
                "seed = 1\n[robot]\nx = 'a'\ny = 'a'\nz = 'a'\ncorners = [1, 2]\n[[sensor]]\nname = 'l'\nrate_hz = 1\nplugin = 'p'\n",
            ),
            ("parts/b.toml", "include = ['deep/c.toml']\nseed = 2\n[robot]\ny = 'b'\ncorners = [3]\n"),
            ("parts/deep/c.toml", "[robot]\nw = 'c'\ny = 'c'\n"),
        ],
    );
    let (document, lines) = folder.load("main.toml");
    assert_eq!(lines, Vec::<String>::new());
    let expected = "seed = 2\n[robot]\nx = 'main'\ny = 'b'\nz = 'a'\nw = 'c'\ncorners = [3]\n\
        [[sensor]]\nname = 'l'\nrate_hz = 3\nplugin = 'p'\n[[sensor]]\nname = 'new'\n";
    assert_eq!(document.root.as_table().unwrap().to_toml(), toml::from_str::<toml::Table>(expected).unwrap());
    let short = document.sources.short(document.root.nearest("robot.w").origin);
    assert!(short.ends_with("parts/deep/c.toml:2"), "{short}");
}

#[test]
fn a_file_that_includes_itself_is_refused_with_the_chain() {
    let folder = Folder::new(
        "cycle",
        &[("a.toml", "include = ['b.toml']\nx = 1"), ("b.toml", "include = './a.toml'\ny = 2")],
    );
    let (document, lines) = folder.load("a.toml");
    assert_eq!(
        lines,
        [
            "b.toml:1:11 include: a file includes itself: a.toml -> b.toml -> ./a.toml; remove one of these includes"
        ]
    );
    assert_eq!(document.root.nearest("y").as_f64(), Some(2.0), "the rest is read all the same");
}

#[test]
fn a_file_may_be_included_twice_by_different_ways() {
    let folder = Folder::new(
        "diamond",
        &[
            ("a.toml", "include = ['b.toml', 'c.toml']"),
            ("b.toml", "include = ['d.toml']"),
            ("c.toml", "include = ['d.toml']"),
            ("d.toml", "x = 1"),
        ],
    );
    let (document, lines) = folder.load("a.toml");
    assert_eq!((lines.len(), document.root.nearest("x").as_f64()), (0, Some(1.0)));
}

#[test]
fn files_that_cannot_be_read_are_reported_where_they_are_named() {
    let folder = Folder::new("missing", &[("a.toml", "include = ['no.toml', 3, 'sub']\n"), ("sub/x", "")]);
    std::fs::write(folder.0.join("latin.toml"), b"name = '\xe4'").unwrap();
    let (_, lines) = folder.load("a.toml");
    assert_eq!(lines.len(), 3, "{lines:#?}");
    assert!(lines[0].starts_with("a.toml:1:23 include[1]: is 3, expected the path"), "{lines:#?}");
    assert!(lines[1].starts_with("a.toml:1:12 include: cannot read no.toml: "), "{lines:#?}");
    assert!(lines[2].contains("cannot read sub: it is a folder"), "{lines:#?}");
    let (_, lines) = folder.load("latin.toml");
    assert_eq!(
        lines,
        ["cannot read the pipeline file latin.toml: byte 8 is not UTF-8 text, expected a TOML file"]
    );
}

#[test]
fn the_effective_document_names_the_origin_of_each_value() {
    let text =
        "name = 'x'\n[planner]\nplugin = 'dp'\nmount = { x_m = 1.0 }\n[mission]\nwaypoints = [{ x_m = 1 }]\n";
    let (mut document, _) = load(text, &["planner.a=2"]);
    let defaults: toml::Table = toml::from_str("planner = { mount = { x_m = 0.0, y_m = 0.5 } }").unwrap();
    fill_defaults(&mut document.root, &defaults);
    let expected = "name = \"x\" # a.toml:1\n\n[planner]\nplugin = \"dp\" # a.toml:3\n\
        mount.x_m = 1.0 # a.toml:4\nmount.y_m = 0.5 # default\na = 2 # --set\n\n[mission]\nwaypoints = [\n  \
        { x_m = 1 }, # a.toml:6\n]\n";
    assert_eq!(to_commented_toml(&document.root, &document.sources), expected);
    let json = to_json(&document.root, &document.sources);
    assert_eq!(json["pipeline"]["planner"]["mount"]["y_m"], 0.5);
    assert_eq!(json["origins"]["planner.mount.y_m"], "default");
    assert_eq!(json["origins"]["mission.waypoints[0].x_m"], "a.toml:6");
}
