use super::DpParams;
use super::grid_dp::{DpRequest, GridDp};
use super::plugin::Dp;
use crate::text_world::{looking, request};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::Point2;
use rumbo_core::messages::Path;
use rumbo_core::stages::{PlanError, PlanRequest, Planner};
use rumbo_kit::GridSize;
use rumbo_kit::proximity::CellKind;

fn plan(params: DpParams, request: &PlanRequest) -> Result<Path, PlanError> {
    Dp::new(params).plan(request)
}

/// Two rooms of 3 m with a door of 1 m, cells of 0.1 m.
fn two_rooms() -> PlanRequest {
    let wall = format!("{}\n", "#".repeat(63));
    let room = format!("#{}#{}#\n", ".".repeat(30), ".".repeat(30));
    let door = format!("#{}{}{}#\n", ".".repeat(30), ".", ".".repeat(30));
    let ends = format!("#....S{}#{}G.....#\n", ".".repeat(25), ".".repeat(24));
    let picture =
        [wall.clone(), room.repeat(5), ends, room.repeat(4), door.repeat(10), room.repeat(10), wall];
    request(0.1, &picture.concat())
}

#[test]
fn a_path_through_a_door_goes_through_its_middle() {
    let request = two_rooms();
    let path = plan(DpParams::default(), &request).unwrap();
    assert_eq!(path.points()[0].position, Point2::from(request.start.translation.vector));
    assert_eq!(path.end().position, request.goal.position);
    let crossing = path.points().windows(2).find_map(|w| {
        let (a, b) = (w[0].position, w[1].position);
        let t = (3.15 - a.x) / (b.x - a.x);
        (0.0..=1.0).contains(&t).then(|| a.y + t * (b.y - a.y))
    });
    // The door lies between y = 1.1 and 2.1 m.
    assert!((crossing.unwrap() - 1.6).abs() < 0.11, "{crossing:?}");
    assert!(path.points().len() <= 5, "{path:?}");
}

#[test]
fn thesis_mode_keeps_the_turns_in_a_door() {
    let request = two_rooms();
    // A door narrower than twice the preferred clearance: the published test can never be met in it.
    let params = DpParams { preferred_clearance_m: 0.8, ..DpParams::default() };
    let thesis = plan(DpParams { thesis_mode: true, ..params.clone() }, &request).unwrap();
    let ours = plan(params, &request).unwrap();
    assert!(thesis.points().len() > ours.points().len(), "{thesis:?} and {ours:?}");
}

#[test]
fn a_closed_or_narrow_door_is_named_with_its_place() {
    let params = DpParams { minimum_clearance_m: 0.6, preferred_clearance_m: 0.6, ..DpParams::default() };
    let mut request = two_rooms();
    let Err(PlanError::Unreachable { reason }) = plan(params, &request) else {
        panic!("the door is too narrow")
    };
    assert!(
        reason.contains("narrowest passage, at (3.15, 1.") && reason.contains("at most 0.50"),
        "{reason}"
    );
    let grid = request.grid.as_mut().unwrap();
    (0..20).for_each(|k| grid.occupy_disc(Point2::new(3.15, 1.125 + 0.05 * f64::from(k)), 0.0));
    let Err(PlanError::Unreachable { reason }) = plan(DpParams::default(), &request) else {
        panic!("closed")
    };
    assert!(reason.contains("the thinnest obstacle, 0.10 m of it, stands at (3.15"), "{reason}");
}

/// The two rooms, with obstacles that were found on the way: discs of the map's frame.
fn two_rooms_with(found: &[(f64, f64, f64)]) -> PlanRequest {
    let mut request = two_rooms();
    request.map.grid = request.grid.clone();
    let grid = request.grid.as_mut().unwrap();
    for (x, y, radius_m) in found {
        grid.occupy_disc(Point2::new(*x, *y), *radius_m);
    }
    request
}

