//! Planners that are `a_star` with one thing spoiled each.

use super::doubles::{Double, Make, build, manifest};
use super::*;
use rumbo_core::frames::Point2;
use rumbo_core::messages::{Path, PathPoint};
use rumbo_core::registry::Built;
use rumbo_core::stages::{BuildContext, BuildError, GiveUp, PlanError, PlanRequest, Planner};
use rumbo_core::trace::Trace;
use serde_json::json;
use std::sync::atomic::{AtomicU64, Ordering};

type Answer = Result<Path, PlanError>;
type Spoil = fn(&mut dyn Planner, &PlanRequest) -> Answer;

struct Spoiled {
    inner: Box<dyn Planner>,
    spoil: Spoil,
}

impl Planner for Spoiled {
    fn plan(&mut self, request: &PlanRequest) -> Answer {
        (self.spoil)(self.inner.as_mut(), request)
    }
}

/// `a_star`, spoiled by this.
fn make(context: &BuildContext, spoil: Spoil) -> Built {
    let inner = build(Stage::Planner, "a_star", context);
    Built::Planner(Box::new(Spoiled { inner, spoil }))
}

fn planner(name: &str, make: Make) -> Entry {
    Double::entry(Stage::Planner, name, manifest(Stage::Planner, "a_star"), make)
}

/// The same path with one more point before the last.
fn with_point(path: Path, position: Point2) -> Path {
    let mut points = path.points().to_vec();
    points.insert(points.len() - 1, PathPoint { position, yaw_rad: None });
    Path::new(points, path.cost).unwrap()
}

#[test]
fn a_planner_that_is_not_spoiled_keeps_every_law() {
    breaks(planner("as_it_is", |context| make(context, |inner, request| inner.plan(request))), &[]);
}

#[test]
fn not_a_number_in_a_path_is_told() {
    let nan = planner("nan", |context| {
        make(context, |inner, request| {
            inner.plan(request).map(|path| with_point(path, Point2::new(f64::NAN, 1.0)))
        })
    });
    let report = report(nan);
    assert!(broken(&report).contains(&"every number of a path is finite"), "{}", told(report.broken()));
}

#[test]
fn a_way_through_walls_is_told() {
    let straight = planner("straight", |context| {
        make(context, |inner, request| {
            let path = inner.plan(request)?;
            let ends = [*path.points().first().unwrap(), path.end()];
            Ok(Path::new(ends.to_vec(), path.cost).unwrap())
        })
    });
    breaks(straight, &["a path touches nothing", "a path keeps the clearance"]);
}

#[test]
fn a_planner_that_does_not_give_up_is_told() {
    let stubborn = planner("stubborn", |context| {
        make(context, |inner, request| {
            inner.plan(&PlanRequest {
                stamp: request.stamp,
                map: request.map.clone(),
                grid: request.grid.clone(),
                start: request.start,
                goal: request.goal,
                robot: request.robot.clone(),
                obstacles: request.obstacles.clone(),
                give_up: GiveUp::default(),
                trace: Trace::unwatched(),
            })
        })
    });
    breaks(stubborn, &["a raised give_up ends the search"]);
}

/// Planners whose search may end are let off the rooms, not the open floor.
#[test]
fn a_planner_that_is_always_stuck_is_told() {
    let lazy = planner("lazy", |context| {
        make(context, |inner, request| {
            inner.plan(request)?;
            let place = request.start.translation.vector.into();
            Err(PlanError::Stuck { place, reason: "no step was taken".into() })
        })
    });
    let report = report(lazy);
    for law in ["a path begins at the start and ends at the goal", "every number of a path is finite"] {
        assert!(broken(&report).contains(&law), "{}", told(report.broken()));
    }
    let only_open = planner("only_open_floors", |context| {
        make(context, |inner, request| {
            let path = inner.plan(request)?;
            let place = Point2::from(request.start.translation.vector);
            let is_straight = path.length_m() <= 1.09 * (path.end().position - place).norm();
            let reason = "a bend".to_owned();
            if is_straight { Ok(path) } else { Err(PlanError::Stuck { place, reason }) }
        })
    });
    breaks(only_open, &[]);
}

#[test]
fn a_planner_that_remembers_is_told() {
    static N_PLANS: AtomicU64 = AtomicU64::new(0);
    let moody = planner("moody", |context| {
        make(context, |inner, request| {
            let cost = N_PLANS.fetch_add(1, Ordering::Relaxed) as f64;
            inner.plan(request).map(|path| Path::new(path.points().to_vec(), cost).unwrap())
        })
    });
    breaks(moody, &["the same request gives the same path, also after others"]);
}

