//! Laws of planners.

use crate::text_world::{TextWorld, text_world};
use crate::{entries, twins};
use rumbo_core::frames::{Point2, pose2};
use rumbo_core::map::CellClass;
use rumbo_core::messages::{Check, Goal};
use rumbo_core::registry::Stage;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{BuildContext, GiveUp, PlanError, PlanRequest, Planner};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::sync::Arc;

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
        trace: Trace::unwatched(),
    }
}

/// Rooms of 2 m with doors of 1.5 m: any sensible clearance leaves a way.
fn rooms() -> TextWorld {
    text_world(
        0.25,
        "
        ##########################
        #...........#............#
        #...........#............#
        #..S........#............#
        #........................#
        #........................#
        #........................#
        #........................#
        #........................#
        #........................#
        #...........#............#
        #...........#........G...#
        #...........#............#
        #...........#............#
        ##########################",
    )
}

fn each(law: impl Fn(&str, Box<dyn Planner>, Box<dyn Planner>)) {
    for entry in entries(Stage::Planner) {
        let (one, other) = twins(&entry, &BuildContext::bare("planner"));
        law(&entry.name, one, other);
    }
}

#[test]
fn a_path_begins_at_the_start_ends_at_the_goal_and_touches_nothing() {
    each(|name, mut planner, _| {
        let world = rooms();
        let path = planner.plan(&request(&world)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(path.check(), Ok(()), "{name}");
        let grid = world.map.grid.as_ref().unwrap();
        let first = path.points()[0].position;
        assert!(
            (first - Point2::from(world.start.translation.vector)).norm() < 1e-9,
            "{name}: begins at {first}"
        );
        assert!(
            (path.end().position - world.goal.position).norm() < 0.26,
            "{name}: ends at {}",
            path.end().position
        );
        for piece in path.points().windows(2) {
            for k in 0..=200 {
                let at = piece[0].position + (piece[1].position - piece[0].position) * (f64::from(k) / 200.0);
                let class = grid.cell_at(at).map(|cell| grid.class(cell));
                assert_eq!(class, Some(CellClass::Free), "{name}: {at}");
            }
        }
    });
}

#[test]
fn the_same_request_gives_the_same_path_also_from_a_planner_that_has_planned_before() {
    each(|name, mut one, mut other| {
        let world = rooms();
        let first = one.plan(&request(&world)).unwrap();
        assert_eq!(one.plan(&request(&world)).as_ref(), Ok(&first), "{name}");
        let back = TextWorld {
            map: world.map.clone(),
            start: pose2(world.goal.position.x, world.goal.position.y, 1.0),
            goal: Goal { position: world.start.translation.vector.into(), yaw_rad: None },
        };
        other.plan(&request(&back)).unwrap();
        assert_eq!(other.plan(&request(&world)), Ok(first), "{name}");
    });
}

#[test]
fn a_raised_give_up_ends_the_search() {
    each(|name, mut planner, _| {
        let request = request(&rooms());
        request.give_up.raise();
        assert_eq!(planner.plan(&request).err(), Some(PlanError::GivenUp), "{name}");
    });
}

#[test]
fn a_goal_in_a_wall_outside_the_map_or_behind_one_is_named() {
    each(|name, mut planner, _| {
        let world = rooms();
        let mut in_wall = request(&world);
        in_wall.goal.position = Point2::new(0.1, 0.1);
        let error = planner.plan(&in_wall).unwrap_err();
        assert!(matches!(error, PlanError::GoalOccupied { .. }), "{name}: {error}");
        let mut outside = request(&world);
        outside.goal.position = Point2::new(-1.0, 50.0);
        let error = planner.plan(&outside).unwrap_err();
        assert!(matches!(error, PlanError::GoalOutside { .. }), "{name}: {error}");
        let mut closed = request(&world);
        let grid = closed.grid.as_mut().unwrap();
        for k in 0..60 {
            grid.occupy_disc(Point2::new(3.1, 0.0625 * f64::from(k)), 0.0);
        }
        let error = planner.plan(&closed).unwrap_err();
        assert!(matches!(error, PlanError::Unreachable { .. }), "{name}: {error}");
    });
}

#[test]
fn an_empty_map_and_numbers_that_are_none_are_named() {
    each(|name, mut planner, _| {
        let world = rooms();
        let mut empty = request(&world);
        (empty.map, empty.grid) = (Default::default(), None);
        let error = planner.plan(&empty).unwrap_err();
        assert!(matches!(error, PlanError::MissingLayer { .. }), "{name}: {error}");
        let mut nowhere = request(&world);
        nowhere.goal.position = Point2::new(f64::NAN, 1.0);
        let error = planner.plan(&nowhere).unwrap_err();
        assert!(matches!(error, PlanError::NotFinite { .. }), "{name}: {error}");
        let mut nowhere = request(&world);
        nowhere.start = pose2(f64::INFINITY, 0.0, 0.0);
        let error = planner.plan(&nowhere).unwrap_err();
        assert!(matches!(error, PlanError::NotFinite { .. }), "{name}: {error}");
    });
}

#[test]
fn a_map_of_one_cell_is_no_trouble() {
    each(|name, mut planner, _| {
        let world = text_world(5.0, "S");
        let path = planner.plan(&request(&world)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(path.length_m() < 1e-9, "{name}");
    });
}

#[test]
fn the_final_heading_is_passed_on() {
    each(|name, mut planner, _| {
        let mut request = request(&rooms());
        request.goal.yaw_rad = Some(1.0);
        assert_eq!(planner.plan(&request).unwrap().end().yaw_rad, Some(1.0), "{name}");
    });
}
