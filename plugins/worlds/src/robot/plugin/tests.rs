use std::time::{Duration, Instant};

use rumbo_core::frames::Twist;
use rumbo_core::robot::Drive;
use rumbo_core::time::Span;

use super::*;
use crate::robot::params::EmulateParams;

/// Nothing here takes longer, however busy the machine is.
const MOST: Duration = Duration::from_secs(120);

fn emulated() -> RobotParams {
    RobotParams { emulate: Some(EmulateParams::default()), ..RobotParams::default() }
}

fn emulated_robot() -> EmulatedRobot {
    let (params, context) = (EmulateParams::default(), BuildContext::bare("world"));
    EmulatedRobot::new(params.place(&context).unwrap(), &params, &context)
}

fn built(params: &RobotParams) -> Box<dyn World> {
    params.build(&BuildContext::bare("world")).unwrap()
}

fn run(world: &mut dyn World, twist: Twist) -> Result<(), WorldError> {
    let to = world.now() + Span(20_000_000);
    world.advance(to)?;
    let stamp = world.now();
    world.drive(&Command { stamp, twist }).map(|_| ())
}

/// Lets time pass until something holds.
fn until<T>(world: &mut dyn World, what: &str, mut found: impl FnMut(&mut dyn World) -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        run(world, Twist::new(0.2, 0.0)).unwrap();
        if let Some(found) = found(world) {
            return found;
        }
        assert!(began.elapsed() < MOST, "{what}");
    }
}

#[test]
fn the_emulated_base_drives_and_tells_its_wheels_sonars_and_bumpers() {
    let mut world = built(&emulated());
    assert_eq!((world.now(), world.is_real_time()), (Time::ZERO, true));
    let notice = until(world.as_mut(), "a notice", |world| world.take_notice());
    assert_eq!(notice, "the base EMULATED answers");
    let rolled_m = until(world.as_mut(), "wheels", |world| match world.probe(&Probe::Wheels).unwrap() {
        Answer::Wheels(wheels) if wheels.rolled_m[0] > 0.05 => Some(wheels.rolled_m[0]),
        _ => None,
    });
    // The truth is that of the step, and the reading may be newer.
    run(world.as_mut(), Twist::ZERO).unwrap();
    assert!(world.truth().unwrap().map_from_base.translation.x >= rolled_m - 1e-3);
    let mount = rumbo_core::frames::Pose3::identity();
    let bearings_rad: Vec<f64> = (0..16).map(|k| std::f64::consts::TAU / 16.0 * f64::from(k)).collect();
    let cones = |n: usize| Probe::Cones {
        base_from_sensor: &mount,
        bearings_rad: &bearings_rad[..n],
        cone_rad: 25f64.to_radians(),
        ring_radius_m: 0.2,
        max_range_m: 6.5,
    };
    let stamp = until(world.as_mut(), "sonars", |world| match world.probe(&cones(16)).unwrap() {
        Answer::Recorded([observation]) => Some(observation.stamp),
        _ => None,
    });
    assert!(stamp <= world.now());
    let refused = world.probe(&cones(4)).unwrap_err().to_string();
    assert!(refused.contains("the sensor has 4 sonars, the base 16"), "{refused}");
    let n_touching = until(world.as_mut(), "bumpers", |world| match world.probe(&Probe::Contacts).unwrap() {
        Answer::Contacts(bearings) => Some(bearings.len()),
        _ => None,
    });
    assert_eq!(n_touching, 0);
    let beams = Probe::Beams {
        base_from_sensor: &mount,
        first_bearing_rad: 0.0,
        bearing_step_rad: 0.1,
        n_beams: 1,
        max_range_m: 5.0,
    };
    assert_eq!(world.probe(&beams), Ok(Answer::Live));
    let device = OwnDevice { model: "toaster", name: "breakfast", base_from_sensor: &mount };
    let unknown = world.emulated_device(&device).unwrap_err().to_string();
    assert!(unknown.contains("no emulated toaster"), "{unknown}");
}

