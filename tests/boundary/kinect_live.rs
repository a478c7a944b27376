//! `examples/kinect_live` with a libfreenect_sync that serves recorded pictures, loses its device, and hangs.

use crate::compiler::{self, Language};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Command as DriveCommand, Data, DepthImage, Observation, Observations};
use rumbo_core::registry::{Built, Registry, Stage};
use rumbo_core::stages::{
    Advance, Answer, BuildContext, Cx, Drove, Probe, Sensor, SensorError, World, WorldError,
};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::depth_file::{DepthEncoding, read_depth};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Duration;

const COLUMNS: usize = 640;
const ROWS: usize = 480;
/// Pictures of the shipped recording that the device serves.
const N_FRAMES: usize = 12;
/// Nobody waits longer than this for a device that shall answer, in polls of 2 ms.
const MOST_POLLS: usize = 30_000;

fn library() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let out = compiler::folder("kinect_live");
        let script = compiler::root().join("examples/kinect_live/build.sh");
        let built = Command::new("sh").arg(script).arg(&out).arg("-Werror").output().unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        out.join("libkinect_live.so")
    })
}

/// The recorded pictures as they are.
fn recorded() -> Vec<Vec<u16>> {
    let folder = compiler::root().join("pipelines/logs/laboratory_frames");
    let frames = rumbo_kit::tum_rgbd::read_folder(&folder).unwrap().frames;
    let counts = frames.iter().take(N_FRAMES).map(|frame| read_depth(&frame.path, DepthEncoding::Gray16));
    counts.map(|picture| picture.unwrap().counts).collect()
}

/// The recorded pictures, each pixel repeated until the picture has the size of the device's.
fn frames() -> &'static [Vec<u16>] {
    static FRAMES: OnceLock<Vec<Vec<u16>>> = OnceLock::new();
    FRAMES.get_or_init(|| {
        const N: usize = 4;
        let enlarged = |counts: &Vec<u16>| {
            let pixel = |idx: usize| counts[idx / COLUMNS / N * (COLUMNS / N) + idx % COLUMNS / N];
            (0..COLUMNS * ROWS).map(pixel).collect()
        };
        let frames: Vec<Vec<u16>> = recorded().iter().map(enlarged).collect();
        assert!(
            frames.windows(2).all(|pair| pair[0] != pair[1]),
            "pictures are told apart by what they show"
        );
        frames
    })
}

/// A libfreenect_sync of its own for each test: a library keeps what it served.
fn fake(test: &str, flags: &[&str]) -> PathBuf {
    static FILE: OnceLock<PathBuf> = OnceLock::new();
    let file = FILE.get_or_init(|| {
        let file = compiler::folder("kinect_frames").join("frames");
        let bytes: Vec<u8> = frames().iter().flatten().flat_map(|count| count.to_ne_bytes()).collect();
        std::fs::write(&file, bytes).unwrap();
        file
    });
    let frames = format!("-DFRAMES=\"{}\"", file.display());
    let flags = [&[frames.as_str()][..], flags].concat();
    let source = compiler::root().join("tests/boundary/fixtures/fake_freenect_sync.c");
    compiler::library(&source, Language::C, &flags, &format!("freenect_{test}"))
}

/// A world that is real.
struct Live;

impl World for Live {
    fn now(&self) -> Time {
        Time::ZERO
    }
    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        Ok(Advance::Reached(to))
    }
    fn drive(&mut self, _: &DriveCommand) -> Result<Drove, WorldError> {
        Ok(Drove::NotActuated)
    }
    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        assert!(matches!(probe, Probe::Depth { .. }), "{probe:?}");
        Ok(Answer::Live)
    }
}

fn sensor(keys: &str, dry_run: bool) -> Box<dyn Sensor> {
    let mut registry = Registry::default();
    registry.load(library(), None).unwrap();
    let configured =
        registry.get(Stage::Sensor, "kinect_live").unwrap().source.parse(toml::from_str(keys).unwrap());
    let base_from_sensor = Pose3::translation(0.1, 0.0, 0.4);
    let context = BuildContext { base_from_sensor, dry_run, ..BuildContext::bare("camera") };
    match configured.unwrap().build(&context).unwrap() {
        Built::Sensor(sensor) => sensor,
        _ => panic!("no sensor"),
    }
}

fn with(library: &Path, keys: &str) -> Box<dyn Sensor> {
    sensor(&format!("library = '{}'\n{keys}", library.display()), false)
}

const NOW_S: f64 = 1000.0;