#[test]
fn a_planner_that_prefers_one_side_is_told() {
    let leaning = planner("leaning", |context| {
        make(context, |inner, request| {
            let path = inner.plan(request)?;
            let (first, last) = (path.points()[0].position, path.end().position);
            // A detour where the way leads up.
            Ok(if last.y > first.y + 0.1 { with_point(path, first) } else { path })
        })
    });
    let report = report(leaning);
    let law = "a world turned or mirrored gives a path of the same length";
    assert!(broken(&report).contains(&law), "{}", told(report.broken()));
}

#[test]
fn a_panic_on_an_empty_map_is_told_with_its_words() {
    let report = report(planner("trusting", |context| {
        make(context, |inner, request| {
            assert!(request.grid.is_some(), "there is always a grid");
            inner.plan(request)
        })
    }));
    assert_eq!(broken(&report), ["an empty map is named"]);
    assert!(told(report.broken()).contains("it panicked: `there is always a grid`"));
}

#[test]
#[cfg(target_os = "linux")]
fn memory_that_leaks_is_told() {
    let leaking = planner("leaking", |context| {
        make(context, |inner, request| {
            std::hint::black_box(vec![1u8; 64 << 10].leak());
            inner.plan(request)
        })
    });
    breaks(leaking, &["10,000 calls use finite memory"]);
}

/// What becomes of building a plugin with a parameter `port` that is refused like this.
fn building(fault: fn(&BuildContext) -> Option<BuildError>) -> (PluginReport, Outcome) {
    let port = json!({ "type": "string", "description": "Where it is plugged in." });
    let double = Double {
        manifest: manifest(Stage::Planner, "a_star"),
        make: |context| make(context, |inner, request| inner.plan(request)),
        schema: json!({ "properties": { "port": port }, "additionalProperties": false }),
        defaults: toml::Table::from_iter([("port".to_owned(), "usb".into())]),
        fault,
    };
    let report = report(double.called(Stage::Planner, "plugged"));
    let found = report.findings.iter().find(|finding| finding.law == "it can be built from its defaults");
    let outcome = found.unwrap().outcome.clone();
    (report, outcome)
}

#[test]
fn a_default_that_is_refused_is_told_and_what_cannot_be_guessed_is_not_applicable() {
    let (_, outcome) = building(|_| Some(BuildError::at("port", "is usb, expected a number")));
    assert!(matches!(outcome, Outcome::Fail { .. }), "{outcome:?}");
    let (report, outcome) = building(|_| Some(BuildError::at("server", "is missing")));
    let Outcome::NotApplicable { why } = outcome else { panic!("{outcome:?}") };
    assert!(why.contains("--set server=...") && !why.contains("usb"), "{why}");
    let silent = report.findings.last().unwrap();
    assert!(matches!(silent.outcome, Outcome::NotApplicable { .. }), "{silent:?}");
    let not_here: fn(&BuildContext) -> Option<BuildError> =
        |context| (!context.dry_run).then(|| BuildError::at("port", "nothing answers at usb"));
    let (_, outcome) = building(not_here);
    let Outcome::NotApplicable { why } = outcome else { panic!("{outcome:?}") };
    assert!(why.contains("nothing answers at usb"), "{why}");
}

#[test]
fn a_schema_that_lies_is_told() {
    let lying = |schema: serde_json::Value, laws: &[&str]| {
        let double = Double {
            manifest: manifest(Stage::Planner, "a_star"),
            make: |context| make(context, |inner, request| inner.plan(request)),
            schema,
            defaults: toml::Table::from_iter([("gain".to_owned(), toml::Value::Float(0.5))]),
            fault: |_| None,
        };
        breaks(double.called(Stage::Planner, "lying"), laws);
    };
    // This double takes every value, so that those laws are broken in any case.
    let takes_all = "numbers that are not finite, and values of another type, are refused";
    let out_of_range = "values outside the ranges of its schema are refused";
    let gain = json!({ "type": "number", "description": "How much.", "minimum": 1.0 });
    lying(
        json!({ "properties": { "gain": gain }, "additionalProperties": false }),
        &["its defaults are valid and read back as they were", takes_all, out_of_range],
    );
    let bare = json!({ "type": "number" });
    lying(
        json!({ "properties": { "gain": bare } }),
        &[
            "its summary and every parameter are documented",
            "a key that it does not know is refused",
            takes_all,
        ],
    );
}
