use rumbo_core::frames::Twist;
use rumbo_core::registry::{Built, Registry, Stage};

use super::super::params::Companion;
use super::*;

const WALLS: &str = r#"
[[wall]]
from = [5, -5]
to = [5, 5]
[[mark]]
id = 4
at = [4.99, 1.0]
[[mark]]
id = 5
at = [6, 0]
"#;

fn params(name: &str, text: &str) -> SimParams {
    let path = std::env::temp_dir().join(format!("rumbo-sim-{name}-{}.toml", std::process::id()));
    std::fs::write(&path, text).unwrap();
    SimParams { map: Some(path), ..SimParams::default() }
}

fn world(name: &str) -> Box<dyn World> {
    params(name, WALLS).build(&BuildContext::bare("world")).unwrap()
}

fn command(forward_m_s: f64, turn_rad_s: f64) -> Command {
    Command { twist: Twist::new(forward_m_s, turn_rad_s), ..Command::default() }
}

#[test]
fn the_registry_builds_the_simulator() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::World, "sim").unwrap();
    let configured = entry.source.parse(toml::from_str("start = { x_m = 1.0 }").unwrap()).unwrap();
    let built = configured.build(&BuildContext::bare("world")).unwrap();
    let Built::World(world) = built else { panic!("not a world") };
    assert_eq!(world.start().unwrap().translation.x, 1.0);
    assert!(entry.source.parse(toml::from_str("strat = { x_m = 1.0 }").unwrap()).is_err());
    assert!(
        entry.source.parse(toml::from_str("slip = { model = 'gaussian', speed = 0.1 }").unwrap()).is_ok()
    );
}

#[test]
fn time_runs_forwards_only_and_drives_the_robot() {
    let mut world = world("time");
    assert_eq!(world.drive(&command(0.5, 0.0)), Ok(Drove::Drove));
    assert_eq!(world.advance(Time::from_secs(3.0)), Ok(Advance::Reached(Time::from_secs(3.0))));
    assert_eq!(world.now(), Time::from_secs(3.0));
    // 1 s of speeding up at 0.5 m/s², then 2 s at 0.5 m/s.
    let truth = world.truth().unwrap();
    assert!((truth.map_from_base.translation.x - 1.25).abs() < 1e-9);
    assert!((truth.clearance_m - (5.0 - 1.25 - 0.2)).abs() < 1e-9);
    let back = world.advance(Time::from_secs(2.0));
    assert!(matches!(back, Err(WorldError::Backwards { .. })));
    let Ok(Answer::Wheels(wheels)) = world.probe(&Probe::Wheels) else { panic!("no wheels") };
    assert!((wheels.rolled_m[0] - 1.25).abs() < 1e-9 && (wheels.rolled_m[1] - 1.25).abs() < 1e-9);
}

#[test]
fn what_is_not_finite_is_refused() {
    let mut world = world("finite");
    for twist in [Twist::new(f64::NAN, 0.0), Twist::new(0.0, f64::INFINITY)] {
        assert_eq!(world.drive(&Command { twist, ..Command::default() }), Err(WorldError::NotFinite));
    }
    let mount = Pose3::identity();
    let beams = |bearing_step_rad, n_beams, max_range_m| Probe::Beams {
        base_from_sensor: &mount,
        first_bearing_rad: 0.0,
        bearing_step_rad,
        n_beams,
        max_range_m,
    };
    assert!(world.probe(&beams(0.1, 3, 8.0)).is_ok());
    for bad in
        [beams(f64::NAN, 3, 8.0), beams(0.1, usize::MAX, 8.0), beams(0.1, 3, f64::NAN), beams(0.1, 3, -1.0)]
    {
        assert!(matches!(world.probe(&bad), Err(WorldError::Other(_))), "{bad:?}");
    }
}

