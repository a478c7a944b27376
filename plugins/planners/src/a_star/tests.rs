use super::AStarParams;
use super::grid_a_star::{AStarFault, GridAStar};
use super::plugin::AStar;
use crate::text_world::{looking, request};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::Point2;
use rumbo_core::map::Grid;
use rumbo_core::stages::{PlanError, Planner};
use rumbo_kit::GridSize;
use rumbo_kit::cost_field::{StepRule, slow};
use rumbo_kit::proximity::CellKind;

/// Distance from the center of a cell to the nearest point of another cell.
fn gap(size: GridSize, cell: usize, other: usize) -> f64 {
    let ((a, b), (c, d)) = (size.col_row(cell), size.col_row(other));
    let beyond = |x: usize, y: usize| (x.abs_diff(y) as f64 - 0.5).max(0.0);
    beyond(a, c).hypot(beyond(b, d))
}

fn step(size: GridSize, a: usize, b: usize) -> (i64, i64) {
    let ((c0, r0), (c1, r1)) = (size.col_row(a), size.col_row(b));
    (c1 as i64 - c0 as i64, r1 as i64 - r0 as i64)
}

#[test]
fn paths_are_shortest_keep_their_clearance_and_cut_no_corners() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(61);
    let mut search = GridAStar::default();
    for round in 0..200 {
        let size = GridSize::new(2 + rng.next_u32() as usize % 90, 2 + rng.next_u32() as usize % 90);
        let clearance = [0.0, 0.6, 1.3][round % 3];
        let density = if clearance == 0.0 { 0.3 } else { 0.01 };
        let obstacle = |_| if rng.random_bool(density) { CellKind::Obstacle } else { CellKind::Free };
        let kinds: Vec<CellKind> = (0..size.n_cells()).map(obstacle).collect();
        let obstacles: Vec<usize> = (0..kinds.len()).filter(|&c| kinds[c] == CellKind::Obstacle).collect();
        let (start, goal) = (rng.random_range(0..kinds.len()), rng.random_range(0..kinds.len()));
        if kinds[start] != CellKind::Free || kinds[goal] != CellKind::Free {
            continue;
        }
        let found = search.plan(size, &kinds, clearance, start, goal, || false);
        if matches!(found, Err(AStarFault::GoalTooClose(_))) {
            continue;
        }
        let entries: Vec<f64> =
            (0..kinds.len()).map(|c| if search.is_open(c) { 1.0 } else { f64::INFINITY }).collect();
        let oracle = slow::cost_field(size, &entries, StepRule::default(), goal)[start];
        let Ok(path) = found else {
            assert_eq!(oracle, f64::INFINITY, "round {round}");
            continue;
        };
        assert_eq!(path.length.to_bits(), oracle.to_bits(), "round {round}");
        assert_eq!((path.cells.first(), path.cells.last()), (Some(&start), Some(&goal)));
        let steps: f64 = path
            .cells
            .windows(2)
            .map(|w| {
                let (dx, dy) = step(size, w[0], w[1]);
                assert!(dx.abs() <= 1 && dy.abs() <= 1 && (dx, dy) != (0, 0));
                for (x, y) in [(dx, 0), (0, dy)] {
                    let beside = size.neighbor(w[0], x as i32, y as i32).unwrap();
                    assert!(search.is_open(beside), "a corner is cut in round {round}");
                }
                (dx as f64).hypot(dy as f64)
            })
            .sum();
        assert!((steps - path.length).abs() < 1e-9);
        let start_is_clear = obstacles.iter().all(|&o| gap(size, start, o) >= clearance + 0.21);
        if start_is_clear {
            let nearest =
                |c: &usize| obstacles.iter().map(|&o| gap(size, *c, o)).fold(f64::INFINITY, f64::min);
            assert!(path.cells.iter().map(nearest).all(|d| d >= clearance), "round {round}");
        }
    }
}

#[test]
fn a_robot_too_near_to_a_wall_may_leave_but_not_come_nearer() {
    let picture = "
        ############
        #S.........#
        #..........#
        #..........#
        #.......G..#
        #..........#
        ############";
    let request = request(0.1, picture);
    let mut planner = AStar::new(AStarParams { clearance_m: Some(0.1), ..AStarParams::default() });
    let path = planner.plan(&request).unwrap();
    assert_eq!(path.points()[0].position, Point2::from(request.start.translation.vector));
    assert!(path.points().iter().all(|p| p.position.x >= 0.149 && p.position.y <= 0.551), "{path:?}");
}

#[test]
fn true_places_begin_and_end_the_path_also_on_a_turned_grid() {
    let mut request = request(
        0.5,
        "
        ........
        .####...
        .S..#.G.
        ....#...
        ........",
    );
    let old = request.grid.take().unwrap();
    let header = rumbo_core::map::GridHeader { origin: [10.0, -5.0, 2.0], ..*old.header() };
    let turned = Grid::new(header, old.cells.clone()).unwrap();
    let move_in = |p: Point2| turned.map_from_grid() * p;
    let start = move_in(Point2::from(request.start.translation.vector) + nalgebra::Vector2::new(0.2, -0.1));
    request.start = looking(start.x, start.y, 30.0);
    request.goal.position = move_in(request.goal.position) + nalgebra::Vector2::new(0.1, 0.1);
    request.goal.yaw_rad = Some(0.7);
    request.grid = Some(turned);
    let mut planner = AStar::new(AStarParams { clearance_m: Some(0.0), ..AStarParams::default() });
    let path = planner.plan(&request).unwrap();
    assert_eq!(path.points()[0].position, start);
    assert_eq!((path.end().position, path.end().yaw_rad), (request.goal.position, Some(0.7)));
    let grid = request.grid.as_ref().unwrap();
    for piece in path.points().windows(2) {
        for k in 0..=100 {
            let at = piece[0].position + (piece[1].position - piece[0].position) * (f64::from(k) / 100.0);
            let cell = grid.cell_at(at).unwrap();
            assert_eq!(grid.class(cell), rumbo_core::map::CellClass::Free, "{at} in {path:?}");
        }
    }
}

#[test]
fn what_closes_the_way_is_named() {
    let request = request(0.1, "S#G");
    let mut planner = AStar::new(AStarParams { clearance_m: Some(0.0), ..AStarParams::default() });
    assert!(matches!(planner.plan(&request), Err(PlanError::Unreachable { .. })));
    let mut planner = AStar::new(AStarParams { clearance_m: Some(0.3), ..AStarParams::default() });
    assert!(matches!(planner.plan(&request), Err(PlanError::GoalTooClose { .. })));
    assert_eq!(AStarParams { clearance_m: Some(f64::NAN), ..AStarParams::default() }.faults().len(), 1);
    assert_eq!(AStarParams { clearance_m: Some(-1.0), ..AStarParams::default() }.faults().len(), 1);
}
