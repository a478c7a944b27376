//! Recordings played through the traits: what comes when, to whom, and what people are told.

use std::sync::atomic::{AtomicU32, Ordering};

use rumbo_core::frames::{Pose3, Twist, flatten};
use rumbo_core::messages::{Data, Observation};
use rumbo_core::registry::{Registry, Stage};

use super::*;
use crate::log::LogStart;
use crate::log::TRUTH_INSIDE;

/// A file that goes with its test.
struct TempFile(PathBuf);

impl TempFile {
    fn new(text: &str) -> TempFile {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("rumbo-log-world-{}-{n}.clf", std::process::id()));
        std::fs::write(&path, text).unwrap();
        TempFile(path)
    }
}

impl Drop for TempFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn flaser(x: f64, stamp: f64) -> String {
    format!("FLASER 3 1 2 81.9 {} 7 0 {x} 0 0 {stamp:.6} h 0\n", 10.0 + x)
}

fn odom(x: f64, stamp: f64) -> String {
    format!("ODOM {x} 0 0 0 0 0 {stamp:.6} h 0\n")
}

fn build(params: &LogParams) -> Box<dyn World> {
    params.build(&BuildContext::bare("world")).unwrap_or_else(|error| panic!("{error}"))
}

/// Ten seconds at 1 m/s, a scan every second and odometry in between, from 976052857 s on.
fn drive_text() -> String {
    let at = |k: i32| 976_052_857.0 + f64::from(k);
    (0..10).map(|k| flaser(f64::from(k), at(k)) + &odom(f64::from(k) + 0.5, at(k) + 0.5)).collect()
}

const BEAMS: Probe<'_> = Probe::Beams {
    base_from_sensor: &Pose3 {
        rotation: nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
        translation: nalgebra::Translation3::new(0.0, 0.0, 0.0),
    },
    first_bearing_rad: 0.0,
    bearing_step_rad: 0.1,
    n_beams: 3,
    max_range_m: 8.0,
};

fn recorded(world: &mut dyn World, probe: &Probe<'_>) -> Vec<Observation> {
    match world.probe(probe) {
        Ok(Answer::Recorded(recorded)) => recorded.to_vec(),
        other => panic!("{other:?}"),
    }
}

/// Everything that a probe gives until the recording ends, and every notice.
fn play(world: &mut dyn World, probe: &Probe<'_>) -> (Vec<Observation>, Vec<String>) {
    let (mut observations, mut notices) = (Vec::new(), Vec::new());
    loop {
        let due = world.next_recorded().unwrap();
        let advanced = world.advance(due).unwrap();
        notices.extend(std::iter::from_fn(|| world.take_notice()));
        if advanced == Advance::Ended {
            return (observations, notices);
        }
        let new = recorded(world, probe);
        assert!(new.iter().all(|observation| observation.stamp <= world.now()), "knows the future");
        observations.extend(new);
    }
}

#[test]
fn a_log_plays_at_its_own_stamps_from_zero_and_then_ends() {
    let file = TempFile::new(&drive_text());
    let params = LogParams { file: file.0.clone(), ..LogParams::default() };
    let mut world = build(&params);
    assert_eq!((world.now(), world.next_recorded()), (Time::ZERO, Some(Time::ZERO)));
    assert_eq!(world.recording_file(), Some(file.0.as_path()));
    let (scans, notices) = play(world.as_mut(), &BEAMS);
    assert_eq!(scans.len(), 10);
    assert_eq!((scans[0].stamp, scans[9].stamp), (Time::ZERO, Time::from_secs(9.0)));
    let Data::LaserScan(scan) = &scans[3].data else { panic!("a scan") };
    assert_eq!(scan.ranges_m.as_slice(), [1.0, 2.0, f32::INFINITY]);
    assert_eq!(world.now(), Time::from_secs(9.5), "the end is where the last record is");
    assert_eq!(world.next_recorded(), Some(world.now()), "the end is due at once");
    assert!(notices.len() == 1 && notices[0].contains("180 degrees in all is a guess"), "{notices:?}");
    // Odometry comes from both kinds of lines, and its velocity from their differences.
    let (odometry, _) = play(build(&params).as_mut(), &Probe::Wheels);
    assert_eq!(odometry.len(), 20);
    let Data::Odometry(last) = &odometry[19].data else { panic!("odometry") };
    assert_eq!((last.odom_from_base, last.twist), (pose2(9.5, 0.0, 0.0), Twist::new(1.0, 0.0)));
}

