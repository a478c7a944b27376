//! Poses from files, at scans and between them.

use super::follower::Follower;
use super::*;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, flatten, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status};
use rumbo_core::registry::{Built, Params, Registry, Stage};
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Trace;
use rumbo_kit::log_file::PoseTrack;
use std::path::PathBuf;

fn observation(sensor: u16, seconds: f64, data: Data) -> Observation {
    let stamp = Time::from_secs(seconds);
    Observation { sensor: SensorId(sensor), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

fn scan(seconds: f64) -> Observation {
    observation(0, seconds, Data::LaserScan(LaserScan::default()))
}

fn odometry(seconds: f64, odom_from_base: Pose2) -> Observation {
    observation(1, seconds, Data::Odometry(Odometry { odom_from_base, ..Odometry::default() }))
}

/// Poses at 1, 2, 3 and 9 s of a run that begins at 100 s.
fn follower(only_exact: bool) -> RecordedPose {
    let mut track = PoseTrack::default();
    for (seconds, x) in [(101.0, 1.0), (102.0, 2.0), (103.0, 3.0), (109.0, 9.0)] {
        track.push(Time::from_secs(seconds), pose2(x, 0.5, 0.0));
    }
    let follower = Follower::new(&track, Time::from_secs(100.0), only_exact, Span::from_secs(2.0));
    let mut localizer = RecordedPose::new(follower, 0.02, 0.01);
    localizer.start(&Prior::Unknown, &Map::default()).unwrap();
    localizer
}

fn update(localizer: &mut dyn Localizer, now: f64, seen: &[Observation]) -> Estimate {
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time::from_secs(now), trace: &trace };
    localizer.update(&mut cx, Seen::sorted(seen), &Map::default()).unwrap()
}

fn x_at(localizer: &mut dyn Localizer, seconds: f64) -> (Status, f64, f64) {
    let estimate = update(localizer, seconds, &[scan(seconds)]);
    (estimate.status, estimate.stamp.as_secs(), estimate.pose2().translation.x)
}

#[test]
fn an_estimate_has_the_stamp_and_the_pose_of_its_scan() {
    let mut localizer = follower(false);
    let odom = pose2(-4.0, 1.0, 0.3);
    let seen = [
        odometry(0.9, pose2(7.0, 7.0, 0.0)),
        scan(1.0),
        odometry(1.0, odom),
        odometry(1.05, pose2(9.0, 9.0, 0.0)),
    ];
    let estimate = update(&mut localizer, 1.05, &seen);
    assert_eq!((estimate.stamp, estimate.status), (Time::from_secs(1.0), Status::Tracking));
    assert_eq!(estimate.pose2(), pose2(1.0, 0.5, 0.0));
    let composed = flatten(&estimate.map_from_odom) * odom;
    assert!((composed.to_homogeneous() - estimate.pose2().to_homogeneous()).norm() < 1e-12);
    let covariance = Matrix3::from_diagonal(&[4e-4, 4e-4, 1e-4].into());
    assert!((estimate.covariance2() - covariance).norm() < 1e-12);
    assert_eq!(update(&mut localizer, 1.2, &[]), estimate, "nothing new");
    assert_eq!(x_at(&mut localizer, 1.25), (Status::Tracking, 1.25, 1.25));
    assert_eq!(x_at(&mut localizer, 2.000_09), (Status::Tracking, 2.000_09, 2.0));
}

#[test]
fn only_scans_at_poses_count_where_nothing_else_is_wanted() {
    let mut localizer = follower(true);
    assert_eq!(x_at(&mut localizer, 1.0), (Status::Tracking, 1.0, 1.0));
    assert_eq!(x_at(&mut localizer, 1.25), (Status::Tracking, 1.0, 1.0), "the estimate is of no new scan");
    let estimate = update(&mut localizer, 2.4, &[scan(1.9), scan(2.000_01), scan(2.3)]);
    assert_eq!((estimate.stamp, estimate.pose2().translation.x), (Time::from_secs(2.000_01), 2.0));
}

#[test]
fn before_the_first_pose_and_in_gaps_it_waits_and_after_the_last_it_is_lost() {
    for only_exact in [false, true] {
        let mut localizer = follower(only_exact);
        let before = update(&mut localizer, 0.5, &[scan(0.5)]);
        assert_eq!(before.status, Status::Converging);
        assert_ne!(before.stamp, Time::from_secs(0.5), "or a map builder would take it for the scan's pose");
        assert_eq!(x_at(&mut localizer, 3.0), (Status::Tracking, 3.0, 3.0));
        assert_eq!(x_at(&mut localizer, 5.0), (Status::Converging, 3.0, 3.0));
        assert_eq!(update(&mut localizer, 5.1, &[]).status, Status::Converging);
        assert_eq!(x_at(&mut localizer, 9.0), (Status::Tracking, 9.0, 9.0));
        assert_eq!(x_at(&mut localizer, 9.2), (Status::Lost, 9.0, 9.0));
    }
}

#[test]
fn readings_that_are_invalid_or_no_numbers_change_nothing() {
    let mut localizer = follower(false);
    let invalid = Observation { valid: false, ..scan(1.0) };
    assert_eq!(update(&mut localizer, 1.0, &[invalid]).status, Status::Converging);
    let bad = [scan(1.0), odometry(1.0, pose2(f64::NAN, 0.0, 0.0))];
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time::from_secs(1.0), trace: &trace };
    let failed = localizer.update(&mut cx, Seen::sorted(&bad), &Map::default());
    assert!(matches!(failed, Err(LocalizeError::Message(_))));
    assert!(localizer.start(&Prior::Saved(Vec::new().into()), &Map::default()).is_err());
}