#[test]
fn every_probe_of_a_simulation_is_answered() {
    let mut world = world("probes");
    let mount = rumbo_core::frames::lift(&pose2(0.1, 0.0, 0.0)) * nalgebra::Translation3::new(0.0, 0.0, 0.3);
    let Ok(Answer::Marks(marks)) =
        world.probe(&Probe::Marks { base_from_sensor: &mount, field_of_view_rad: 2.0, max_range_m: 9.0 })
    else {
        panic!("no marks")
    };
    assert_eq!(marks.marks.len(), 1, "mark 5 is behind the wall");
    let mark = marks.marks[0];
    assert_eq!(mark.identity, Some(4));
    assert!((mark.range_m - 4.89f64.hypot(1.0)).abs() < 1e-9);
    assert!((mark.bearing_rad - (1.0f64 / 4.89).atan()).abs() < 1e-9);
    assert_eq!(world.probe(&Probe::Position).unwrap(), Answer::Position([0.0; 3]));
    assert_eq!(world.probe(&Probe::Contacts).unwrap(), Answer::Contacts(&[]));
    let camera = Intrinsics { width: 4, height: 3, focal_px: [3.0, 3.0], center_px: [1.5, 1.0] };
    let depth = Probe::Depth { base_from_sensor: &mount, intrinsics: &camera, max_range_m: 9.0 };
    assert!(matches!(world.probe(&depth), Ok(Answer::Ranges(ranges)) if ranges.len() == 12));
    let channel = Probe::Channel { name: "scan" };
    assert!(matches!(world.probe(&channel), Err(WorldError::Unsupported { .. })));
    world.drive(&command(0.4, 0.5)).unwrap();
    world.advance(Time::from_secs(5.0)).unwrap();
    let Ok(Answer::Attitude(attitude)) = world.probe(&Probe::Attitude) else { panic!("no attitude") };
    assert_eq!(attitude.rates_rad_s, [0.0, 0.0, 0.5]);
    assert!((attitude.accelerations_m_s2[1] - 0.2).abs() < 1e-9, "{attitude:?}");
}

#[test]
fn slip_parts_the_wheels_from_the_truth_and_the_seed_decides_how() {
    let run = |seed: u64, n_pieces: i64| {
        let mut params = params("slip", WALLS);
        params.slip = toml::from_str("model = 'gaussian'\nspeed = 0.1\nturn = 0.1\ndrift_deg_m = 5.0").ok();
        let mut world = params.build(&BuildContext { seed, ..BuildContext::bare("world") }).unwrap();
        world.drive(&command(0.5, 0.1)).unwrap();
        for piece in 1..=n_pieces {
            world.advance(Time(piece * 4_000_000_000 / n_pieces)).unwrap();
        }
        let Ok(Answer::Wheels(wheels)) = world.probe(&Probe::Wheels) else { panic!("no wheels") };
        (world.truth().unwrap().map_from_base, wheels.rolled_m[0])
    };
    assert_eq!(run(1, 10), run(1, 10));
    assert_ne!(run(1, 10).0, run(2, 10).0);
    assert!((run(1, 10).1 - run(2, 10).1).abs() < 1e-12, "wheels roll as told");
    let (often, seldom) = (run(1, 137), run(1, 10));
    assert!(
        (often.0.translation.vector - seldom.0.translation.vector).norm() < 1e-3,
        "sensor rates change nothing"
    );
}

#[test]
fn a_bad_start_or_map_is_told_with_its_key() {
    let build = |params: SimParams| params.build(&BuildContext::bare("world")).err().unwrap();
    let start = |x_m: f64| SimParams { start: Start { x_m, ..Start::default() }, ..params("start", WALLS) };
    let error = build(start(4.9));
    assert_eq!((error.path.as_str(), error.help.is_some()), ("start", true));
    assert!(error.message.starts_with("the robot's hull overlaps something by 0.100 m"), "{}", error.message);
    assert_eq!(build(start(f64::NAN)).path, "start.x_m");
    assert_eq!(build(SimParams { map: Some("absent.toml".into()), ..SimParams::default() }).path, "map");
    let faulty = build(params("faulty", "[[wall]]\nfrom = [1, 2]\n"));
    assert!(faulty.message.contains(":1:1 wall[0].to: missing"), "{}", faulty.message);
    let slip = toml::from_str("model = 'gaussian'\nspeed = -1.0").ok();
    assert_eq!(build(SimParams { slip, ..SimParams::default() }).path, "slip.speed");
}

