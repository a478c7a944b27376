//! Laws of planners: the same answer to the same question, giving up, memory, symmetry.

use super::law::{Law, Trouble, Verdict, expect};
use super::memory::stays_finite;
use super::stopwatch::Stopwatch;
use super::subject::Subject;
use super::text_world::TextWorld;
use super::turn::Turn;
use super::{planner_faults, planner_paths};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::Layer;
use rumbo_core::messages::{Goal, Path};
use rumbo_core::stages::{GiveUp, PlanError, PlanRequest, Planner};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::sync::Arc;
use std::time::Duration;

/// What every planner keeps.
pub const LAWS: &[Law] = &[
    Law::new("a path begins at the start and ends at the goal", planner_paths::joins_start_and_goal)
        .within("start: 1e-6 m; end: one cell"),
    Law::new("a path touches nothing", planner_paths::touches_nothing)
        .within("every 5 mm of the path lies in a free cell"),
    Law::new("a path keeps the clearance", planner_paths::keeps_the_clearance)
        .within("the hull, or `minimum_clearance_m` or `clearance_m` of the plugin, less one cell"),
    Law::new("every number of a path is finite", planner_paths::is_finite),
    Law::new("the final heading is passed on", planner_paths::passes_the_heading_on),
    Law::new("the same request gives the same path, also after others", deterministic).within("to the bit"),
    Law::new("a world turned or mirrored gives a path of the same length", symmetric)
        .within("2 cells and 2 %"),
    Law::new("a raised give_up ends the search", gives_up_at_once)
        .within("a way of some 6,500 cells, and a look every 1,000 expansions"),
    Law::new("a give_up raised during the search ends it", gives_up_later).within("the time is told only"),
    Law::new("a goal in a wall, outside the map or behind one is named", planner_faults::names_bad_goals),
    Law::new("an empty map is named", planner_faults::names_an_empty_map),
    Law::new("numbers that are not finite are named", planner_faults::names_bad_numbers),
    Law::new("huge numbers give an error", planner_faults::survives_huge_numbers),
    Law::new("a map of one cell is no trouble", planner_faults::plans_in_one_cell),
    Law::new("10,000 calls use finite memory", finite_memory).within("64 MiB").long(),
];

/// The planner and its questions.
pub struct Asked {
    /// The planner, built.
    pub planner: Box<dyn Planner>,
    subject: Subject,
}

impl Asked {
    /// A new planner, if what it needs can be made up.
    pub fn new(subject: &Subject) -> Result<Asked, Trouble> {
        subject.needs_only(&[Layer::Grid])?;
        Ok(Asked { planner: subject.build()?, subject: subject.clone() })
    }

    /// The way through this world.
    pub fn request(&self, world: &TextWorld) -> PlanRequest {
        PlanRequest {
            stamp: Time::ZERO,
            map: world.map(),
            grid: Some(world.grid.clone()),
            start: world.start,
            goal: world.goal,
            robot: Arc::new(self.subject.robot()),
            obstacles: Vec::new(),
            give_up: GiveUp::default(),
            trace: Trace::unwatched(),
        }
    }

    /// Plans where there surely is a way.
    pub fn path(&mut self, world: &TextWorld) -> Result<Path, Trouble> {
        let request = self.request(world);
        let path = self.planner.plan(&request);
        path.map_err(|error| Trouble::broken(format!("no path: {error}"), "a path: there is room enough"))
    }
}

/// The planner with a world that it must find its way through: the rooms, or the open floor for one that says of the rooms
/// that its own search ended (`Stuck`), or that it keeps farther from walls than the goal lies (`GoalTooClose`).
pub struct OnAWay {
    /// The planner.
    pub asked: Asked,
    /// The world.
    pub world: TextWorld,
    /// What it said of the rooms; empty where it found its way.
    pub why_not_rooms: String,
}

impl OnAWay {
    /// A new planner and its world.
    pub fn new(subject: &Subject) -> Result<OnAWay, Trouble> {
        let (mut asked, rooms) = (Asked::new(subject)?, TextWorld::rooms()?);
        let request = asked.request(&rooms);
        let why = match asked.planner.plan(&request) {
            Err(error @ (PlanError::Stuck { .. } | PlanError::GoalTooClose { .. })) => error.to_string(),
            _ => {
                return Ok(OnAWay {
                    asked: Asked::new(subject)?,
                    world: rooms,
                    why_not_rooms: String::new(),
                });
            }
        };
        Ok(OnAWay { asked: Asked::new(subject)?, world: TextWorld::open()?, why_not_rooms: why })
    }

