//! A folder of the MRCLAM kind played through the traits.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Data, Marks, Observation};

use super::*;
use crate::log::{LogStart, TRUTH_INSIDE};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mrclam")
}

fn params() -> LogParams {
    LogParams { file: folder(), ..LogParams::default() }
}

fn build(params: &LogParams) -> Box<dyn World> {
    params.build(&BuildContext::bare("world")).unwrap_or_else(|error| panic!("{error}"))
}

fn fault(params: &LogParams) -> BuildError {
    params.build(&BuildContext::bare("world")).err().unwrap()
}

fn recorded(world: &mut dyn World, probe: &Probe<'_>) -> Vec<Observation> {
    match world.probe(probe) {
        Ok(Answer::Recorded(recorded)) => recorded.to_vec(),
        other => panic!("{other:?}"),
    }
}

const MOUNT: Pose3 = Pose3 {
    rotation: nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
    translation: nalgebra::Translation3::new(0.0, 0.0, 0.0),
};
const MARKS: Probe<'_> = Probe::Marks { base_from_sensor: &MOUNT, field_of_view_rad: 1.0, max_range_m: 8.0 };

#[test]
fn the_odometer_adds_velocities_up_to_where_the_robot_truly_was() {
    let mut world = build(&LogParams { truth: Some(TRUTH_INSIDE.into()), ..params() });
    let start = world.start().unwrap();
    assert!((start.translation.x - 0.4).abs() < 1e-6 && (start.rotation.angle() - 0.6).abs() < 1e-6);
    let mut n_readings = 0;
    loop {
        let due = world.next_recorded().unwrap();
        if world.advance(due).unwrap() == Advance::Ended {
            break;
        }
        for observation in recorded(world.as_mut(), &Probe::Wheels) {
            n_readings += 1;
            assert_eq!(observation.stamp, world.now());
            let Data::Odometry(odometry) = observation.data else { panic!("no odometry") };
            let truth = rumbo_core::frames::flatten(&world.truth().unwrap().map_from_base);
            let off = truth.inverse() * (start * odometry.odom_from_base);
            assert!(
                off.translation.vector.norm() < 1e-5 && off.rotation.angle().abs() < 1e-5,
                "{n_readings}"
            );
        }
    }
    assert_eq!(n_readings, 800);
    assert_eq!(world.drive(&Command::default()), Ok(Drove::NotActuated));
    assert_eq!((world.take_notice(), world.recording_file()), (None, Some(folder().as_path())));
}

#[test]
fn marks_are_seen_where_the_landmarks_are_and_robots_are_left_out() {
    let mut world = build(&LogParams { truth: Some(TRUTH_INSIDE.into()), ..params() });
    let places = rumbo_kit::mrclam::read_landmarks(&folder()).unwrap();
    let (mut n_marks, mut n_in_one) = (0, 0);
    while world.advance(world.next_recorded().unwrap()) != Ok(Advance::Ended) {
        for observation in recorded(world.as_mut(), &MARKS) {
            let Data::Marks(Marks { marks, range_deviation_m, bearing_deviation_rad }) = observation.data
            else {
                panic!("no marks")
            };
            assert!(range_deviation_m > 0.0 && bearing_deviation_rad > 0.0);
            n_in_one = n_in_one.max(marks.len());
            for mark in marks {
                let place = places.iter().find(|place| Some(place.subject) == mark.identity).unwrap();
                let truth = rumbo_core::frames::flatten(&world.truth().unwrap().map_from_base);
                let at = truth.inverse() * rumbo_core::frames::Point2::from(place.position_m);
                assert!((at.coords.norm() - mark.range_m).abs() < 2e-4);
                assert!((at.y.atan2(at.x) - mark.bearing_rad).abs() < 2e-4);
                n_marks += 1;
            }
        }
    }
    // 187 rows, 8 of them of another robot.
    assert_eq!(n_marks, 179);
    assert!(n_in_one > 1, "several marks of one picture are one reading");
}

#[test]
fn the_odometer_can_be_late_and_channels_have_names() {
    let channels = BTreeMap::from([("camera".to_owned(), "marks".to_owned())]);
    let late = LogParams { odometer_delay_s: 0.2, channels, ..params() };
    let mut world = build(&late);
    assert_eq!(world.start(), None, "without truth and start the robot may be anywhere");
    while world.now() < Time::from_secs(5.0) {
        let due = world.next_recorded().unwrap();
        world.advance(due).unwrap();
    }
    let of = |world: &mut dyn World, name: &str| recorded(world, &Probe::Channel { name });
    let (wheels, camera) = (of(world.as_mut(), "odometry"), of(world.as_mut(), "camera"));
    // The first mark is seen 0.15 s after the first command, and 0.05 s before it is obeyed.
    let [camera_s, wheels_s] = [&camera, &wheels].map(|seen| seen[0].stamp.as_secs());
    assert!(camera_s == 0.0 && (wheels_s - 0.05).abs() < 1e-6, "{camera_s} {wheels_s}");
    assert!(matches!(world.probe(&MARKS), Err(WorldError::Unsupported { .. })), "it has a name");
    assert!(matches!(world.probe(&Probe::Attitude), Err(WorldError::Unsupported { .. })));
    assert!(matches!(world.probe(&Probe::Channel { name: "laser" }), Err(WorldError::Unsupported { .. })));
    assert!(world.advance(Time::ZERO).is_err());
}

#[test]
fn faults_are_told_with_their_key() {
    let robot = fault(&LogParams { robot: 3, ..params() });
    assert!(robot.path == "file" && robot.message.contains("Robot3_Odometry.dat"), "{}", robot.message);
    let empty = fault(&LogParams { file: folder().join(".."), ..LogParams::default() });
    assert!(empty.message.contains("neither Robot1_Odometry.dat nor") && empty.help.is_some());
    let channels = BTreeMap::from([("laser".to_owned(), "front_laser".to_owned())]);
    let channel = fault(&LogParams { channels, ..params() });
    assert_eq!(channel.path, "channels.laser");
    assert!(channel.message.contains("expected odometry or marks"), "{}", channel.message);
    let bad = LogParams { robot: 0, odometer_delay_s: f64::NAN, ..params() };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["robot", "odometer_delay_s"]);
    let start = Some(LogStart { x_m: 1.0, y_m: 2.0, yaw_deg: 90.0 });
    let given = build(&LogParams { start, ..params() }).start().unwrap();
    assert!((given.translation.y - 2.0).abs() < 1e-12 && given.rotation.angle() > 1.5);
}
