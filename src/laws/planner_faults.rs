//! Laws of planners: what cannot be planned is said by its name.

use super::law::{Trouble, Verdict, expect};
use super::planners::{Asked, OnAWay};
use super::subject::Subject;
use super::text_world::TextWorld;
use nalgebra::Vector2;
use rumbo_core::frames::{Point2, pose2};
use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Check, Path};
use rumbo_core::stages::{PlanError, PlanRequest};

type Answer = Result<Path, PlanError>;

/// What is wrong, and how it gets so.
type Spoil = (&'static str, fn(&mut PlanRequest));

pub fn names_bad_goals(subject: &Subject) -> Verdict {
    let world = TextWorld::rooms()?;
    let mut asked = Asked::new(subject)?;
    let mut in_wall = asked.request(&world);
    in_wall.goal.position = Point2::new(0.1, 0.1);
    let answer = asked.planner.plan(&in_wall);
    let is_named = matches!(answer, Err(PlanError::GoalOccupied { .. }));
    expect(is_named, || told("a goal in a wall", &answer), "PlanError::GoalOccupied")?;
    let mut outside = asked.request(&world);
    outside.goal.position = Point2::new(-1.0, 50.0);
    let answer = asked.planner.plan(&outside);
    let is_named = matches!(answer, Err(PlanError::GoalOutside { .. }));
    expect(is_named, || told("a goal outside the map", &answer), "PlanError::GoalOutside")?;
    let OnAWay { asked: mut closed_in, world, why_not_rooms } = OnAWay::new(subject)?;
    let mut closed = closed_in.request(&world);
    if let Some(grid) = closed.grid.as_mut() {
        if why_not_rooms.is_empty() {
            // The doorway is a part of the wall at 3.0 m to 3.25 m.
            (0..75).for_each(|k| grid.occupy_disc(Point2::new(3.1, 0.05 * f64::from(k)), 0.0));
        } else {
            // A ring around the goal.
            let on_ring =
                |k: u32| Vector2::new((0.01 * f64::from(k)).cos(), (0.01 * f64::from(k)).sin()) * 1.5;
            (0..629).for_each(|k| grid.occupy_disc(world.goal.position + on_ring(k), 0.05));
        }
    }
    let answer = closed_in.planner.plan(&closed);
    let is_named = matches!(answer, Err(PlanError::Unreachable { .. } | PlanError::Stuck { .. }));
    let expected = "PlanError::Unreachable, or Stuck where its own search ends";
    expect(is_named, || told("a goal behind a wall", &answer), expected)?;
    Ok(String::new())
}

pub fn names_an_empty_map(subject: &Subject) -> Verdict {
    let world = TextWorld::rooms()?;
    let mut asked = Asked::new(subject)?;
    let mut empty = asked.request(&world);
    (empty.map, empty.grid) = (Map::default(), None);
    let answer = asked.planner.plan(&empty);
    if !subject.manifest().needs_layers.contains(&Layer::Grid) {
        return sane("an empty map", &answer);
    }
    let is_named = matches!(answer, Err(PlanError::MissingLayer { .. }));
    expect(is_named, || told("an empty map", &answer), "PlanError::MissingLayer")?;
    Ok(String::new())
}

pub fn names_bad_numbers(subject: &Subject) -> Verdict {
    let bad: [Spoil; 4] = [
        ("a goal at NaN", |request| request.goal.position.x = f64::NAN),
        ("a goal at infinity", |request| request.goal.position.y = f64::INFINITY),
        ("a start at infinity", |request| request.start = pose2(f64::INFINITY, 0.0, 0.0)),
        ("a start with a heading of NaN", |request| request.start = pose2(1.0, 1.0, f64::NAN)),
    ];
    let world = TextWorld::rooms()?;
    let mut asked = Asked::new(subject)?;
    for (what, spoil) in bad {
        let mut request = asked.request(&world);
        spoil(&mut request);
        let answer = asked.planner.plan(&request);
        let is_named = matches!(answer, Err(PlanError::NotFinite { .. }));
        expect(is_named, || told(what, &answer), "PlanError::NotFinite")?;
    }
    Ok(String::new())
}

pub fn survives_huge_numbers(subject: &Subject) -> Verdict {
    let huge: [Spoil; 4] = [
        ("a goal at 1e300 m", |request| request.goal.position = Point2::new(1e300, -1e300)),
        ("a start at 1e300 m", |request| request.start = pose2(-1e300, 1e300, 0.0)),
        ("a goal at 1e18 m", |request| request.goal.position = Point2::new(1e18, 1e18)),
        ("a start at 1e18 m", |request| request.start = pose2(1e18, 1e18, 3.0)),
    ];
    let world = TextWorld::rooms()?;
    let mut asked = Asked::new(subject)?;
    for (what, spoil) in huge {
        let mut request = asked.request(&world);
        spoil(&mut request);
        let answer = asked.planner.plan(&request);
        expect(answer.is_err(), || told(what, &answer), "an error")?;
    }
    Ok(String::new())
}

pub fn plans_in_one_cell(subject: &Subject) -> Verdict {
    let world = TextWorld::drawn("S", 5.0, 1)?;
    let mut asked = Asked::new(subject)?;
    let path = asked.path(&world)?;
    let length_m = path.length_m();
    expect(length_m < 1e-9, || format!("a path of {length_m} m"), "a path that stays where it is")?;
    sane("a map of one cell", &Ok(path))
}

/// Any error, or a path of finite numbers.
fn sane(what: &str, answer: &Answer) -> Verdict {
    match answer {
        Err(error) => Ok(error.to_string()),
        Ok(path) => match path.check() {
            Ok(()) => Ok(String::new()),
            Err(fault) => Err(Trouble::broken(format!("{what}: {fault}"), "an error, or finite numbers")),
        },
    }
}

fn told(what: &str, answer: &Answer) -> String {
    match answer {
        Ok(path) => format!("{what}: a path of {:.2} m", path.length_m()),
        Err(error) => format!("{what}: \"{error}\""),
    }
}