struct TempFile(PathBuf);

impl TempFile {
    fn new(name: &str, text: &str) -> TempFile {
        let path = std::env::temp_dir().join(format!("rumbo-recorded-pose-{}-{name}", std::process::id()));
        std::fs::write(&path, text).unwrap();
        TempFile(path)
    }
}

impl Drop for TempFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn built(keys: &str, context: &BuildContext) -> Result<Box<dyn Localizer>, rumbo_core::stages::BuildError> {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Localizer, "recorded_pose").unwrap();
    match entry.source.parse(keys.parse().unwrap()).ok().unwrap().build(context)? {
        Built::Localizer(localizer) => Ok(localizer),
        _ => panic!("not a localizer"),
    }
}

#[test]
fn absolute_stamps_of_poses_meet_the_recording_that_the_world_plays() {
    let laser = |t: f64| format!("FLASER 1 5 {t} 0 0 0 0 0 {t:.6} h 0\n");
    let log = TempFile::new("log", &(format!("ODOM 0 0 0 0 0 0 50.5 h 0\n{}{}", laser(51.0), laser(52.0))));
    let poses = TempFile::new("poses", "# t x y theta\n51.0 7 0 0\n52.0 8 0 0\n");
    let context = BuildContext { world_recording: Some(log.0.clone()), ..BuildContext::bare("localizer") };
    let mut inside = built("", &context).unwrap();
    assert_eq!(x_at(inside.as_mut(), 0.5), (Status::Tracking, 0.5, 51.0));
    let keys = format!("file = '{}'", poses.0.display());
    let mut outside = built(&keys, &context).unwrap();
    assert_eq!(x_at(outside.as_mut(), 1.5), (Status::Tracking, 1.5, 8.0));
    // Without a recording, stamps count from the start of the run.
    let mut alone = built(&keys, &BuildContext::bare("localizer")).unwrap();
    assert_eq!(x_at(alone.as_mut(), 51.0), (Status::Tracking, 51.0, 7.0));
}

/// A folder of depth pictures, gone with the test: its camera looks along the map's y axis and moves along it.
struct TempFolder(PathBuf);