/// What one poll gave, and the counter of dropped pictures.
fn poll(sensor: &mut dyn Sensor) -> Result<(Vec<Observation>, f64), SensorError> {
    let (trace, mut out) = (Trace::watched(), Observations::default());
    let mut cx = Cx { now: Time::from_secs(NOW_S), trace: &trace };
    sensor.poll(&mut cx, &mut Live, &mut out)?;
    let dropped =
        trace.take().1.iter().find(|(name, _)| *name == "dropped_pictures").map_or(0.0, |(_, n)| *n);
    Ok((std::iter::from_fn(|| out.pop_front()).collect(), dropped))
}

fn image(observation: &Observation) -> &DepthImage {
    match &observation.data {
        Data::DepthImage(image) => image,
        other => panic!("{other:?}"),
    }
}

/// Which of the recorded pictures this is, to the count.
fn number(observation: &Observation) -> usize {
    let seen = image(observation).depth.as_slice();
    frames().iter().position(|frame| frame.as_slice() == seen).expect("a picture that was never recorded")
}

/// Polls until `done`, or for so long that a device that works would have answered.
fn poll_until(
    sensor: &mut dyn Sensor,
    mut done: impl FnMut(Result<(Vec<Observation>, f64), SensorError>) -> bool,
) {
    for _ in 0..MOST_POLLS {
        if done(poll(sensor)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("nothing came of {MOST_POLLS} polls");
}

#[test]
fn recorded_pictures_come_through_to_the_count_and_in_their_order() {
    let mut sensor = with(&fake("pictures", &["-DPACE_MS=15"]), "every = 1\nfocal_x_px = 600.0");
    let (mut seen, mut stamps): (Vec<usize>, Vec<Time>) = (Vec::new(), Vec::new());
    poll_until(sensor.as_mut(), |polled| {
        for observation in polled.unwrap().0 {
            let image = image(&observation);
            let camera = &image.intrinsics;
            assert_eq!((camera.width, camera.height, image.unit_m), (640, 480, 0.001));
            assert_eq!((camera.focal_px, camera.center_px), ([600.0, 589.4], [319.5, 239.5]));
            assert!(observation.valid && observation.stamp <= Time::from_secs(NOW_S));
            assert_eq!(observation.base_from_sensor, Pose3::translation(0.1, 0.0, 0.4));
            seen.push(number(&observation));
            stamps.push(observation.stamp);
        }
        seen.len() >= 2 * N_FRAMES
    });
    // Pictures may be dropped where this test was held up, but none comes twice or before its time.
    let steps: Vec<usize> = seen.windows(2).map(|pair| (pair[1] + N_FRAMES - pair[0]) % N_FRAMES).collect();
    assert!(steps.iter().all(|step| *step > 0), "{seen:?}");
}

#[test]
fn a_picture_of_every_fourth_column_and_row_looks_the_same_way() {
    let (mut sensor, recorded) = (with(&fake("every", &["-DPACE_MS=5"]), ""), recorded());
    poll_until(sensor.as_mut(), |polled| {
        let (seen, _) = polled.unwrap();
        for observation in &seen {
            let image = image(observation);
            let camera = &image.intrinsics;
            assert_eq!((camera.width, camera.height), (160, 120));
            // Column 1 of the device is the first one that is shown, and the middle one stays where it looks.
            assert_eq!((camera.focal_px, camera.center_px), ([589.4 / 4.0; 2], [318.5 / 4.0, 238.5 / 4.0]));
            assert!(recorded.iter().any(|counts| counts.as_slice() == image.depth.as_slice()));
        }
        !seen.is_empty()
    });
}

#[test]
fn without_a_device_or_its_library_the_error_says_what_to_do() {
    let said = |mut sensor: Box<dyn Sensor>| {
        let mut told = String::new();
        poll_until(sensor.as_mut(), |polled| match polled {
            Ok((seen, _)) => {
                assert!(seen.is_empty());
                false
            }
            Err(SensorError::Device { device, reason }) => {
                assert_eq!(device, "camera");
                told = reason;
                true
            }
            Err(other) => panic!("{other:?}"),
        });
        told
    };
    let absent = said(with(&fake("absent", &["-DPACE_MS=1", "-DABSENT"]), ""));
    let expected = "no Kinect answers as number 0 (libfreenect_sync says -1); is it plugged in and powered";
    assert!(absent.contains(expected), "{absent}");
    let second = said(with(&fake("second", &["-DPACE_MS=1"]), "index = 1"));
    assert!(second.contains("as number 1 (libfreenect_sync says -2)"), "{second}");
    let missing = said(sensor("library = 'no_such_library.so'", false));
    assert!(missing.contains("cannot be loaded (no_such_library.so"), "{missing}");
    assert!(missing.contains("install libfreenect, or set `library`"), "{missing}");
    // The plugin itself is a library, and not the one that is wanted.
    let wrong = said(with(library(), ""));
    assert!(wrong.contains("it is not libfreenect_sync"), "{wrong}");
}

#[test]
fn a_device_that_was_unplugged_is_told_and_comes_back() {
    let library = fake("unplugged", &["-DPACE_MS=5", "-DUNPLUG_AT=6", "-DN_UNPLUGGED=2"]);
    let mut sensor = with(&library, "every = 1");
    let (mut n_before, mut n_failures, mut n_after) = (0, 0, 0);
    poll_until(sensor.as_mut(), |polled| {
        match polled {
            Ok((seen, _)) if n_failures == 0 => n_before += seen.len(),
            Ok((seen, _)) => n_after += seen.len(),
            Err(SensorError::Device { reason, .. }) => {
                assert!(reason.contains("libfreenect_sync says -3"), "{reason}");
                n_failures += 1;
            }
            Err(other) => panic!("{other:?}"),
        }
        n_after >= 4
    });
    assert!(n_before <= 6 && n_failures > 0, "{n_before} pictures, {n_failures} failures");
}

#[test]
fn a_host_that_comes_late_gets_the_newest_pictures_and_knows_how_many_it_missed() {
    let mark = compiler::folder("kinect_late").join("hangs");
    let hangs = format!("-DHANGS=\"{}\"", mark.display());
    let library = fake("late", &["-DPACE_MS=0", "-DHANG_AT=11", hangs.as_str()]);
    let mut sensor = with(&library, "every = 1\nsilence_s = 60.0");
    let (mut seen, _) = poll(sensor.as_mut()).unwrap();
    poll_until(sensor.as_mut(), |polled| {
        seen.extend(polled.unwrap().0);
        mark.is_file()
    });
    let (last, n_dropped) = poll(sensor.as_mut()).unwrap();
    seen.extend(last);
    assert_eq!(seen.len() + n_dropped as usize, 11, "each picture was shown or counted");
    assert_eq!(seen.last().map(number), Some(10), "the newest one was kept");
    let numbers: Vec<usize> = seen.iter().map(number).collect();
    assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
}

#[test]
fn a_device_that_hangs_counts_as_lost_and_keeps_nobody_from_ending() {
    let mark = compiler::folder("kinect_hang").join("hangs");
    let hangs = format!("-DHANGS=\"{}\"", mark.display());
    let library = fake("hang", &["-DPACE_MS=1", "-DHANG_AT=3", hangs.as_str()]);
    let mut sensor = with(&library, "silence_s = 0.2");
    let mut n_seen = 0;
    poll_until(sensor.as_mut(), |polled| match polled {
        Ok((seen, _)) => {
            n_seen += seen.len();
            false
        }
        Err(SensorError::Device { reason, .. }) => {
            assert!(reason.contains("no picture for") && reason.contains("`silence_s` is 0.2"), "{reason}");
            // A machine that is held up for 0.2 s may be told before the last picture.
            mark.is_file()
        }
        Err(other) => panic!("{other:?}"),
    });
    assert!(n_seen <= 3);
    drop(sensor);
}

#[test]
fn a_check_touches_no_device() {
    let mut sensor = sensor("library = 'no_such_library.so'", true);
    assert_eq!(poll(sensor.as_mut()).map(|(seen, _)| seen.len()), Ok(0));
}

/// Runs the built command where the library is found.
fn rumbo(arguments: &[&str]) -> String {
    let out = Command::new(env!("CARGO_BIN_EXE_rumbo"))
        .current_dir(compiler::root())
        .args(arguments)
        .output()
        .unwrap();
    assert!(out.status.success(), "{arguments:?}\n{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).unwrap()
}

#[test]
fn a_robot_drives_by_what_it_sees_in_the_simulator() {
    let pipeline = "examples/kinect_live/office_kinect.toml";
    let folder = library().parent().unwrap().to_str().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rumbo"));
        command.current_dir(compiler::root()).env("RUMBO_PLUGIN_PATH", folder).args(arguments);
        let out = command.output().unwrap();
        assert!(out.status.success(), "{arguments:?}\n{}", String::from_utf8_lossy(&out.stderr));
    };
    run(&["check", pipeline]);
    run(&["test", pipeline]);
}

#[test]
fn it_keeps_the_laws_of_sensors_and_describes_itself() {
    let library = library().to_str().unwrap();
    rumbo(&["plugins", "verify", library, "--set", "every=16"]);
    let described = rumbo(&["plugins", "describe", "kinect_live", "--plugin", library]);
    for expected in ["silence_s (number, s) = 2.0", "depth_image", "every (whole number) = 4"] {
        assert!(described.contains(expected), "{expected}:\n{described}");
    }
}