    /// What is told beside a law that was kept.
    pub fn told(&self, what: String) -> Verdict {
        let rooms = &self.why_not_rooms;
        if rooms.is_empty() {
            return Ok(what);
        }
        Ok(format!(
            "{what}{}on the open floor, for in the rooms {rooms}",
            if what.is_empty() { "" } else { "; " }
        ))
    }
}

fn deterministic(subject: &Subject) -> Verdict {
    let way = OnAWay::new(subject)?;
    let world = way.world.clone();
    let (mut one, mut other) = (Asked::new(subject)?, Asked::new(subject)?);
    let first = one.path(&world)?;
    let same = |path: &Path, which: &str| {
        let found = || {
            let (n, m) = (first.points().len(), path.points().len());
            let [length, other_length] = [first.length_m(), path.length_m()];
            format!("{which}: {m} points of {other_length} m instead of {n} of {length} m")
        };
        expect(*path == first, found, "the same path")
    };
    same(&one.path(&world)?, "the same planner, asked again")?;
    let Pose2 { translation, .. } = world.start;
    let goal = world.goal.position;
    let mut back = world.clone();
    back.start = pose2(goal.x, goal.y, 1.0);
    back.goal = Goal { position: translation.vector.into(), yaw_rad: None };
    other.path(&back)?;
    same(&other.path(&world)?, "another planner that planned the way back before")?;
    way.told(String::new())
}

fn symmetric(subject: &Subject) -> Verdict {
    let mut way = OnAWay::new(subject)?;
    let world = way.world.clone();
    let length_m = way.asked.path(&world)?.length_m();
    let allowed_m = 2.0 * world.grid.resolution_m() + 0.02 * length_m;
    let mut worst_m = 0f64;
    for turn in Turn::BOTH {
        let turned_m = Asked::new(subject)?.path(&world.turned(turn)?)?.length_m();
        worst_m = worst_m.max((turned_m - length_m).abs());
        expect(
            (turned_m - length_m).abs() <= allowed_m,
            || format!("{length_m:.3} m as it is, {turned_m:.3} m {}", turn.name()),
            format!("a difference of at most {allowed_m:.3} m"),
        )?;
    }
    way.told(format!("{length_m:.2} m, and at most {worst_m:.3} m more or less"))
}

fn gives_up_at_once(subject: &Subject) -> Verdict {
    let world = TextWorld::serpentine(400)?;
    let mut asked = Asked::new(subject)?;
    let request = asked.request(&world);
    request.give_up.raise();
    let watch = Stopwatch::start();
    match asked.planner.plan(&request) {
        Err(PlanError::GivenUp) => Ok(format!("given up after {:.1} ms", watch.ms())),
        Err(other) => Err(Trouble::not_applicable(format!("its search ended before by itself: {other}"))),
        Ok(path) => {
            let found = format!("a finished path of {:.0} m, after {:.0} ms", path.length_m(), watch.ms());
            Err(Trouble::broken(found, "PlanError::GivenUp"))
        }
    }
}

fn gives_up_later(subject: &Subject) -> Verdict {
    const DELAY: Duration = Duration::from_millis(5);
    let world = TextWorld::serpentine(1000)?;
    let mut asked = Asked::new(subject)?;
    let request = asked.request(&world);
    let give_up = request.give_up.clone();
    let raiser = std::thread::spawn(move || {
        std::thread::sleep(DELAY);
        give_up.raise();
        Stopwatch::start()
    });
    let answer = asked.planner.plan(&request);
    // It only sleeps and raises a flag.
    let Ok(raised) = raiser.join() else {
        return Err(Trouble::not_applicable("the thread that raises give_up is gone"));
    };
    match answer {
        Err(PlanError::GivenUp) => Ok(format!("came back {:.1} ms later", raised.ms())),
        Ok(path) => {
            Ok(format!("a path of {:.0} m was finished {:.1} ms later", path.length_m(), raised.ms()))
        }
        Err(other) => Err(Trouble::not_applicable(format!("its search ended by itself: {other}"))),
    }
}

fn finite_memory(subject: &Subject) -> Verdict {
    let world = TextWorld::coarse_rooms()?;
    let mut asked = Asked::new(subject)?;
    stays_finite(|_| {
        // Whether there is a path does not matter here.
        let _ = asked.planner.plan(&asked.request(&world));
        Ok(())
    })
}