fn reason(request: &PlanRequest) -> String {
    match plan(DpParams::default(), request) {
        Err(PlanError::Unreachable { reason }) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_was_found_on_the_way_is_told_apart_from_the_map() {
    // Across the whole door: it is a cell thick and a meter wide.
    let shut: Vec<(f64, f64, f64)> = (0..10).map(|k| (3.15, 1.15 + 0.1 * f64::from(k), 0.0)).collect();
    let closed = reason(&two_rooms_with(&shut));
    let expected = "every way is closed; the least that opens one: take away what was found on the way at \
                    (3.15, 1.60) m, 1.00 m across, not on the map";
    assert_eq!(closed, expected);
    // A crate in the door leaves gaps that are too narrow, and another stands in a corner.
    let crate_in_door = [(3.15, 1.6, 0.2), (5.0, 0.5, 0.05)];
    let narrow = reason(&two_rooms_with(&crate_in_door));
    assert!(narrow.contains("the narrowest passage, at (3.") && narrow.contains("take it away"), "{narrow}");
    assert!(narrow.contains("found on the way at (3.15, 1.65) m, 0.71 m across"), "{narrow}");
    assert!(narrow.contains("; also found on the way: at (5.00, 0.50) m"), "{narrow}");
    // Without it there is a way.
    assert!(plan(DpParams::default(), &two_rooms_with(&crate_in_door[1..])).is_ok());
    // What the map shows is not called found.
    let mut on_map = two_rooms_with(&shut);
    on_map.map.grid = on_map.grid.clone();
    assert!(!reason(&on_map).contains("found on the way"));
}

#[test]
fn more_obstacles_than_can_be_named_are_counted() {
    let mut found: Vec<(f64, f64, f64)> = (0..10).map(|k| (3.15, 1.15 + 0.1 * f64::from(k), 0.0)).collect();
    found.extend((0..6).map(|k| (4.0 + 0.8 * f64::from(k % 3), 0.4 + f64::from(k / 3), 0.0)));
    assert!(reason(&two_rooms_with(&found)).ends_with(" and 2 more"), "{}", reason(&two_rooms_with(&found)));
}

#[test]
fn a_robot_inside_the_forbidden_band_leaves_it_and_one_without_room_backs_off() {
    let mut request = two_rooms();
    // The robot's cell is 0.3 m from the wall on the left; an obstacle ahead leaves 0.3 m, below the 0.4 m kept.
    request.start = looking(0.55, 1.65, 0.0);
    let params = DpParams { minimum_clearance_m: 0.4, preferred_clearance_m: 0.5, ..DpParams::default() };
    let path = plan(params.clone(), &request).unwrap();
    assert!(path.points().iter().all(|p| p.yaw_rad.is_none()));
    request.grid.as_mut().unwrap().occupy_disc(Point2::new(0.85, 1.65), 0.0);
    assert!(plan(params.clone(), &request).is_ok(), "0.3 m is enough for a radius of 0.2 m to leave");
    // A block right ahead: 0.2 m is less than radius and margin, 0.1 m back is enough.
    request.start = looking(1.95, 1.65, 0.0);
    request.grid.as_mut().unwrap().occupy_disc(Point2::new(2.15, 1.65), 0.0);
    let path = plan(params.clone(), &request).unwrap();
    let back = path.points()[1];
    assert!((back.position - Point2::new(1.85, 1.65)).norm() < 1e-9 && back.yaw_rad == Some(0.0), "{path:?}");
    assert_eq!(path.end().position, request.goal.position);
    // The same with a wall behind.
    request.grid.as_mut().unwrap().occupy_disc(Point2::new(1.85, 1.65), 0.0);
    let error = plan(params, &request).unwrap_err();
    assert!(matches!(error, PlanError::StartOccupied { .. }), "{error}");
}

#[test]
fn a_goal_near_a_wall_says_how_near() {
    let mut request = two_rooms();
    request.goal.position = Point2::new(5.0, 0.25);
    let Err(PlanError::GoalTooClose { found_m, needed_m, .. }) = plan(DpParams::default(), &request) else {
        panic!("the goal is 0.2 m from the wall")
    };
    assert!((found_m - 0.2).abs() < 1e-9 && needed_m == 0.30);
}

#[test]
fn unknown_cells_are_obstacles_or_just_closed() {
    let picture = "
        ###########
        #S.......G#
        #.........#
        #????.????#
        ###########";
    let request = request(0.1, picture);
    let params = DpParams { minimum_clearance_m: 0.1, preferred_clearance_m: 0.2, ..DpParams::default() };
    let near = plan(params.clone(), &request).unwrap();
    let apart = plan(DpParams { undetermined_is_obstacle: false, ..params }, &request).unwrap();
    assert!(apart.cost < near.cost, "{} and {}", apart.cost, near.cost);
}

#[test]
fn every_impossible_parameter_is_reported_at_once() {
    let params = DpParams {
        preferred_clearance_m: f64::NAN,
        minimum_clearance_m: -1.0,
        penalty_unit_m: 0.0,
        diagonal_step: 3.0,
        back_off_m: f64::INFINITY,
        ..DpParams::default()
    };
    let keys: Vec<String> = params.faults().into_iter().map(|fault| fault.path).collect();
    let expected =
        ["preferred_clearance_m", "minimum_clearance_m", "back_off_m", "diagonal_step", "penalty_unit_m"];
    assert_eq!(keys, expected);
    let crossed = DpParams { minimum_clearance_m: 0.5, ..DpParams::default() };
    assert_eq!(crossed.faults()[0].path, "minimum_clearance_m");
    let steep = DpParams { penalty_unit_m: 1e-4, ..DpParams::default() };
    assert_eq!(steep.faults()[0].path, "penalty_unit_m");
    assert!(DpParams::default().faults().is_empty());
}

#[test]
fn a_planner_that_remembers_plans_like_a_new_one() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(51);
    let size = GridSize::new(70, 50);
    let rules = DpParams { minimum_clearance_m: 0.1, preferred_clearance_m: 0.25, ..DpParams::default() }
        .rules(0.1, 0.05);
    let mut kinds = vec![CellKind::Free; size.n_cells()];
    let mut remembers = GridDp::default();
    for round in 0..60 {
        // Mostly more obstacles, now and then fewer.
        for _ in 0..rng.random_range(0..12) {
            let cell = rng.random_range(0..size.n_cells());
            kinds[cell] = if round % 7 == 6 { CellKind::Free } else { CellKind::Obstacle };
        }
        let point = |rng: &mut Xoshiro256PlusPlus| [rng.random_range(0.0..70.0), rng.random_range(0.0..50.0)];
        let request =
            DpRequest { start: point(&mut rng), heading_rad: 1.0, goal: rng.random_range(0..size.n_cells()) };
        let warm = remembers.plan(size, &kinds, &rules, &request, &mut || false);
        let cold = GridDp::default().plan(size, &kinds, &rules, &request, &mut || false);
        assert_eq!(warm, cold, "round {round}");
    }
}
