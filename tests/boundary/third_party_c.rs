//! `examples/third_party_c`: what its README says works, and the planner's answers are right.

use crate::compiler;
use crate::text_world::{TextWorld, text_world};
use rumbo_core::frames::Point2;
use rumbo_core::map::{Cell, CellClass};
use rumbo_core::messages::Path as Way;
use rumbo_core::registry::{Built, Registry, Stage};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{BuildContext, GiveUp, PlanError, PlanRequest, Planner};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, OnceLock};

/// The folder of the built examples.
fn built() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let out = compiler::folder("third_party_c");
        let script = compiler::root().join("examples/third_party_c/build.sh");
        let built = Command::new("sh").arg(script).arg(&out).arg("-Werror").output().unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        out
    })
}

fn library(name: &str) -> PathBuf {
    built().join(format!("lib{name}.so"))
}

/// Runs the built command where the libraries are found.
fn rumbo(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rumbo"));
    command.current_dir(compiler::root()).env("RUMBO_PLUGIN_PATH", built()).args(arguments);
    command.output().unwrap()
}

#[track_caller]
fn works(arguments: &[&str]) -> String {
    let out = rumbo(arguments);
    assert!(out.status.success(), "{arguments:?}\n{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).unwrap()
}

const PIPELINE: &str = "examples/third_party_c/office_c.toml";

#[test]
fn the_office_is_crossed_with_a_planner_in_c_and_a_localizer_in_cpp() {
    works(&["check", PIPELINE]);
    works(&["test", PIPELINE]);
    let figures = works(&["run", PIPELINE, "--no-report", "--quiet", "--json"]);
    for expected in ["\"reason\": \"arrived\"", "\"contacts\": 0", "\"stage_failures\": 0"] {
        assert!(figures.contains(expected), "{figures}");
    }
}

#[test]
fn the_command_lists_and_describes_them() {
    let (wave, reckoning) = (library("wave"), library("dead_reckoning"));
    let (wave, reckoning) = (wave.to_str().unwrap(), reckoning.to_str().unwrap());
    let listed = works(&["plugins", "list", "--plugin", wave, "--plugin", reckoning]);
    for expected in
        ["A wave front over the grid, in plain C", "Believes the odometer, in C++", "ABI 1.1, built by wave"]
    {
        assert!(listed.contains(expected), "{expected}:\n{listed}");
    }
    let described = works(&["plugins", "describe", "wave", "--plugin", wave]);
    assert!(described.contains("clearance_m (number, m) = 0.35"), "{described}");
    assert!(described.contains("reads map layers: grid"), "{described}");
    let described = works(&["plugins", "describe", "dead_reckoning", "--plugin", reckoning]);
    assert!(described.contains("drift_rad_per_rad"), "{described}");
}

#[test]
fn it_is_compared_with_planners_that_we_ship() {
    let out = compiler::folder("third_party_c_compared");
    let swap = ["--swap", "planner=wave,dp,a_star", "--seeds", "1"];
    let out = out.to_str().unwrap();
    let arguments = [&["compare", PIPELINE, "--output", out][..], &swap].concat();
    works(&arguments);
    let table = std::fs::read_to_string(Path::new(out).join("results.csv")).unwrap();
    assert_eq!(table.lines().count(), 4, "{table}");
    for planner in ["wave", "dp", "a_star"] {
        assert!(table.lines().any(|line| line.contains(planner) && line.contains("arrived")), "{table}");
    }
}

#[test]
fn they_keep_the_laws_of_their_stages() {
    for name in ["wave", "dead_reckoning"] {
        let library = library(name);
        works(&["plugins", "verify", library.to_str().unwrap()]);
    }
}

#[test]
fn faults_of_its_parameters_point_at_the_line() {
    for (set, expected) in [
        ("planner.clearance_m=-1.0", "planner.clearance_m"),
        ("planner.clearance_m=\"wide\"", "planner.clearance_m"),
        ("planner.clerance_m=0.4", "did you mean clearance_m?"),
        ("planner.clearance_m=0.1", "0.1 m is less than the robot's radius of 0.2 m"),
    ] {
        let out = rumbo(&["check", PIPELINE, "--set", set]);
        let said = String::from_utf8(out.stderr).unwrap();
        assert!(!out.status.success() && said.contains(expected), "{set}:\n{said}");
    }
}

fn wave(clearance_m: f64) -> Box<dyn Planner> {
    let mut registry = Registry::default();
    registry.load(&library("wave"), None).unwrap();
    let keys = toml::from_str(&format!("clearance_m = {clearance_m:?}")).unwrap();
    let configured = registry.get(Stage::Planner, "wave").unwrap().source.parse(keys).unwrap();
    match configured.build(&BuildContext::bare("planner")).unwrap() {
        Built::Planner(planner) => planner,
        _ => panic!("no planner"),
    }
}

fn request(world: &TextWorld) -> PlanRequest {
    PlanRequest {
        stamp: Time::ZERO,
        map: world.map.clone(),
        grid: world.map.grid.clone(),
        start: world.start,
        goal: world.goal,
        robot: Arc::new(Robot::default()),
        obstacles: Vec::new(),
        give_up: GiveUp::default(),
        trace: Trace::watched(),
    }
}

/// Rooms of 2 m with a door of 1.5 m.
fn rooms() -> TextWorld {
    text_world(
        0.25,
        "
        ##########################
        #...........#............#
        #..S........#............#
        #........................#
        #........................#
        #........................#
        #........................#
        #...........#........G...#
        #...........#............#
        ##########################",
    )
}

/// The least distance from the way to the middle of an occupied cell.
fn clearance_m(way: &Way, world: &TextWorld) -> f64 {
    let grid = world.map.grid.as_ref().unwrap();
    let cells = (0..grid.height()).flat_map(|row| (0..grid.width()).map(move |col| Cell { col, row }));
    let occupied: Vec<Point2> = cells
        .filter(|cell| grid.class(*cell) == CellClass::Occupied)
        .map(|cell| grid.center_of(cell))
        .collect();
    let mut least = f64::INFINITY;
    for piece in way.points().windows(2) {
        for k in 0..=100 {
            let at = piece[0].position + (piece[1].position - piece[0].position) * (f64::from(k) / 100.0);
            least = occupied.iter().map(|cell| (cell - at).norm()).fold(least, f64::min);
        }
    }
    least
}

#[test]
fn the_wave_finds_a_short_way_that_keeps_its_clearance() {
    let world = rooms();
    let request = request(&world);
    let way = wave(0.4).plan(&request).unwrap();
    assert_eq!(way.end().position, world.goal.position);
    assert!(clearance_m(&way, &world) > 0.4 - 0.25, "{way:?}");
    let straight_m = (world.goal.position - Point2::from(world.start.translation.vector)).norm();
    assert!(way.length_m() < 1.1 * straight_m, "{} m instead of {straight_m} m", way.length_m());
    assert!((way.cost - way.length_m()).abs() < 1e-9);
    assert!(way.points().len() <= 4, "it is pulled straight: {way:?}");
    let (drawings, counters) = request.trace.take();
    assert!(
        !drawings.is_empty() && counters[0].0 == "expanded_cells" && counters[0].1 > 50.0,
        "{counters:?}"
    );
}

#[test]
fn the_wave_names_what_is_in_the_way() {
    let picture = |rows: &str| text_world(0.25, rows);
    let fails = |world: &TextWorld, clearance_m| wave(clearance_m).plan(&request(world)).unwrap_err();
    let mut world = rooms();
    world.goal.position = Point2::new(100.0, 1.0);
    assert_eq!(fails(&world, 0.4), PlanError::GoalOutside { goal: world.goal.position });
    world.goal.position = Point2::new(f64::NAN, 1.0);
    assert_eq!(fails(&world, 0.4), PlanError::NotFinite { what: "goal" });
    world.goal.position = Point2::new(0.1, 0.1);
    assert_eq!(fails(&world, 0.4), PlanError::GoalOccupied { goal: world.goal.position, found: "occupied" });
    let mut world = rooms();
    world.start.translation.x = -3.0;
    assert_eq!(fails(&world, 0.4), PlanError::StartOutside { start: world.start.translation.vector.into() });
    world.start.translation.vector.x = 0.1;
    assert!(matches!(fails(&world, 0.4), PlanError::StartOccupied { found: "occupied", .. }));
    let world = picture("########\n#S....?#\n#......#\n########");
    let mut unknown = picture("########\n#S....?#\n#......#\n########");
    unknown.goal.position = world.map.grid.as_ref().unwrap().center_of(Cell { col: 6, row: 2 });
    assert!(matches!(fails(&unknown, 0.2), PlanError::GoalOccupied { found: "unknown", .. }));
    assert_eq!(
        fails(&rooms(), 0.6),
        PlanError::GoalTooClose { goal: rooms().goal.position, found_m: 0.5, needed_m: 0.6 }
    );
    let closed = picture("#########\n#S..#..G#\n#...#...#\n#########");
    let PlanError::Unreachable { reason } = fails(&closed, 0.2) else { panic!("it found a way") };
    assert!(reason.contains("0.20 m of clearance"), "{reason}");
    let mut nothing = request(&rooms());
    nothing.grid = None;
    assert_eq!(wave(0.5).plan(&nothing), Err(PlanError::MissingLayer { layer: "grid" }));
}

#[test]
fn the_wave_gives_up_when_it_is_told() {
    let wall = "#".repeat(202);
    let floor = format!("#{}#\n", ".".repeat(200)).repeat(60);
    let world = text_world(0.25, &format!("{wall}\n#S{}#\n{floor}{wall}", ".".repeat(199)));
    let mut request = request(&world);
    request.goal.position = Point2::new(45.0, 1.0);
    request.give_up.raise();
    assert_eq!(wave(0.25).plan(&request), Err(PlanError::GivenUp));
}

#[test]
fn one_instance_plans_on_maps_of_all_sizes() {
    let mut planner = wave(0.2);
    for n in [3, 40, 7, 90, 5] {
        let wall = "#".repeat(n + 4);
        let world = text_world(
            0.25,
            &format!(
                "{wall}\n#{}#\n#S{}G#\n#{}#\n{wall}",
                ".".repeat(n + 2),
                ".".repeat(n),
                ".".repeat(n + 2)
            ),
        );
        let way = planner.plan(&request(&world)).unwrap();
        assert_eq!(way.points().len(), 2, "{n}: {way:?}");
    }
}
