//! Plugins that misbehave, in a library that was loaded: what they do must not reach the robot.

use crate::alone::passes_alone;
use crate::nested::{GIVEN_FIXTURE, aborting_fixture, built, fixture, fixture_folder, root, rumbo, scratch};
use rumbo_core::boundary::Buffer;
use rumbo_core::boundary::host::Library;
use rumbo_core::engine::{EndReason, Engine, RunEnd, StepLimits, on_lost};
use rumbo_core::frames::{Point2, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{Goal, Obstacle, Path};
use rumbo_core::registry::{Built, Entry, Stage};
use rumbo_core::stages::{BuildContext, BuildError, GiveUp, PlanError, PlanRequest, Planner};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;
use std::time::Duration;

fn entry_of(library: &Library) -> Arc<Entry> {
    library.entries.iter().find(|entry| entry.stage == Stage::Planner).unwrap().clone()
}

fn entry() -> Arc<Entry> {
    entry_of(&Library::open(fixture(), None).unwrap())
}

fn made(entry: &Entry, act: &str) -> Result<Box<dyn Planner>, BuildError> {
    let keys = toml::from_str(&format!("act = \"{act}\"")).unwrap();
    let configured = entry.source.parse(keys).unwrap_or_else(|fault| panic!("{}", fault.message));
    match configured.build(&BuildContext { seed: 3, ..BuildContext::bare("planner") })? {
        Built::Planner(planner) => Ok(planner),
        _ => panic!("not a planner"),
    }
}

fn request() -> PlanRequest {
    let cells: Vec<f32> = (0..400).map(|k| k as f32 * 0.25 - 7.0).collect();
    let header = *Grid::unknown(20, 20, 0.1).unwrap().header();
    PlanRequest {
        stamp: Time::from_secs(2.5),
        map: Map::default(),
        grid: Some(Grid::new(header, Buffer::from(cells)).unwrap()),
        start: pose2(0.5, 0.6, 0.7),
        goal: Goal { position: Point2::new(1.5, 1.25), yaw_rad: Some(-1.0) },
        robot: Default::default(),
        obstacles: vec![Obstacle { position: Point2::new(1.0, 0.5), radius_m: 0.2, stamp: Time(77) }],
        give_up: GiveUp::default(),
        trace: Trace::unwatched(),
    }
}

fn told(result: Result<Path, PlanError>) -> String {
    result.unwrap_err().to_string()
}

/// What a planner in this program would tell of a request.
fn echo(request: &PlanRequest) -> String {
    let grid = request
        .grid
        .as_ref()
        .map(|grid| (grid.header(), grid.cells.iter().map(|v| f64::from(*v)).sum::<f64>()));
    let PlanRequest { stamp, start, goal, robot, obstacles, .. } = request;
    format!("{stamp:?} {start:?} {goal:?} {robot:?} {obstacles:?} {grid:?}")
}

#[test]
fn a_plugin_sees_the_very_cells_of_the_host_and_everything_that_was_asked() {
    let request = request();
    let address = format!("{:p}", request.grid.as_ref().unwrap().cells.as_ptr());
    assert_eq!(told(made(&entry(), "address").unwrap().plan(&request)), address, "the grid was copied");
    assert_eq!(told(made(&entry(), "echo").unwrap().plan(&request)), echo(&request));
}

#[test]
fn chance_in_a_library_is_the_chance_of_the_run() {
    use rumbo_core::rng::RngExt as _;
    let mut rng = rumbo_core::rng::stream(3, "planner");
    let expected = format!("{:?}", [(); 3].map(|()| rng.random::<u64>()));
    for _ in 0..2 {
        assert_eq!(told(made(&entry(), "dice").unwrap().plan(&request())), expected);
    }
}

#[test]
fn a_panic_is_an_error_with_its_place_and_the_instance_is_not_called_again() {
    let error = made(&entry(), "panic_in_create").err().unwrap().to_string();
    assert!(error.contains("made to panic in create") && error.contains("lib.rs:"), "{error}");
    let mut planner = made(&entry(), "panic_in_plan").unwrap();
    let first = told(planner.plan(&request()));
    assert!(first.contains("fixture_actor") && first.contains("made to panic in plan"), "{first}");
    let again = told(planner.plan(&request()));
    assert!(again.contains("is not called again"), "{again}");
    drop(made(&entry(), "panic_in_drop").unwrap());
    assert!(made(&entry(), "straight").unwrap().plan(&request()).is_ok(), "others go on");
}

#[test]
fn a_planner_that_is_asked_to_give_up_does() {
    let request = request();
    request.give_up.raise();
    assert_eq!(made(&entry(), "loop").unwrap().plan(&request), Err(PlanError::GivenUp));
    let asked = request.give_up.child();
    let mut planner = made(&entry(), "loop").unwrap();
    let later = self::request();
    let flag = later.give_up.clone();
    let thread = std::thread::spawn(move || planner.plan(&later));
    std::thread::sleep(Duration::from_millis(20));
    flag.raise();
    assert_eq!(thread.join().unwrap(), Err(PlanError::GivenUp));
    assert!(asked.is_raised());
}

/// The shipped office with the fixture as its planner, in this program; stages are waited for half a second.
fn run(act: &str) -> RunEnd {
    let mut registry = rumbo::registry().unwrap();
    registry.load(fixture(), None).unwrap();
    let sets =
        ["planner.plugin=fixture_actor".to_owned(), format!("planner.variants.fixture_actor.act={act}")];
    let file = root().join("pipelines/office.toml");
    let ready = rumbo::load::load(&file, &sets, &registry).ok().unwrap();
    let mut engine = Engine::build(&ready.pipeline).unwrap();
    let short = Duration::from_millis(500);
    engine.set_limits(StepLimits { step: short, obey: short });
    engine.run(&mut [], &AtomicBool::new(false))
}

#[test]
fn what_a_misbehaving_planner_does_ends_the_run_and_says_whose_it_was() {
    let end = run("not_a_number");
    assert_eq!(end.reason, EndReason::PlannerFailed);
    assert!(end.detail.unwrap().contains("finite"));
    let end = run("panic_in_plan");
    let detail = end.detail.unwrap();
    assert!(end.reason == EndReason::PlannerFailed && detail.contains("rust_fixture"), "{detail}");
    assert_eq!(run("loop").reason, EndReason::Stalled);
}

#[test]
fn a_planner_that_never_comes_back_is_named_with_its_file() {
    let (sender, receiver) = channel();
    on_lost(move |lost| sender.send(lost.to_string()).unwrap());
    // Its thread is lost, as the plugin is: it sleeps until this program ends.
    std::thread::spawn(|| run("deaf"));
    let told = receiver.recv_timeout(Duration::from_secs(60)).unwrap();
    let who = format!("planner `fixture_actor` of {}", fixture().canonicalize().unwrap().display());
    assert!(told.starts_with(&who) && told.contains("does not come back"), "{told}");
}

#[test]
fn the_command_ends_when_a_stage_never_comes_back_and_keeps_what_was_recorded() {
    let bag = scratch("deaf").join("run.mcap");
    let plugin = ["--plugin", fixture().to_str().unwrap(), "--record", bag.to_str().unwrap(), "--no-report"];
    let sets = ["--set", "planner.plugin=fixture_actor", "--set", "planner.variants.fixture_actor.act=deaf"];
    let (code, _, told) = rumbo(&[&["run", "pipelines/office.toml"][..], &plugin, &sets].concat());
    assert_eq!(code, 1, "{told}");
    assert!(told.contains("planner `fixture_actor` of") && told.contains("does not come back"), "{told}");
    assert!(std::fs::read(bag).unwrap().ends_with(b"\x89MCAP0\r\n"), "the recording is closed");
}

/// Laser, wheels, and the SLAM of the fixture in the shipped office.
const TRACKED: &str = r#"
name = "tracked"

[world]
plugin = "sim"
map = "MAP"
start = { x_m = 3.0, y_m = 4.5, yaw_deg = 90.0 }
duration_s = 4.0

[[sensor]]
name = "front"
plugin = "lms200"
mount = { z_m = 0.30 }
rate_hz = 5.0

[slam]
plugin = "fixture_tracker"
"#;

#[test]
fn the_trajectory_of_a_slam_in_a_library_is_written_and_what_it_uses_is_listed() {
    let folder = scratch("tracked");
    let (pipeline, file) = (folder.join("tracked.toml"), folder.join("trajectory.txt"));
    let map = root().join("pipelines/worlds/office-20m.yaml");
    std::fs::write(&pipeline, TRACKED.replace("MAP", map.to_str().unwrap())).unwrap();
    let plugin = ["--plugin", fixture().to_str().unwrap()];
    let words = ["run", pipeline.to_str().unwrap(), "--no-report", "--trajectory", file.to_str().unwrap()];
    // Nothing makes the odometry that it would use, and that is no fault.
    let (code, _, told) = rumbo(&[&words[..], &plugin].concat());
    assert!(code == 0 && told.contains("trajectory.txt"), "{told}");
    let text = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<Vec<f64>> =
        text.lines().map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect();
    assert!((20..=21).contains(&lines.len()), "{text}");
    let stands = |line: &Vec<f64>| line[1..3] == [3.0, 4.5] && (line[3].to_degrees() - 90.0).abs() < 1e-3;
    assert!(lines.iter().all(stands), "{text}");
    assert!(lines.windows(2).all(|pair| (pair[1][0] - pair[0][0] - 0.2).abs() < 1e-6), "{text}");
    std::fs::remove_file(&file).unwrap();
    let panics = ["--set", "slam.panics=true"];
    let (code, _, told) = rumbo(&[&words[..], &plugin, &panics].concat());
    assert!(code == 3 && told.contains("made to panic in trajectory") && !file.exists(), "{told}");
    let (_, listed, _) = rumbo(&[&["plugins", "describe", "fixture_tracker"][..], &plugin].concat());
    assert!(listed.contains("uses where present: odometry, imu"), "{listed}");
}

#[test]
fn a_library_whose_panics_abort_is_refused() {
    let error = Library::open(&aborting_fixture(), None).unwrap_err().to_string();
    assert!(error.contains("panic") && error.contains("abort"), "{error}");
}

#[test]
#[allow(clippy::print_stdout)]
fn a_library_of_another_compiler_with_another_layout_gives_the_same_answers() {
    let nightly = Command::new("rustup").args(["run", "nightly", "rustc", "-V"]).output();
    if !nightly.is_ok_and(|out| out.status.success()) {
        println!("skipped: there is no nightly toolchain");
        return;
    }
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]).env("RUSTFLAGS", "-Zrandomize-layout");
    // Set by the cargo that runs this test, for its own compiler.
    ["RUSTC", "RUSTDOC", "CARGO", "RUSTUP_TOOLCHAIN"]
        .into_iter()
        .for_each(|name| _ = command.env_remove(name));
    let theirs = entry_of(
        &Library::open(&built(command, &fixture_folder(), "rust_fixture", "nightly"), None).unwrap(),
    );
    let request = request();
    assert_eq!(told(made(&theirs, "echo").unwrap().plan(&request)), echo(&request));
    for act in ["dice", "address", "straight", "not_a_number"] {
        let answers =
            [&theirs, &entry()].map(|entry| format!("{:?}", made(entry, act).unwrap().plan(&request)));
        assert_eq!(answers[0], answers[1], "{act}");
    }
    let error = made(&theirs, "panic_in_create").err().unwrap().to_string();
    assert!(error.contains("made to panic in create"), "{error}");
}