#[test]
fn a_start_beside_the_map_is_refused() {
    let image =
        MapImage { width: 10, height: 20, resolution_m: 0.1, origin: [1.0, 1.0, 0.0], cells: vec![0; 200] };
    assert!(check_on_map(&image, pose2(1.5, 2.5, 0.0), "start").is_ok());
    let error = check_on_map(&image, pose2(2.5, 1.5, 0.0), "start").unwrap_err();
    assert!(error.message.contains("covers 1.00 m by 2.00 m from its corner at (1, 1)"), "{}", error.message);
}

/// The nearest range straight ahead of the robot, for a laser of 0.3 m height.
fn ahead_m(world: &mut dyn World) -> f32 {
    let base_from_sensor = Pose3::translation(0.0, 0.0, 0.3);
    let probe = Probe::Beams {
        base_from_sensor: &base_from_sensor,
        first_bearing_rad: 0.0,
        bearing_step_rad: 0.1,
        n_beams: 1,
        max_range_m: 20.0,
    };
    let Ok(Answer::Ranges(ranges)) = world.probe(&probe) else { panic!("no ranges") };
    ranges[0]
}

#[test]
fn a_pipeline_adds_things_to_the_world_and_takes_things_away() {
    let named = "[[box]]\nname = 'desk'\ncenter = [3, 0]\nsize = [0.5, 0.5]\n";
    let built = |text: &str| {
        let with: SimParams = toml::from_str(text).unwrap();
        let base = params("things", &format!("{WALLS}{named}"));
        SimParams { map: base.map, ..with }.build(&BuildContext::bare("world"))
    };
    let ahead = |text: &str| ahead_m(built(text).unwrap().as_mut());
    assert!((ahead("") - 2.75).abs() < 1e-5);
    assert!((ahead("without = ['desk']") - 5.0).abs() < 1e-5);
    let add = "add = { box = [{ center = [2, 0], size = [0.2, 0.2] }], person = [{ route = [[1, 0]] }] }";
    assert!((ahead(add) - 0.75).abs() < 1e-5);
    let error = built("without = ['desc']").err().unwrap();
    assert!(error.path == "without[0]" && error.message.contains("desc"), "{error:?}");
    let faulty: SimParams = toml::from_str("add = { box = [{ center = [2, 0] }], bocks = [] }").unwrap();
    let paths: Vec<String> = faulty.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(paths, ["add.box[0].size", "add.bocks"]);
}

#[test]
fn a_companion_crosses_in_front_of_the_robot_wherever_it_drives() {
    let companion = Companion::default();
    for (time_s, left_m) in [(0.0, 1.0), (2.0, 0.0), (4.0, -1.0), (6.0, 0.0), (8.0, 1.0)] {
        assert!((companion.left_m(time_s) - left_m).abs() < 1e-12, "at {time_s} s");
    }
    let with = SimParams { companion: Some(companion), ..params("companion", WALLS) };
    let mut world = with.build(&BuildContext::bare("world")).unwrap();
    assert!((ahead_m(world.as_mut()) - 5.0).abs() < 1e-5, "at its left end");
    world.drive(&command(0.1, 0.0)).unwrap();
    world.advance(Time::from_secs(2.0)).unwrap();
    // In the middle: its disc of 0.2 m is met 1.5 m ahead, and it came along.
    assert!((ahead_m(world.as_mut()) - 1.3).abs() < 2e-3);
    let bad =
        SimParams { companion: Some(Companion { sway_m: f64::NAN, ..companion }), ..SimParams::default() };
    assert_eq!(bad.check()[0].path, "companion.sway_m");
}

