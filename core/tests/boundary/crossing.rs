//! What goes in on one side comes out on the other.

use crate::doubles::desk;
use crate::worlds::{everything, full_estimate, full_map, odd_pose, odd_robot};
use crate::{build, registry, stage};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Twist, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Estimate, Goal, Obstacle, Path, PathPoint, Prior, Seen, StampedPose};
use rumbo_core::registry::{Built, Stage};
use rumbo_core::robot::Robot;
use rumbo_core::stages::*;
use rumbo_core::time::Time;
use rumbo_core::trace::{Drawing, Trace};
use std::sync::Arc;

fn path() -> Path {
    let point = |x: f64, yaw_rad| PathPoint { position: Point2::new(x, -x), yaw_rad };
    Path::new(vec![point(0.1, None), point(0.2, Some(1.0)), point(0.3, Some(-0.0))], 17.25).unwrap()
}

fn obstacles() -> Vec<Obstacle> {
    let obstacle = |x| Obstacle { position: Point2::new(x, 2.0), radius_m: 0.1 * x, stamp: Time(5) };
    vec![obstacle(1.0), obstacle(2.0)]
}

pub fn request() -> PlanRequest {
    let map = full_map();
    PlanRequest {
        stamp: Time(99),
        grid: map.grid.clone(),
        map,
        start: odd_pose(),
        goal: Goal { position: Point2::new(3.0, 4.0), yaw_rad: Some(0.5) },
        robot: Arc::new(odd_robot()),
        obstacles: obstacles(),
        give_up: GiveUp::default(),
        trace: Trace::watched(),
    }
}

#[test]
fn a_planner_gets_the_request_and_its_path_comes_back() {
    let mut planner: Box<dyn Planner> = stage(Stage::Planner, "double");
    let request = request();
    desk(|desk| desk.path = Some(path()));
    assert_eq!(planner.plan(&request), Ok(path()));
    desk(|desk| {
        assert_eq!(desk.map.as_ref(), Some(&request.map));
        assert_eq!(desk.robot.as_ref(), Some(request.robot.as_ref()));
        assert_eq!(desk.obstacles, request.obstacles);
        let expected = format!("{} {:?} {:?} false", request.stamp, request.start, request.goal);
        assert_eq!(desk.answers, [expected]);
        // Zero copy: the cells lie at the same address on both sides.
        assert_eq!(desk.cells_at, request.grid.as_ref().unwrap().cells.as_ptr().addr());
        desk.map = None;
    });
    assert_eq!(request.trace.take().1, [("expansions", 12.0)]);
    assert!(request.map.grid.as_ref().unwrap().cells.is_unique() || request.grid.is_some());
}

#[test]
fn a_raised_flag_is_seen_on_the_other_side() {
    let mut planner: Box<dyn Planner> = stage(Stage::Planner, "double");
    let request = request();
    let parent = GiveUp::default();
    let request = PlanRequest { give_up: parent.child(), ..request };
    parent.raise();
    desk(|desk| desk.path = Some(path()));
    planner.plan(&request).unwrap();
    desk(|desk| assert!(desk.answers[0].ends_with("true"), "{:?}", desk.answers));
}

#[test]
fn every_reason_of_a_planner_comes_back_as_itself() {
    let mut planner: Box<dyn Planner> = stage(Stage::Planner, "double");
    let (goal, start) = (Point2::new(1.5, 2.5), Point2::new(-1.0, 0.25));
    for error in [
        PlanError::MissingLayer { layer: "voxels" },
        PlanError::GoalOutside { goal },
        PlanError::GoalOccupied { goal, found: "not free" },
        PlanError::GoalTooClose { goal, found_m: 0.25, needed_m: 0.375 },
        PlanError::StartOutside { start },
        PlanError::StartOccupied { start, found: "too close" },
        PlanError::Unreachable { reason: "the door is closed".into() },
        PlanError::Stuck { place: start, reason: "a local minimum".into() },
        PlanError::GivenUp,
        PlanError::NotFinite { what: "the goal" },
        PlanError::Other("something else: ü".into()),
    ] {
        desk(|desk| desk.plan_error = Some(error.clone()));
        assert_eq!(planner.plan(&request()), Err(error));
    }
    desk(|desk| desk.plan_error = None);
}

