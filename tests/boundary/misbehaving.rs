//! Plugins that go wrong while the robot drives: the stage is named, the robot stops, and nothing else breaks.

use crate::compiler::{self, Language};
use crate::runs::{self, Told};
use rumbo_core::boundary::host::on_log;
use rumbo_core::engine::{EndReason, RunEnd};
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock};

static CALLS: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn library() -> &'static PathBuf {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        on_log(|log| {
            if log.target == "misbehaving" {
                CALLS.lock().unwrap().push(log.message.clone());
            }
        });
        let source = compiler::root().join("tests/boundary/fixtures/misbehaving.c");
        compiler::library(&source, Language::C, &[], "misbehaving")
    })
}

/// How often a function of a plugin was called with this parameter.
fn n_calls(stage: &str, how: &str, function: &str) -> usize {
    let call = format!("bad_{stage} {how} {function}");
    CALLS.lock().unwrap().iter().filter(|said| **said == call).count()
}

fn section(stage: &str) -> &str {
    if stage == "builder" { "map_builder" } else { stage }
}

fn try_run(stage: &str, how: &str) -> Result<(Told, RunEnd), String> {
    let registry = runs::registry(&[library()]);
    let line = format!("plugin = \"bad_{stage}\"\nhow = \"{how}\"");
    let mut others = vec![(section(stage), line.as_str())];
    if stage == "builder" {
        // Ours would start on an empty map and refuse every goal.
        others.push(("planner", "plugin = \"bad_planner\"\nhow = \"beside_a_builder\""));
    }
    runs::run(&runs::floor(&others), &registry, 4.0)
}

/// Runs; this event must tell what went wrong, with `PLUGIN` for the plugin and its file.
#[track_caller]
fn told(stage: &str, how: &str, expected: &str) -> Told {
    let (told, end) = try_run(stage, how).unwrap();
    let plugin = format!("plugin `bad_{stage}` of {}", library().display());
    let events: Vec<String> = told.events.iter().map(|event| event.replace(&plugin, "PLUGIN")).collect();
    assert!(
        events.iter().any(|event| event == expected),
        "{how}: expected\n  {expected}\n{}",
        events.join("\n")
    );
    assert!(told.fastest <= 0.2, "{how}: the robot was told to drive with {}", told.fastest);
    assert_ne!(end.reason, EndReason::Arrived, "{how}");
    told
}

const NONSENSE: &str = "PLUGIN gave an answer that does not hold together:";
const CAUGHT: &str = "PLUGIN panicked: caught at misbehaving.c: an index of 7 in a list of 3";

#[test]
fn a_path_that_must_not_go_on_ends_the_mission_and_the_robot_stands() {
    let bad = "unreachable: the planner gave a path that must not go on:";
    for (how, expected) in [
        ("nan", format!("{bad} path.points.position is NaN, expected a finite number")),
        ("nan_cost", format!("{bad} path.cost is NaN, expected a finite number")),
        ("no_points", format!("no path: {NONSENSE} a path without points")),
        ("null_points", format!("no path: {NONSENSE} a path that points nowhere")),
        ("huge_length", format!("no path: {NONSENSE} a path that points nowhere")),
        ("endless", format!("no path: {NONSENSE} a path without end (more than 64 MB)")),
        ("silent", "no path: PLUGIN failed with status 1 and said nothing".to_owned()),
        ("strange_status", "no path: PLUGIN failed with status -77 and said nothing".to_owned()),
        ("unterminated", format!("no path: {}", "x".repeat(1024))),
    ] {
        assert_eq!(told("planner", how, &expected).fastest, 0.0, "{how}");
    }
}

#[test]
fn steering_that_must_not_go_on_never_reaches_the_wheels() {
    for (how, expected) in [
        ("nan", "guard: the command was not finite".to_owned()),
        ("strange_kind", format!("avoider failed: {NONSENSE} steering of the kind 99")),
        ("nan_obstacle", "avoider failed: obstacle.position is NaN, expected a finite number".to_owned()),
        ("endless", format!("avoider failed: {NONSENSE} a list of obstacles without end (more than 64 MB)")),
        ("silent", "avoider failed: PLUGIN failed with status 1 and said nothing".to_owned()),
        ("unterminated", format!("avoider failed: {}", "x".repeat(1024))),
    ] {
        assert_eq!(told("avoider", how, &expected).fastest, 0.0, "{how}");
    }
    told("avoider", "too_fast", "guard: the command was too fast");
}