#[test]
fn a_person_is_found_by_name_where_the_walk_is_and_nobody_else_is() {
    let people = r#"
[[person]]
name = "anna"
route = [[0, 3], [4, 3]]
speed_m_s = 0.5
start_s = 1.0
[[person]]
name = "bert"
route = [[-3, -3]]
speed_m_s = 0.0
"#;
    let mut world =
        params("people", &format!("{WALLS}{people}")).build(&BuildContext::bare("world")).unwrap();
    let mut at = |name: &str, seconds: f64| {
        world.advance(Time::from_secs(seconds)).unwrap();
        world.probe(&Probe::Person { name }).map(|answer| format!("{answer:?}"))
    };
    assert_eq!(at("anna", 0.5).unwrap(), "Position([0.0, 3.0, 0.0])");
    assert_eq!(at("anna", 5.0).unwrap(), "Position([2.0, 3.0, 0.0])");
    assert_eq!(at("bert", 5.0).unwrap(), "Position([-3.0, -3.0, 0.0])");
    let error = at("Anna", 5.0).unwrap_err();
    assert_eq!(error, WorldError::Unsupported { probe: "person of this name" });
    // On the way back along the route.
    assert_eq!(at("anna", 11.0).unwrap(), "Position([3.0, 3.0, 0.0])");
}

/// A slope of 3 in 4 begins at x = 2 and ends in a platform of 1.5 m at x = 4; a wall of 4 m stands at x = 9.
const HILL: &str = "[[ramp]]\ncenter = [3, 0]\nsize = [2, 4]\nz_to_m = 1.5\n\
                    [[step]]\ncenter = [6, 0]\nsize = [4, 4]\nheight_m = 1.5\n\
                    [[wall]]\nfrom = [9, -5]\nto = [9, 5]\nheight_m = 4\n";

fn hill(name: &str, more: &str) -> Box<dyn World> {
    let with: SimParams = toml::from_str(more).unwrap();
    SimParams { map: params(name, HILL).map, ..with }.build(&BuildContext::bare("world")).unwrap()
}

#[test]
fn a_robot_drives_up_a_ramp_and_its_sensors_tilt_with_it() {
    let mut world = hill("hill", "");
    // Level, 0.3 m over the floor: the ramp is as high 0.4 m after its foot.
    assert!((ahead_m(world.as_mut()) - 2.4).abs() < 1e-6);
    world.drive(&command(0.5, 0.0)).unwrap();
    world.advance(Time::from_secs(6.5)).unwrap();
    let truth = *world.truth().unwrap();
    let at = truth.map_from_base.translation;
    assert!(at.x > 2.5 && at.x < 3.6, "{at}");
    assert!((at.z - (at.x - 2.0) * 0.75).abs() < 1e-9, "{at}");
    let Ok(Answer::Attitude(attitude)) = world.probe(&Probe::Attitude) else { panic!("no attitude") };
    assert!((attitude.attitude_rad[1] + 0.6f64.asin()).abs() < 1e-9, "{attitude:?}");
    assert!((attitude.accelerations_m_s2[0] - 9.81 * 0.6).abs() < 1e-6, "{attitude:?}");
    // The beam is parallel to the slope and leaves over the platform; the wall is 4 m high.
    let mount = truth.map_from_base * nalgebra::Point3::new(0.0, 0.0, 0.3);
    let expected = (4.0 - mount.z) / 0.6;
    assert!(expected < (9.0 - mount.x) / 0.8, "over the wall");
    assert!(ahead_m(world.as_mut()).is_infinite());
    // Backwards it looks down and meets the floor before the ramp.
    let behind = Pose3::translation(0.0, 0.0, 0.3)
        * nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::PI);
    let probe = Probe::Beams {
        base_from_sensor: &behind,
        first_bearing_rad: 0.0,
        bearing_step_rad: 0.1,
        n_beams: 1,
        max_range_m: 20.0,
    };
    let Ok(Answer::Ranges(&[range_m])) = world.probe(&probe) else { panic!("no range") };
    assert!((f64::from(range_m) - mount.z / 0.6).abs() < 1e-5, "{range_m}");
    assert_eq!(world.probe(&Probe::Position).unwrap(), Answer::Position(at.vector.into()));
    // On the way up the wheels roll more than the map shows.
    let Ok(Answer::Wheels(wheels)) = world.probe(&Probe::Wheels) else { panic!("no wheels") };
    assert!(wheels.rolled_m[0] > at.x + 0.15, "{wheels:?}");
    world.advance(Time::from_secs(12.0)).unwrap();
    let at = world.truth().unwrap().map_from_base.translation;
    assert!((at.z - 1.5).abs() < 1e-9 && at.x > 4.5, "{at}");
    assert!((ahead_m(world.as_mut()) - (9.0 - at.x) as f32).abs() < 1e-5);
}