#[test]
fn an_avoider_gets_everything_and_its_answers_come_back() {
    let mut avoider: Box<dyn Avoider> = stage(Stage::Avoider, "double");
    let (map, estimate, seen, robot) = (full_map(), full_estimate(), everything(), odd_robot());
    let (path, known) = (path(), obstacles());
    let trace = Trace::watched();
    let mut cx = Cx { now: Time(5), trace: &trace };
    for (number, answer) in [
        (1, Steering::Drive(Twist { forward_m_s: 0.25, left_m_s: -0.5, turn_rad_s: f64::NAN })),
        (1, Steering::Arrived),
        (2, Steering::Blocked { obstacles: obstacles() }),
        (2, Steering::Blocked { obstacles: Vec::new() }),
    ] {
        desk(|desk| desk.steering_to_give = Some(answer.clone()));
        let input = AvoidInput {
            map_from_base: odd_pose(),
            estimate: &estimate,
            twist: Twist::new(0.5, 0.25),
            seen: Seen::sorted(&seen),
            map: &map,
            grid: map.grid.as_ref(),
            path: Some(&path),
            path_number: number,
            arrival_radius_m: 0.1,
            obstacles: &known,
            robot: &robot,
        };
        let given = avoider.steer(&mut cx, &input).unwrap();
        assert_eq!(format!("{given:?}"), format!("{answer:?}"));
        desk(|desk| {
            assert_eq!(desk.map.take().as_ref(), Some(&map));
            assert_eq!(desk.estimate.as_ref(), Some(&estimate));
            assert_eq!(std::mem::take(&mut desk.seen), seen);
            assert_eq!(desk.path.as_ref(), Some(&path));
            assert_eq!(desk.obstacles, known);
            assert_eq!(desk.answers, [format!("{:?} {:?}", input.map_from_base, input.twist)]);
            assert_eq!(desk.cells_at, map.grid.as_ref().unwrap().cells.as_ptr().addr());
        });
        // Nobody on the other side holds on to the cells: a builder may write them in place.
        assert!(map.grid.as_ref().unwrap().cells.is_unique());
    }
    let (drawings, counters) = trace.take();
    assert_eq!(counters.len(), 4);
    assert_eq!(drawings[0], Drawing::Points { name: "dots", points: vec![Point2::new(1.0, 2.0)] });
    let input = AvoidInput {
        map_from_base: odd_pose(),
        estimate: &estimate,
        twist: Twist::ZERO,
        seen: Seen::NOTHING,
        map: &Map::default(),
        grid: None,
        path: None,
        path_number: 2,
        arrival_radius_m: 0.1,
        obstacles: &[],
        robot: &Robot::default(),
    };
    avoider.steer(&mut cx, &input).unwrap();
    desk(|desk| {
        assert_eq!(desk.map.take(), Some(Map::default()));
        assert!(desk.path.is_none() && desk.seen.is_empty() && desk.cells_at == 0);
    });
}

#[test]
fn a_localizer_gets_priors_and_its_estimate_comes_back_to_the_bit() {
    let mut localizer: Box<dyn Localizer> = stage(Stage::Localizer, "double");
    let map = full_map();
    let covariance = nalgebra::Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
    for prior in [
        Prior::Unknown,
        Prior::Pose { map_from_base: odd_pose(), odom_from_base: pose2(1.0, 2.0, 3.0), covariance },
        Prior::Saved(Buffer::from(vec![1u8, 2, 3])),
    ] {
        localizer.start(&prior, &map).unwrap();
        desk(|desk| assert_eq!(desk.prior.take(), Some(prior)));
    }
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time(5), trace: &trace };
    let seen = everything();
    assert_eq!(localizer.update(&mut cx, Seen::sorted(&seen), &map), Err(LocalizeError::NotStarted));
    for estimate in [full_estimate(), Estimate::lost(Time(3))] {
        desk(|desk| desk.estimate_to_give = Some(estimate.clone()));
        assert_eq!(localizer.update(&mut cx, Seen::sorted(&seen), &map), Ok(estimate));
        desk(|desk| assert_eq!(std::mem::take(&mut desk.seen), seen));
    }
    desk(|desk| desk.map = None);
}