#[test]
fn a_channel_says_once_what_was_recorded_since_it_was_asked_last() {
    let file = TempFile::new(&drive_text());
    let mut world = build(&LogParams { file: file.0.clone(), ..LogParams::default() });
    world.advance(Time::from_secs(2.2)).unwrap();
    assert_eq!(recorded(world.as_mut(), &BEAMS).len(), 3);
    assert!(recorded(world.as_mut(), &BEAMS).is_empty());
    assert_eq!(recorded(world.as_mut(), &Probe::Channel { name: "odometry" }).len(), 5);
    assert_eq!(world.advance(Time::from_secs(99.0)), Ok(Advance::Reached(Time::from_secs(99.0))));
    assert_eq!(recorded(world.as_mut(), &Probe::Channel { name: "front_laser" }).len(), 7);
    assert!(matches!(world.advance(Time::from_secs(98.0)), Err(WorldError::Backwards { .. })));
    assert_eq!(world.advance(Time::from_secs(99.0)), Ok(Advance::Ended));
}

#[test]
fn names_are_respected_where_the_pipeline_gives_them_or_the_log_has_two_lasers() {
    let file = TempFile::new(&drive_text());
    let channels = BTreeMap::from([("laser".to_owned(), "front_laser".to_owned())]);
    let mut world = build(&LogParams { file: file.0.clone(), channels, ..LogParams::default() });
    let unsupported =
        |answer: Result<Answer<'_>, WorldError>| matches!(answer, Err(WorldError::Unsupported { .. }));
    assert!(unsupported(world.probe(&BEAMS)));
    assert!(unsupported(world.probe(&Probe::Channel { name: "lasr" })));
    assert!(unsupported(world.probe(&Probe::Contacts)));
    assert!(world.probe(&Probe::Wheels).is_ok(), "no name for the odometer");
    assert_eq!(play(world.as_mut(), &Probe::Channel { name: "laser" }).0.len(), 10);
    let two = TempFile::new(&(drive_text() + &drive_text().replace("FLASER", "RLASER")));
    let both = (0..10).map(|k| {
        let (front, t) = (flaser(0.0, f64::from(k)), f64::from(k) + 0.1);
        front + &flaser(0.0, t).replace("FLASER", "RLASER")
    });
    std::fs::write(&two.0, both.collect::<String>()).unwrap();
    let mut world = build(&LogParams { file: two.0.clone(), ..LogParams::default() });
    assert!(unsupported(world.probe(&BEAMS)), "which of the two?");
    assert_eq!(play(world.as_mut(), &Probe::Channel { name: "rear_laser" }).0.len(), 10);
}

#[test]
fn truth_is_interpolated_over_short_gaps_and_unknown_elsewhere() {
    let log = TempFile::new(&drive_text());
    let truth = TempFile::new("976052858 1 1 0\n976052859 2 1 0\n976052864.00001 7 1 0\n");
    let params = LogParams {
        file: log.0.clone(),
        truth: Some(truth.0.clone()),
        map: Some(log.0.clone()),
        ..LogParams::default()
    };
    let mut world = build(&params);
    assert_eq!(world.start(), Some(pose2(1.0, 1.0, 0.0)), "the first true pose is a second from the start");
    let mut at = |seconds: f64| {
        world.advance(Time::from_secs(seconds)).unwrap();
        world.truth().map(|truth| (flatten(&truth.map_from_base).translation.x, truth.clearance_m))
    };
    assert_eq!(at(0.0), None);
    assert_eq!(at(1.25), Some((1.25, f64::INFINITY)));
    assert_eq!(at(4.0), None, "five seconds between two poses");
    assert_eq!(at(7.0), Some((7.0, f64::INFINITY)), "rounded stamps match");
    assert_eq!(at(7.5), None);
}

