//! The planner as the engine asks it.

use super::*;
use rumbo_core::frames::pose2;
use rumbo_core::messages::Goal;
use rumbo_core::stages::GiveUp;
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

/// 40 x 20 cells of 0.1 m, a wall in the middle that is open at its upper end.
fn grid() -> Grid {
    let mut grid = Grid::unknown(40, 20, 0.1).unwrap();
    let wall: Vec<usize> = (0..800).filter(|idx| idx % 40 == 20 && idx / 40 < 12).collect();
    let cells = grid.cells.make_mut();
    cells.fill(-Grid::CERTAIN);
    wall.into_iter().for_each(|idx| cells[idx] = Grid::CERTAIN);
    grid
}

fn request(goal: Point2) -> PlanRequest {
    PlanRequest {
        stamp: Time::ZERO,
        map: Default::default(),
        grid: Some(grid()),
        start: pose2(0.53, 0.51, 0.0),
        goal: Goal { position: goal, yaw_rad: Some(1.5) },
        robot: Default::default(),
        obstacles: Vec::new(),
        give_up: GiveUp::default(),
        trace: Trace::unwatched(),
    }
}

fn planner() -> Box<dyn Planner> {
    ThetaStarParams::default().build(&BuildContext::bare("planner")).unwrap()
}

#[test]
fn a_path_leads_from_the_very_start_to_the_very_goal_around_the_wall() {
    let path = planner().plan(&request(Point2::new(3.57, 0.52))).unwrap();
    let (first, end) = (path.points()[0], path.end());
    assert_eq!((first.position, end.position), (Point2::new(0.53, 0.51), Point2::new(3.57, 0.52)));
    assert_eq!(end.yaw_rad, Some(1.5));
    assert!(path.length_m() > 3.5 && path.length_m() < 4.6, "{}", path.length_m());
    let highest = path.points().iter().map(|p| p.position.y).fold(0.0, f64::max);
    assert!(highest > 1.2 + 0.25 && highest < 1.6, "{highest}");
}

#[test]
fn a_free_way_is_two_points_also_inside_one_cell() {
    for goal in [Point2::new(1.52, 0.93), Point2::new(0.56, 0.55)] {
        assert_eq!(planner().plan(&request(goal)).unwrap().points().len(), 2, "{goal}");
    }
}

#[test]
fn impossible_requests_are_named() {
    let goal = Point2::new(3.5, 0.5);
    assert!(matches!(planner().plan(&request(Point2::new(2.05, 0.5))), Err(PlanError::GoalOccupied { .. })));
    assert!(matches!(planner().plan(&request(Point2::new(9.0, 0.5))), Err(PlanError::GoalOutside { .. })));
    assert!(matches!(planner().plan(&request(Point2::new(2.2, 0.5))), Err(PlanError::GoalTooClose { .. })));
    let nowhere = Point2::new(f64::NAN, 0.5);
    assert!(matches!(planner().plan(&request(nowhere)), Err(PlanError::NotFinite { .. })));
    let blind = PlanRequest { grid: None, ..request(goal) };
    assert!(matches!(planner().plan(&blind), Err(PlanError::MissingLayer { .. })));
    let unwanted = request(goal);
    unwanted.give_up.raise();
    assert_eq!(planner().plan(&unwanted), Err(PlanError::GivenUp));
}