#[test]
fn a_base_that_never_answers_ends_the_run_with_the_reason() {
    let params =
        RobotParams { port: Some("/dev/no_such_port".to_owned()), give_up_s: 0.5, ..RobotParams::default() };
    let mut world = built(&params);
    let began = Instant::now();
    let error = loop {
        if let Err(error) = run(world.as_mut(), Twist::ZERO) {
            break error.to_string();
        }
        assert!(began.elapsed() < MOST);
    };
    for part in ["the base at /dev/no_such_port", "no answer", "is the device plugged in?"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_base_with_another_drive_than_the_pipelines_ends_the_run() {
    // The emulated base behind a line of its own, and a host whose pipeline says something else.
    let mut robot = emulated_robot();
    let port = Some(robot.serve_base(Outlet::any().unwrap()).unwrap());
    let other = Robot { drive: Drive::Omnidirectional {}, ..Robot::default() };
    let context = BuildContext { robot: Arc::new(other), ..BuildContext::bare("world") };
    let mut world: Box<dyn World> = RobotParams { port, ..RobotParams::default() }.build(&context).unwrap();
    let began = Instant::now();
    let error = loop {
        if let Err(error) = run(world.as_mut(), Twist::ZERO) {
            break error.to_string();
        }
        assert!(began.elapsed() < MOST);
    };
    assert!(error.contains("its drive is differential, that of the pipeline is omnidirectional"), "{error}");
}

/// The last word of a world is that the robot shall stand.
#[test]
fn a_world_that_ends_leaves_the_base_standing() {
    let mut robot = emulated_robot();
    let port = Some(robot.serve_base(Outlet::any().unwrap()).unwrap());
    let mut world = built(&RobotParams { port, ..RobotParams::default() });
    let speed_m_s = |robot: &EmulatedRobot| robot.truth().unwrap().twist.forward_m_s;
    until(world.as_mut(), "motion", |_| (speed_m_s(&robot) > 0.05).then_some(()));
    drop(world);
    let began = Instant::now();
    while speed_m_s(&robot) != 0.0 {
        assert!(began.elapsed() < MOST);
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(robot.is_alive());
}

#[test]
fn a_check_opens_no_port_and_starts_no_thread() {
    let context = BuildContext { dry_run: true, ..BuildContext::bare("world") };
    let params = RobotParams { port: Some("/dev/no_such_port".to_owned()), ..RobotParams::default() };
    let mut world: Box<dyn World> = params.build(&context).unwrap();
    assert_eq!(world.probe(&Probe::Wheels), Ok(Answer::Recorded(&[])));
    assert_eq!(world.take_notice(), None);
}

#[test]
fn every_impossible_value_is_told_with_its_key() {
    let keys = |params: RobotParams| params.check().into_iter().map(|fault| fault.path).collect::<Vec<_>>();
    assert_eq!(keys(RobotParams::default()), ["port"]);
    assert_eq!(keys(emulated()), [""; 0]);
    let switched_off = EmulateParams { enabled: false, ..EmulateParams::default() };
    assert_eq!(keys(RobotParams { emulate: Some(switched_off), ..RobotParams::default() }), ["port"]);
    let emulate = EmulateParams { sonars: 65, sonar_cone_deg: 0.0, ..EmulateParams::default() };
    let start = Some(Start { x_m: f64::NAN, ..Start::default() });
    let port = Some("tcp://".to_owned());
    let wrong = RobotParams { port, baud: 0, give_up_s: -1.0, start, emulate: Some(emulate), map: None };
    let expected = ["port", "baud", "give_up_s", "start.x_m", "emulate.sonars", "emulate.sonar_cone_deg"];
    assert_eq!(keys(wrong), expected);
    // A fault of the simulated place is one of the table.
    let emulate = EmulateParams { map: Some("no_such_map.yaml".into()), ..EmulateParams::default() };
    let params = RobotParams { emulate: Some(emulate), ..RobotParams::default() };
    let error = Plugin::<dyn World>::build(&params, &BuildContext::bare("world")).err().unwrap();
    assert_eq!(error.path, "emulate.map");
}

/// What the laws of worlds ask of those that do not need a device.
#[test]
fn time_runs_forward_only_and_commands_are_finite() {
    let mut world = built(&emulated());
    world.advance(Time::from_secs(0.02)).unwrap();
    assert!(world.now() >= Time::from_secs(0.02));
    let back = world.advance(Time::from_secs(0.01));
    assert!(matches!(back, Err(WorldError::Backwards { .. })), "{back:?}");
    for twist in [Twist::new(f64::NAN, 0.0), Twist::new(0.0, f64::INFINITY)] {
        let stamp = world.now();
        assert_eq!(world.drive(&Command { stamp, twist }), Err(WorldError::NotFinite));
    }
    let channel = Probe::Channel { name: "no sensor is called this" };
    assert!(matches!(world.probe(&channel), Err(WorldError::Unsupported { .. })));
}