#[test]
fn a_map_is_built_in_place_on_the_other_side() {
    let mut builder: Box<dyn MapBuilder> = stage(Stage::MapBuilder, "double");
    let mut map = Map::default();
    desk(|desk| desk.map = Some(full_map()));
    builder.start(&mut map).unwrap();
    desk(|desk| desk.map = None);
    assert_eq!(map, full_map());
    let (before, estimate, seen) =
        (map.grid.as_ref().unwrap().cells.as_ptr().addr(), full_estimate(), everything());
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time(5), trace: &trace };
    let input = MapInput { seen: Seen::sorted(&seen), estimate: &estimate };
    builder.insert(&mut cx, &input, &mut map).unwrap();
    let mut expected = full_map();
    for grid in expected.grid.iter_mut().chain(&mut expected.coarse_grids) {
        grid.cells.make_mut()[0] += 1.0;
    }
    expected.voxels.as_mut().unwrap().chunks.reverse();
    expected.version += 1;
    assert_eq!(map, expected);
    let after = map.grid.as_ref().unwrap().cells.as_ptr().addr();
    assert_eq!(before, after, "the cells were copied");
    desk(|desk| assert_eq!((&desk.seen, desk.estimate.as_ref()), (&seen, Some(&estimate))));
    // A snapshot is out: now the cells are copied, and the snapshot keeps the old ones.
    let snapshot = map.clone();
    builder.insert(&mut cx, &input, &mut map).unwrap();
    assert_ne!(map.grid.as_ref().unwrap().cells.as_ptr().addr(), after);
    assert_eq!(snapshot.grid, expected.grid);
}

#[test]
fn what_a_map_builder_keeps_and_the_map_that_it_saves_come_back() {
    let builder: Box<dyn MapBuilder> = stage(Stage::MapBuilder, "double");
    for (kept, found) in
        [(Some(vec![7, 0, 250]), Some(vec![7, 0, 250])), (None, None), (Some(Vec::new()), None)]
    {
        let mut map = full_map();
        desk(|desk| desk.kept = kept.clone());
        assert_eq!(builder.save(&mut map), Ok(found));
        assert_eq!(map.version, full_map().version + 1);
        assert_eq!(map.grid.unwrap().cells[0], full_map().grid.unwrap().cells[0] + 1.0);
    }
}

#[test]
fn a_slam_plugin_starts_updates_and_saves() {
    let mut slam: Box<dyn Slam> = stage(Stage::Slam, "double");
    let mut map = full_map();
    slam.start(&Prior::Unknown, &mut map).unwrap();
    assert_eq!(map, Map { grid: None, ..full_map() });
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time(5), trace: &trace };
    desk(|desk| desk.estimate_to_give = Some(full_estimate()));
    let seen = everything();
    assert_eq!(slam.update(&mut cx, Seen::sorted(&seen), &mut map), Ok(full_estimate()));
    assert_eq!(map.version, 42);
    assert_eq!(slam.save(), Ok(vec![1, 2, 250]));
}

#[test]
fn a_slam_plugin_is_told_where_the_robot_is_and_keeps_its_map() {
    let mut slam: Box<dyn Slam> = stage(Stage::Slam, "double");
    let mut map = full_map();
    let covariance = nalgebra::Matrix3::new_scaling(0.5);
    let there = Prior::Pose { map_from_base: odd_pose(), odom_from_base: pose2(1.0, 2.0, 3.0), covariance };
    assert_eq!(slam.relocate(&there, &mut map), Ok(()));
    desk(|desk| assert_eq!(desk.prior.take(), Some(there)));
    assert_eq!(map.grid.as_ref().unwrap().cells[0], full_map().grid.unwrap().cells[0] + 1.0);
    assert_eq!(slam.relocate(&Prior::Unknown, &mut map), Err(SlamError::CannotRelocate));
    desk(|desk| assert_eq!(desk.prior.take(), Some(Prior::Unknown)));
}