impl Drop for TempFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn poses_of_a_recorded_camera_become_poses_of_its_robot() {
    let path = std::env::temp_dir().join(format!("rumbo-recorded-camera-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(path.join("depth")).unwrap();
    let folder = TempFolder(path);
    std::fs::write(folder.0.join("depth/a"), "").unwrap();
    std::fs::write(folder.0.join("depth.txt"), "51.0 depth/a\n").unwrap();
    // Optical axes: z ahead along y, x to the right along x, y down along -z.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let poses = format!("51.0 1 2 0.7 {0} 0 0 {half}\n52.0 1 3 0.7 {0} 0 0 {half}\n", -half);
    std::fs::write(folder.0.join("groundtruth.txt"), poses).unwrap();
    let context = BuildContext { world_recording: Some(folder.0.clone()), ..BuildContext::bare("localizer") };
    let pose_at = |keys: &str, seconds: f64| {
        let mut localizer = built(keys, &context).unwrap();
        localizer.start(&Prior::Unknown, &Map::default()).unwrap();
        let estimate = update(localizer.as_mut(), seconds, &[scan(seconds)]);
        let pose = estimate.pose2();
        (estimate.status, [pose.translation.x, pose.translation.y, pose.rotation.angle().to_degrees()])
    };
    let near = |found: [f64; 3], expected: [f64; 3]| {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-6)
    };
    let (status, pose) = pose_at("", 0.0);
    assert!(status == Status::Tracking && near(pose, [1.0, 2.0, 90.0]), "{pose:?}");
    // Halfway between two poses, with the camera 0.2 m before and 0.1 m left of the robot's middle.
    let (_, pose) = pose_at("camera = { mount = { x_m = 0.2, y_m = 0.1, z_m = 0.7 } }", 0.5);
    assert!(near(pose, [1.1, 2.3, 90.0]), "{pose:?}");
    let (_, pose) = pose_at("camera = { map_from_world = { x_m = 10.0, yaw_deg = 90.0 } }", 0.0);
    assert!(near(pose, [8.0, 1.0, -180.0]) || near(pose, [8.0, 1.0, 180.0]), "{pose:?}");
    std::fs::write(folder.0.join("groundtruth.txt"), "1.0 0 0 0 0 0 0 1\n").unwrap();
    let fault = built("", &context).err().unwrap();
    assert!(fault.message.contains("the log begins at 51.000000 s"), "{fault}");
    std::fs::remove_file(folder.0.join("groundtruth.txt")).unwrap();
    let fault = built("", &context).err().unwrap();
    assert!(fault.path == "file" && fault.message.contains("neither groundtruth.txt"), "{fault}");
}

#[test]
fn files_that_cannot_serve_are_named() {
    let error = |keys: &str, context: &BuildContext| built(keys, context).err().unwrap();
    let bare = BuildContext::bare("localizer");
    assert!(error("", &bare).message.contains("the world plays no recording"));
    assert!(error("file = 'no/such.txt'", &bare).message.contains("no/such.txt: cannot read"));
    let cut = TempFile::new("cut", "51.0 7 0 0\n52.0 8 0");
    let message = error(&format!("file = '{}'", cut.0.display()), &bare).message;
    assert!(message.contains("line 2: the file is cut off"), "{message}");
    let log = TempFile::new("late", "ODOM 0 0 0 0 0 0 9050.5 h 0\n");
    let relative = TempFile::new("relative", "1.0 7 0 0\n2.0 8 0 0\n");
    let context = BuildContext { world_recording: Some(log.0.clone()), ..bare };
    let fault = error(&format!("file = '{}'", relative.0.display()), &context);
    assert!(fault.path == "file" && fault.message.contains("the log begins at 9050.500000 s"), "{fault}");
}

#[test]
fn every_bad_value_is_named() {
    let mut camera = rumbo_kit::tum_rgbd::CameraMounting::default();
    camera.mount.z_m = f64::NAN;
    let bad = RecordedPoseParams {
        camera,
        max_gap_s: 0.0,
        deviation_m: f64::NAN,
        deviation_deg: f64::INFINITY,
        ..RecordedPoseParams::default()
    };
    let keys: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["max_gap_s", "deviation_m", "deviation_deg", "camera.mount.z_m"]);
}