#[test]
fn ten_thousand_instances_and_plans_leave_nothing_behind() {
    // In a process of its own: memory is measured for the whole process, and the other tests of this one use it at the same time.
    if std::env::var_os(GIVEN_FIXTURE).is_none() {
        let name = "rust_fixture::ten_thousand_instances_and_plans_leave_nothing_behind";
        return passes_alone(name, GIVEN_FIXTURE, fixture());
    }
    let (entry, request) = (entry(), request());
    let cycle = || {
        let mut planner = made(&entry, "straight").unwrap();
        planner.plan(&request).unwrap();
    };
    let mut planner = made(&entry, "straight").unwrap();
    for _ in 0..500 {
        cycle();
        planner.plan(&request).unwrap();
    }
    let before = resident_kib();
    let counted = allocation_counter::measure(|| {
        for _ in 0..10_000 {
            cycle();
            planner.plan(&request).unwrap();
        }
    });
    // Memory of this side that the library freed would be missing here, and memory of the library that this side freed
    // would be too much.
    assert_eq!((counted.count_current, counted.bytes_current), (0, 0), "{counted:?}");
    if let (Some(before), Some(after)) = (before, resident_kib()) {
        assert!(after < before + 8 * 1024, "{before} KiB became {after} KiB");
    }
}

/// Memory of this process that is in use, where the system tells.
fn resident_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse().ok()
}