#[test]
fn edges_that_are_too_high_and_ramps_that_are_too_steep_stop_the_robot() {
    let x_after = |more: &str| {
        let mut world = hill("edges", more);
        world.drive(&command(0.5, 0.0)).unwrap();
        world.advance(Time::from_secs(30.0)).unwrap();
        let truth = *world.truth().unwrap();
        (truth.map_from_base.translation.x, truth.driven_contact_episodes)
    };
    let (x_m, contacts) = x_after("wheels = { max_slope_deg = 30.0 }");
    assert!((x_m - 1.8).abs() < 1e-3 && contacts == Some(1), "at the ramp's foot: {x_m}");
    let (x_m, contacts) = x_after("");
    assert!((x_m - 7.8).abs() < 1e-3 && contacts == Some(1), "at the platform's end: {x_m}");
}

#[test]
fn things_that_stand_lower_or_hang_higher_than_the_robot_are_not_in_its_way() {
    let low =
        "add = { box = [{ center = [6, 0], size = [0.2, 0.2], z_max_m = 1.4 }] }\nstart = { x_m = 5.0 }";
    let clearance = |more: &str| hill("low", more).truth().unwrap().clearance_m;
    // To the platform's end at x = 8 or its sides at y = 2.
    assert!((clearance(low) - 1.8).abs() < 1e-6, "{}", clearance(low));
    assert!((clearance(&low.replace("1.4", "1.6")) - 0.7).abs() < 1e-6);
    assert!((clearance(&low.replace("z_max_m = 1.4", "z_min_m = 2.1, z_max_m = 3.0")) - 1.8).abs() < 1e-6);
}

#[test]
fn a_kidnapped_robot_is_elsewhere_and_its_wheels_know_nothing() {
    let text = "kidnap = { at_s = 2.0, to = { x_m = 2.0, y_m = 1.0, yaw_deg = 90.0 } }";
    let build = |text: &str| {
        let with: SimParams = toml::from_str(text).unwrap();
        SimParams { map: params("kidnap", WALLS).map, ..with }.build(&BuildContext::bare("world"))
    };
    let mut world = build(text).unwrap();
    world.advance(Time::from_secs(2.0)).unwrap();
    assert_eq!(world.truth().unwrap().map_from_base.translation.x, 0.0);
    world.advance(Time::from_secs(2.01)).unwrap();
    let truth = *world.truth().unwrap();
    assert!((truth.map_from_base.translation.vector - nalgebra::Vector3::new(2.0, 1.0, 0.0)).norm() < 1e-12);
    assert!((truth.clearance_m - 2.8).abs() < 1e-9, "{}", truth.clearance_m);
    let Ok(Answer::Wheels(wheels)) = world.probe(&Probe::Wheels) else { panic!("no wheels") };
    assert_eq!(wheels.rolled_m[0], 0.0);
    assert_eq!(build(&text.replace("x_m = 2.0", "x_m = 4.95")).err().unwrap().path, "kidnap.to");
}

#[test]
fn wheels_that_spin_turn_and_the_robot_stays() {
    let mut world = SimParams {
        spins: vec![super::super::Spin { from_s: 2.0, to_s: Some(4.0), area: None }],
        ..params("spins", WALLS)
    }
    .build(&BuildContext::bare("world"))
    .unwrap();
    world.drive(&command(0.5, 0.0)).unwrap();
    let mut at = |seconds: f64| {
        world.advance(Time::from_secs(seconds)).unwrap();
        let Ok(Answer::Wheels(wheels)) = world.probe(&Probe::Wheels) else { panic!("no wheels") };
        (world.truth().unwrap().map_from_base.translation.x, wheels.rolled_m[0])
    };
    let before = at(2.0);
    let after = at(4.0);
    assert!((after.0 - before.0).abs() < 1e-12 && (after.1 - before.1 - 1.0).abs() < 1e-9, "{after:?}");
    assert!(at(5.0).0 > after.0 + 0.45);
}