#[test]
fn truth_inside_the_log_is_the_pose_beside_the_odometer_s() {
    let between: String = (1..95).map(|k| odom(0.0, 976_052_857.02 + 0.1 * f64::from(k))).collect();
    let mut lines: Vec<String> =
        (drive_text() + &between).lines().map(|line| line.to_owned() + "\n").collect();
    lines.sort_by_key(|line| line.split(' ').rev().nth(2).map(str::to_owned));
    let file = TempFile::new(&lines.concat());
    let truth = Some(PathBuf::from(TRUTH_INSIDE));
    let mut world = build(&LogParams { file: file.0.clone(), truth, ..LogParams::default() });
    assert_eq!(world.start(), Some(pose2(10.0, 7.0, 0.0)));
    for seconds in [0.0, 0.5, 3.75, 9.0] {
        world.advance(Time::from_secs(seconds)).unwrap();
        let truth = world.truth().unwrap();
        assert!((truth.map_from_base.translation.x - 10.0 - seconds).abs() < 1e-6, "{seconds}");
    }
    world.advance(Time::from_secs(9.5)).unwrap();
    assert_eq!(world.truth(), None, "behind the last scan");
}

#[test]
fn the_start_is_what_was_given_else_the_odometer_s_where_no_map_says_otherwise() {
    let file = TempFile::new(&drive_text());
    let bare = LogParams { file: file.0.clone(), ..LogParams::default() };
    assert_eq!(build(&bare).start(), Some(Pose2::identity()));
    let with_map = LogParams { map: Some(file.0.clone()), ..bare.clone() };
    assert_eq!(build(&with_map).start(), None);
    let given = LogParams { start: Some(LogStart { x_m: 1.0, y_m: 2.0, yaw_deg: 90.0 }), ..with_map };
    assert_eq!(build(&given).start(), Some(pose2(1.0, 2.0, std::f64::consts::FRAC_PI_2)));
}

#[test]
fn damage_skips_and_steps_are_told_once_each() {
    let text = drive_text()
        + "FLASER x\nFLASER 3 1\nNEFF 3\n"
        + &odom(9.7, 976_052_866.2)
        + &flaser(9.0, 976_052_866.1);
    let half = flaser(10.0, 976_052_867.0);
    let file = TempFile::new(&(text + &odom(9.9, 976_052_866.8) + &half[..30]));
    let mut world =
        build(&LogParams { file: file.0.clone(), bearing_step_deg: Some(1.0), ..LogParams::default() });
    let (scans, notices) = play(world.as_mut(), &BEAMS);
    assert_eq!(scans.len(), 11);
    let place = file.0.display().to_string();
    assert!(notices.iter().all(|notice| notice.starts_with(&place)), "{notices:?}");
    for (notice, words) in notices.iter().zip([
        "line 27: the file is cut off: FLASER.num_readings is followed by",
        "skipped 1 line with too few fields, first line 22: FLASER.num_readings is followed by 1 words, expected 12",
        "skipped 1 line with no number, first line 21: FLASER.num_readings is `x`, expected a number",
        "skipped messages that are not understood: `NEFF` (1, from line 23)",
        "odometry: stamps step backward 1 times",
    ]) {
        assert!(notice.contains(words), "{words}: {notices:#?}");
    }
    assert_eq!(notices.len(), 5, "{notices:#?}");
}

#[test]
fn a_truth_that_never_fits_is_told() {
    let (log, truth) = (TempFile::new(&drive_text()), TempFile::new("976152858 1 1 0\n976152859 2 1 0\n"));
    let params = LogParams {
        file: log.0.clone(),
        truth: Some(truth.0.clone()),
        bearing_step_deg: Some(1.0),
        ..LogParams::default()
    };
    let (_, notices) = play(build(&params).as_mut(), &BEAMS);
    assert!(notices.len() == 1 && notices[0].contains("no true pose is near any stamp"), "{notices:?}");
    std::fs::write(&truth.0, "1.0 1 1 0\n").unwrap();
    let error = params.build(&BuildContext::bare("world")).err().unwrap();
    assert_eq!(error.path, "truth");
    assert!(
        error.message.contains("the last pose is of 1.000000 s, but the log begins at 976052857.000000 s")
    );
}