#[test]
fn the_map_that_a_slam_plugin_saves_comes_back_changed() {
    let slam: Box<dyn Slam> = stage(Stage::Slam, "double");
    let mut map = full_map();
    desk(|desk| desk.map = None);
    let told = slam.save_map(&mut map).unwrap_err().to_string();
    assert!(told.contains("nothing to draw"), "{told}");
    desk(|desk| desk.map = Some(Map::default()));
    let mut map = full_map();
    assert_eq!(slam.save_map(&mut map), Ok(()));
    assert_eq!(map.grid.unwrap().cells[0], full_map().grid.unwrap().cells[0] + 1.0);
}

#[test]
fn the_trajectory_of_a_slam_plugin_comes_back_to_the_bit() {
    let slam: Box<dyn Slam> = stage(Stage::Slam, "double");
    assert_eq!(slam.trajectory(), Ok(Vec::new()));
    let estimate = full_estimate();
    let pose = |k: i64| StampedPose {
        stamp: Time(k * 1_000_000_007),
        map_from_base: if k % 2 == 0 { estimate.map_from_base } else { estimate.map_from_odom },
    };
    let poses: Vec<_> = (-3..30_000).map(pose).collect();
    desk(|desk| desk.trajectory.clone_from(&poses));
    assert_eq!(slam.trajectory(), Ok(poses));
    // Whose turn it is decides nothing: a panic stays on the other side.
    let slam = built_slam("panic_in_call = true");
    let told = slam.trajectory().unwrap_err().to_string();
    assert!(told.contains("made to panic in a call"), "{told}");
    assert!(slam.trajectory().unwrap_err().to_string().contains("is not called again"));
}

fn built_slam(keys: &str) -> Box<dyn Slam> {
    match build(Stage::Slam, "double", keys).unwrap() {
        Built::Slam(slam) => slam,
        _ => panic!("no SLAM"),
    }
}

#[test]
fn an_instance_gets_its_context_and_the_same_random_numbers() {
    let mut context = BuildContext::bare("front");
    context.robot = Arc::new(odd_robot());
    context.seed = 12345;
    context.rate_hz = Some(7.5);
    context.folder = "some/folder".into();
    context.world_map = Some("world.yaml".into());
    context.wanted_layers = vec![rumbo_core::map::Layer::Grid, rumbo_core::map::Layer::Landmarks];
    context.dry_run = true;
    context.sensor = rumbo_core::messages::SensorId(3);
    let registry = registry();
    let entry = registry.get(Stage::Localizer, "double").unwrap();
    let made = entry.source.parse(toml::Table::new()).ok().unwrap().build(&context);
    assert!(matches!(made, Ok(Built::Localizer(_))));
    desk(|desk| {
        let found = desk.context.take().unwrap();
        let show = |context: &BuildContext| {
            let BuildContext { name, sensor, robot, base_from_sensor, rate_hz, seed, folder, .. } = context;
            let BuildContext { world_map, world_recording, wanted_layers, dry_run, .. } = context;
            format!(
                "{name} {sensor:?} {robot:?} {base_from_sensor} {rate_hz:?} {seed} {folder:?} {world_map:?} \
                 {world_recording:?} {wanted_layers:?} {dry_run}"
            )
        };
        assert_eq!(show(&found), show(&context));
        use rand::Rng as _;
        let mut rng = context.rng();
        assert_eq!(desk.random, (0..3).map(|_| rng.next_u64()).collect::<Vec<_>>());
    });
}

#[test]
fn faults_of_parameters_come_back_with_their_path_and_help() {
    let registry = registry();
    let entry = registry.get(Stage::Planner, "double").unwrap();
    let parse = |keys: &str| entry.source.parse(toml::from_str(keys).unwrap());
    let fault = parse("weights = [1.0, 'x']").err().unwrap();
    assert_eq!((fault.path.as_str(), fault.message.contains("string")), ("weights[1]", true), "{fault:?}");
    let ready = parse("weights = [1.0, -2.0]").ok().unwrap();
    let expected = BuildError::at("weights[1]", "is negative, expected at least 0").help("leave it out");
    assert_eq!(ready.check(), [expected]);
    assert_eq!(ready.parameters()["weights"].to_string(), "[1.0, -2.0]");
    assert!(build(Stage::Planner, "double", "weights = [0.5]").is_ok());
}
