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
    runs::run(&runs::floor(&others), &registry)
}

/// Runs, and gives the words of the first failure of this stage.
#[track_caller]
fn failed(stage: &str, how: &str) -> (Told, String) {
    let (told, end) = try_run(stage, how).unwrap();
    let words = told.events.iter().find(|event| event.contains("plugin `bad_") || event.contains(section(stage)));
    let words = words.unwrap_or_else(|| panic!("{how}: {end:?} {:?}", told.events)).clone();
    assert!(!told.fastest.is_nan(), "{how}");
    assert_ne!(end.reason, EndReason::Arrived, "{how}");
    (told, words.replace(&library().display().to_string(), "FILE"))
}

#[test]
fn look() {
    for (stage, hows) in [
        ("planner", &["nan", "nan_cost", "no_points", "null_points", "huge_length", "endless", "panic", "silent", "strange_status", "unterminated"][..]),
        ("avoider", &["nan", "too_fast", "strange_kind", "nan_obstacle", "endless", "panic", "silent", "strange_status", "unterminated"]),
        ("localizer", &["nan", "nan_turn", "zero_quaternion", "strange_status_word", "nan_candidate", "panic", "silent", "unterminated"]),
        ("sensor", &["null_data", "no_block_and_no_data", "longer_than_its_block", "zero_quaternion", "nan_mount", "strange_kind", "negative_range", "small_structs", "null_observation", "panic", "silent"]),
        ("builder", &["keeps_the_grid", "wrong_size", "panic", "silent"]),
        ("planner", &["panic_in_create", "no_instance"]),
    ] {
        for how in hows {
            match try_run(stage, how) {
                Ok((told, end)) => println!("== {stage} {how}: {:?} fastest {} after {} \n     {}", end, told.fastest, told.fastest_after_failure, told.events.join("\n     ")),
                Err(e) => println!("== {stage} {how}: {e}"),
            }
        }
    }
    println!("{}", n_calls("planner", "panic", "plan"));
    let _ = failed("planner", "nan");
}