#[test]
fn a_channel_of_the_pipeline_that_the_log_lacks_is_told() {
    let file = TempFile::new(&drive_text());
    let channels = BTreeMap::from([("back".to_owned(), "rear_laser".to_owned())]);
    let params =
        LogParams { file: file.0.clone(), channels, bearing_step_deg: Some(1.0), ..LogParams::default() };
    let (_, notices) = play(build(&params).as_mut(), &Probe::Channel { name: "back" });
    assert_eq!(notices.len(), 1, "{notices:?}");
    assert!(notices[0].ends_with("channels.back is rear_laser, which this log does not have"), "{notices:?}");
}

#[test]
fn ranges_are_shared_and_used_again() {
    let file = TempFile::new(&(0..400).map(|k| flaser(0.0, 0.1 * f64::from(k))).collect::<String>());
    let mut world = build(&LogParams { file: file.0.clone(), ..LogParams::default() });
    let mut addresses = std::collections::BTreeSet::new();
    loop {
        let due = world.next_recorded().unwrap();
        if world.advance(due).unwrap() == Advance::Ended {
            break;
        }
        for observation in recorded(world.as_mut(), &BEAMS) {
            let Data::LaserScan(scan) = observation.data else { panic!("a scan") };
            addresses.insert(scan.ranges_m.as_slice().as_ptr() as usize);
        }
    }
    assert!(addresses.len() < 60, "{} buffers for 400 scans", addresses.len());
}

#[test]
fn a_recording_does_not_drive() {
    let file = TempFile::new(&drive_text());
    let mut world = build(&LogParams { file: file.0.clone(), ..LogParams::default() });
    let command = |twist| Command { twist, ..Command::default() };
    assert_eq!(world.drive(&command(Twist::new(0.5, 0.0))), Ok(Drove::NotActuated));
    assert_eq!(world.drive(&command(Twist::new(f64::NAN, 0.0))), Err(WorldError::NotFinite));
}

#[test]
fn bad_parameters_and_files_are_named() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::World, "log").unwrap();
    let text = "file = 'a.clf'\nchannels = { laser = 'front_laser', wheels = 'odometry' }\nstart = { x_m = 1, y_m = 2 }";
    let configured = entry.source.parse(toml::from_str(text).unwrap()).ok().unwrap();
    assert!(configured.check().is_empty());
    let error = configured.build(&BuildContext::bare("world")).err().unwrap();
    assert!(error.path == "file" && error.message.contains("./a.clf: cannot read the log"), "{error}");
    let log = TempFile::new(&drive_text());
    let channels = BTreeMap::from([("laser".to_owned(), "/scan".to_owned())]);
    let topics = LogParams { file: log.0.clone(), channels, ..LogParams::default() };
    let fault = topics.build(&BuildContext::bare("world")).err().unwrap();
    assert!(fault.path == "channels.laser" && fault.message.contains("front_laser"), "{fault:?}");
    let bad = LogParams {
        start: Some(LogStart { x_m: f64::NAN, y_m: 0.0, yaw_deg: 0.0 }),
        max_range_m: Some(0.0),
        first_bearing_deg: Some(f64::INFINITY),
        bearing_step_deg: Some(0.0),
        ..LogParams::default()
    };
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["file", "start.x_m", "max_range_m", "first_bearing_deg", "bearing_step_deg"]);
    let no_time = TempFile::new("PARAM a b\nVERTEX2 0 1 2 3\n");
    let params = LogParams { file: no_time.0.clone(), ..LogParams::default() };
    let error = params.build(&BuildContext::bare("world")).err().unwrap();
    assert!(error.message.contains("no scan and no odometry"), "{error}");
}
