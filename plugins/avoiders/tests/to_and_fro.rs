//! A forklift in front of a wall whose path leads off to the side: pure pursuit with its own eyes, driven exactly.
#![allow(clippy::unwrap_used, clippy::panic)]

use rumbo_avoiders::pure_pursuit::{PurePursuit, PurePursuitParams};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, Pose3, Twist, pose2};
use rumbo_core::map::{Grid, GridHeader, Map};
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Obstacle, Path, Seen, SensorId};
use rumbo_core::robot::{Drive, Robot, SteeredWheel};
use rumbo_core::stages::{AvoidInput, Avoider, Cx, Steering};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;

const STEP_S: f64 = 0.05;
/// Two walls along the x axis, meters.
const WALLS_Y_M: [f64; 2] = [-1.55, 2.6];

fn forklift() -> Robot {
    let drive = Drive::Tricycle {
        wheelbase_m: 1.3,
        track_m: 0.9,
        max_steer_deg: 60.0,
        max_steer_rate_deg_s: 60.0,
        steered: SteeredWheel::Rear,
    };
    let footprint_m = vec![[-1.6, -0.5], [1.2, -0.5], [1.2, 0.5], [-1.6, 0.5]];
    Robot { drive, footprint_m, max_speed_m_s: 1.0, max_turn_deg_s: 45.0, ..Robot::default() }
}

/// All around: the nearer wall along each beam.
fn scan(stamp: Time, pose: &Pose2) -> Observation {
    let range = |beam: u32| {
        let direction = (f64::from(beam).to_radians() + pose.rotation.angle()).sin();
        let hits = WALLS_Y_M.map(|wall| (wall - pose.translation.y) / direction);
        let nearest = hits.into_iter().filter(|range| *range > 0.0).fold(40.0, f64::min);
        nearest as f32
    };
    let data = Data::LaserScan(LaserScan {
        first_bearing_rad: 0.0,
        bearing_step_rad: 1.0_f64.to_radians(),
        max_range_m: 20.0,
        ranges_m: Buffer::from((0..360).map(range).collect::<Vec<f32>>()),
        ..LaserScan::default()
    });
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

/// Cells of 0.1 m: free, with the walls where the map shows them.
fn grid(shows_walls: bool) -> Grid {
    let unknown = Grid::unknown(300, 100, 0.1).unwrap();
    let header = GridHeader { origin: [-20.0, -5.0, 0.0], ..*unknown.header() };
    let mut grid = Grid::new(header, unknown.cells).unwrap();
    for (idx, odds) in grid.cells.make_mut().iter_mut().enumerate() {
        let y = 0.1 * ((idx / 300) as f64 + 0.5) - 5.0;
        let is_wall = shows_walls && !(WALLS_Y_M[0]..WALLS_Y_M[1]).contains(&y);
        *odds = if is_wall { Grid::CERTAIN } else { -Grid::CERTAIN };
    }
    grid
}

enum Ended {
    Arrived { pose: Pose2, least_m: f64, n_turns_back: u32 },
    Blocked { obstacles: Vec<Obstacle>, pose: Pose2 },
}

fn drive(params: &PurePursuitParams, start: Pose2, goal: Point2, shows_walls: bool) -> Ended {
    let robot = forklift();
    let mut avoider = PurePursuit::new(params, &robot);
    let (map, grid, trace) = (Map::default(), grid(shows_walls), Trace::unwatched());
    let path = Path::through([start.translation.vector.into(), goal], 0.0).unwrap();
    let (mut pose, mut twist, mut now) = (start, Twist::ZERO, Time::ZERO);
    let (mut least_m, mut n_turns_back, mut way) = (f64::INFINITY, 0, 0.0_f64);
    for _ in 0..4000 {
        let seen = [scan(now, &pose)];
        let estimate = Estimate::planar(now, pose, pose, nalgebra::Matrix3::zeros());
        let input = AvoidInput {
            map_from_base: pose,
            estimate: &estimate,
            twist,
            seen: Seen::sorted(&seen),
            map: &map,
            grid: Some(&grid),
            path: Some(&path),
            path_number: 1,
            arrival_radius_m: 0.2,
            obstacles: &[],
            robot: &robot,
        };
        twist = match avoider.steer(&mut Cx { now, trace: &trace }, &input).unwrap() {
            Steering::Drive(wanted) => wanted,
            Steering::Arrived => return Ended::Arrived { pose, least_m, n_turns_back },
            Steering::Blocked { obstacles } => return Ended::Blocked { obstacles, pose },
            other => panic!("{other:?}"),
        };
        assert!((robot.drive.feasible(twist).turn_rad_s - twist.turn_rad_s).abs() < 1e-9, "{twist:?}");
        n_turns_back += u32::from(way * twist.forward_m_s < 0.0);
        way = if twist.forward_m_s == 0.0 { way } else { twist.forward_m_s };
        pose *= twist.integrate(STEP_S);
        for [x, y] in &robot.footprint_m {
            let corner = pose * Point2::new(*x, *y);
            least_m = least_m.min(corner.y - WALLS_Y_M[0]).min(WALLS_Y_M[1] - corner.y);
        }
        now = now + Span::from_secs(STEP_S);
    }
    panic!("still on its way at {pose}");
}

/// The nose is 0.35 m from a wall, the tail 1 m from the other one: no arc to either side leads out ahead.
#[test]
fn a_forklift_turns_to_and_fro_where_one_arc_does_not_lead_around() {
    for (goal_x, yaw_deg) in [(-7.0, -90.0_f64), (7.0, -90.0), (-7.0, -70.0), (7.0, -110.0)] {
        let start = pose2(0.0, 0.0, yaw_deg.to_radians());
        let goal = Point2::new(goal_x, 0.3);
        let Ended::Arrived { pose, least_m, n_turns_back } =
            drive(&PurePursuitParams::default(), start, goal, true)
        else {
            panic!("blocked on the way to {goal}")
        };
        assert!((Point2::from(pose.translation.vector) - goal).norm() <= 0.2, "{pose}");
        assert!(least_m > 0.03, "{goal}: {least_m}");
        assert!((1..12).contains(&n_turns_back), "{goal}: {n_turns_back}");
    }
}

/// What the map does not show, another plan may avoid: then the planner is asked.
#[test]
fn what_is_not_on_the_map_is_told_before_anything_else() {
    let start = pose2(0.0, 0.0, -90.0_f64.to_radians());
    let ended = drive(&PurePursuitParams::default(), start, Point2::new(-7.0, 0.3), false);
    let Ended::Blocked { obstacles, pose } = ended else { panic!("it did not ask") };
    assert!(!obstacles.is_empty() && pose.translation.vector.norm() < 0.5);
}

#[test]
fn a_robot_that_may_not_back_up_does_not_turn_to_and_fro() {
    let ahead_only = PurePursuitParams { backs_up: false, ..PurePursuitParams::default() };
    let start = pose2(0.0, 0.0, -90.0_f64.to_radians());
    let ended = drive(&ahead_only, start, Point2::new(-7.0, 0.3), true);
    assert!(matches!(ended, Ended::Blocked { .. }));
}