#[test]
fn an_estimate_that_must_not_go_on_stops_the_robot() {
    for (how, expected) in [
        (
            "zero_quaternion",
            format!(
                "{NONSENSE} estimate.map_from_base has a rotation of the squared length 0, expected a unit quaternion"
            ),
        ),
        ("strange_status_word", format!("{NONSENSE} estimate.status is 77, expected 0 to 3")),
        ("silent", "PLUGIN failed with status 1 and said nothing".to_owned()),
    ] {
        let told = told("localizer", how, &format!("localizer failed: {expected}"));
        assert!(told.events.iter().any(|event| event == "guard: a stage failed"), "{how}: {:?}", told.events);
    }
    for (how, field) in [
        ("nan", "map_from_base"),
        ("nan_turn", "map_from_base"),
        ("nan_candidate", "candidates.map_from_base"),
    ] {
        let (told, end) = try_run("localizer", how).unwrap();
        assert_eq!(end.reason, EndReason::StageFailed, "{how}");
        let start = format!("localizer failed: estimate.{field} is at (");
        let is_told =
            |event: &String| event.starts_with(&start) && event.ends_with("), expected finite numbers");
        assert!(told.events.iter().any(is_told), "{how}: {:?}", told.events);
    }
}

#[test]
fn an_observation_that_must_not_go_on_stays_out_and_the_robot_stands() {
    let nonsense = |what: &str| format!("front failed: {NONSENSE} {what}");
    for (how, expected) in [
        ("null_data", nonsense("an observation has no data")),
        ("null_observation", nonsense("an observation points nowhere")),
        ("small_structs", nonsense("an observation has no data")),
        ("no_block_and_no_data", nonsense("an array of 4 elements has neither a block nor data")),
        ("longer_than_its_block", nonsense("an array of 1000000 elements has a block that is smaller")),
        ("zero_quaternion", nonsense("base_from_sensor has a rotation of the squared length 0, expected a unit quaternion")),
        ("strange_kind", nonsense("an observation of an unknown kind")),
        (
            "negative_range",
            "front failed: laser_scan.ranges_m is -1, expected ranges of at least zero, +inf for nothing seen, NaN for \
             none"
                .to_owned(),
        ),
        ("silent", "front failed: PLUGIN failed with status 1 and said nothing".to_owned()),
    ] {
        let told = told("sensor", how, &expected);
        assert_eq!(told.fastest, 0.0, "{how}");
        assert!(told.n_ranges.is_empty(), "{how}");
    }
    let mount = "front failed: observation.base_from_sensor is at (0, NaN, 0.3) m with the quaternion (0, 0, 0, 1), \
                 expected finite numbers";
    told("sensor", "nan_mount", mount);
}

#[test]
fn a_layer_that_is_taken_must_be_put_back() {
    let expected =
        format!("map_builder failed: {NONSENSE} the layer grid was taken out of the map and not put back");
    told("builder", "keeps_the_grid", &expected);
    told("builder", "wrong_size", &expected);
}

/// One panic, one call: from then on only `destroy`.
#[test]
fn an_instance_that_panicked_is_never_called_again_but_to_destroy_it() {
    told("planner", "panic", &format!("no path: {CAUGHT}"));
    assert_eq!(n_calls("planner", "panic", "plan"), 1);
    for (stage, name, function) in
        [("avoider", "avoider", "steer"), ("localizer", "localizer", "update"), ("sensor", "front", "poll")]
    {
        let told = told(stage, "panic", &format!("{name} failed: {CAUGHT}"));
        assert!(
            told.events.iter().any(|event| event == "guard: a stage failed"),
            "{stage}: {:?}",
            told.events
        );
        let again = "is not called again: it panicked: caught at misbehaving.c";
        assert!(told.events.iter().any(|event| event.contains(again)), "{stage}: {:?}", told.events);
        assert_eq!(n_calls(stage, "panic", function), 1, "{stage}");
    }
    for stage in ["planner", "avoider", "localizer", "sensor"] {
        let (made, destroyed) = (n_calls(stage, "panic", "create"), n_calls(stage, "panic", "destroy"));
        assert_eq!((made, destroyed), (1, 1), "{stage}");
    }
}

#[test]
fn a_plugin_that_cannot_be_made_leaves_nothing_behind() {
    let said = |stage: &str, how: &str| {
        try_run(stage, how).unwrap_err().replace(&library().display().to_string(), "FILE")
    };
    assert_eq!(
        said("planner", "panic_in_create"),
        "planner: plugin `bad_planner` of FILE panicked when it was made: caught at misbehaving.c: thrown in the constructor"
    );
    assert_eq!(said("planner", "no_instance"), "planner: plugin `bad_planner` of FILE gave no instance");
    assert_eq!(n_calls("planner", "panic_in_create", "destroy"), 0);
    let start = "map_builder: plugin `bad_builder` of FILE";
    assert_eq!(said("builder", "silent"), format!("{start} failed with status 1 and said nothing"));
    assert!(said("builder", "panic").starts_with(&format!("{start} panicked: caught at ")));
    assert_eq!(n_calls("builder", "panic", "destroy"), 1);
}

#[test]
fn a_plugin_that_behaves_well_is_not_in_the_way() {
    for stage in ["planner", "localizer", "sensor", "builder"] {
        let (told, end) = try_run(stage, "well").unwrap();
        assert_eq!(end.reason, EndReason::TimeLimit, "{stage}: {:?}", told.events);
        assert!(told.failures.is_empty(), "{stage}: {:?}", told.failures);
    }
}
