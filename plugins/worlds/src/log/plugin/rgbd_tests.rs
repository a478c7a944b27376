//! A folder of the TUM RGB-D kind played through the traits.

use rumbo_core::frames::{Pose3, flatten};
use rumbo_core::messages::{Data, Imu, Intrinsics, Observation};
use rumbo_kit::depth_file::{DepthEncoding, DepthPicture};
use rumbo_kit::tum_rgbd::{FolderWriter, PlaceInSpace, camera_from_optical};

use super::*;
use crate::log::{RecordedCamera, TRUTH_INSIDE};

/// A folder that is gone with the test.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const START_S: f64 = 1000.0;
const MOUNT: PlaceInSpace =
    PlaceInSpace { x_m: 0.1, y_m: 0.0, z_m: 0.5, roll_deg: 0.0, pitch_deg: 10.0, yaw_deg: 0.0 };

fn seconds(k: u16) -> f64 {
    0.25 * f64::from(k)
}

/// Where the robot of the test drives: along x, turning left.
fn map_from_base(k: u16) -> Pose3 {
    rumbo_core::frames::lift(&pose2(0.1 * f64::from(k), 1.0, 0.2 * f64::from(k)))
}

/// Eight pictures of 4 x 2 pixels with the count 1000 + k, at 4 Hz; accelerations from 0.1 s before the first on.
fn folder(test: &str, encoding: DepthEncoding) -> Folder {
    let path = std::env::temp_dir().join(format!("rumbo-rgbd-world-{}-{test}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    let mut writer = FolderWriter::create(&path, encoding).unwrap();
    for k in 0..8 {
        let stamp = Time::from_secs(START_S + 0.1 + seconds(k));
        let counts = vec![1000 + k, 0, 8191, 1, 2, 3, 4, 5];
        writer.picture(stamp, &DepthPicture { width: 4, height: 2, counts }).unwrap();
        writer.pose(stamp, &(map_from_base(k) * MOUNT.pose() * camera_from_optical())).unwrap();
        writer.acceleration(stamp - rumbo_core::time::Span::from_secs(0.1), [0.5, 9.8, -1.0]).unwrap();
    }
    writer.finish().unwrap();
    Folder(path)
}

fn params(folder: &Folder) -> LogParams {
    let camera = RecordedCamera { mount: MOUNT, ..RecordedCamera::default() };
    LogParams { file: folder.0.clone(), truth: Some(TRUTH_INSIDE.into()), camera, ..LogParams::default() }
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

fn depth(mount: &Pose3) -> Probe<'_> {
    const CAMERA: Intrinsics = Intrinsics { width: 1, height: 1, focal_px: [1.0; 2], center_px: [0.0; 2] };
    Probe::Depth { base_from_sensor: mount, intrinsics: &CAMERA, max_range_m: 5.0 }
}

fn notices(world: &mut dyn World) -> String {
    std::iter::from_fn(|| world.take_notice()).collect::<Vec<_>>().join("\n")
}

#[test]
fn pictures_and_accelerations_come_at_their_stamps_with_the_true_pose() {
    for (encoding, no_reading) in [(DepthEncoding::Gray16, Some(8191)), (DepthEncoding::TwoChannel, None)] {
        let folder = folder(&format!("stamps-{encoding:?}"), encoding);
        let mut params = params(&folder);
        (params.camera.encoding, params.camera.no_reading) = (encoding, no_reading);
        let mut world = build(&params);
        let start = world.start().unwrap();
        assert!((start.translation.y - 1.0).abs() < 1e-5 && start.rotation.angle().abs() < 1e-5);
        let (mut n_pictures, mut n_accelerations) = (0, 0);
        while world.advance(world.next_recorded().unwrap()) != Ok(Advance::Ended) {
            for observation in recorded(world.as_mut(), &depth(&MOUNT.pose())) {
                let Data::DepthImage(image) = observation.data else { panic!("no picture") };
                assert!((observation.stamp.as_secs() - 0.1 - seconds(n_pictures)).abs() < 2e-6);
                assert_eq!(observation.stamp, world.now());
                let bright = if no_reading.is_some() { 0 } else { 8191 };
                assert_eq!(image.depth.as_slice(), [1000 + n_pictures, 0, bright, 1, 2, 3, 4, 5]);
                assert_eq!(image.unit_m, 0.0002);
                let focal_px = 525.0 * 4.0 / 640.0;
                let expected =
                    Intrinsics { width: 4, height: 2, focal_px: [focal_px; 2], center_px: [1.5, 0.5] };
                assert_eq!(image.intrinsics, expected);
                let truth = flatten(&world.truth().unwrap().map_from_base);
                let off = flatten(&map_from_base(n_pictures)).inverse() * truth;
                assert!(off.translation.vector.norm() < 1e-5 && off.rotation.angle().abs() < 1e-5, "{off}");
                n_pictures += 1;
            }
            for observation in recorded(world.as_mut(), &Probe::Attitude) {
                let expected =
                    Imu { attitude_rad: None, rates_rad_s: [0.0; 3], accelerations_m_s2: [-1.0, 0.5, 9.8] };
                assert_eq!(observation.data, Data::Imu(expected));
                n_accelerations += 1;
            }
        }
        assert_eq!((n_pictures, n_accelerations), (8, 8));
        assert_eq!(notices(world.as_mut()), "");
        assert_eq!(world.recording_file(), Some(folder.0.as_path()));
        assert_eq!(world.drive(&Command::default()), Ok(Drove::NotActuated));
    }
}

#[test]
fn channels_have_names_and_one_that_is_named_answers_nobody_else() {
    let folder = folder("names", DepthEncoding::Gray16);
    let mount = MOUNT.pose();
    let channels = BTreeMap::from([("eye".to_owned(), "depth".to_owned())]);
    let mut world = build(&LogParams { channels, ..params(&folder) });
    world.advance(Time::from_secs(0.4)).unwrap();
    assert!(matches!(world.probe(&depth(&mount)), Err(WorldError::Unsupported { .. })), "it has a name");
    assert_eq!(recorded(world.as_mut(), &Probe::Channel { name: "eye" }).len(), 2);
    assert_eq!(recorded(world.as_mut(), &Probe::Channel { name: "depth" }).len(), 0, "taken already");
    assert_eq!(recorded(world.as_mut(), &Probe::Channel { name: "imu" }).len(), 2);
    assert!(matches!(world.probe(&Probe::Channel { name: "rgb" }), Err(WorldError::Unsupported { .. })));
    assert!(matches!(world.probe(&Probe::Wheels), Err(WorldError::Unsupported { .. })));
    assert!(world.advance(Time::ZERO).is_err());
    let elsewhere = Pose3::translation(0.0, 0.0, 0.5);
    let mut world = build(&params(&folder));
    for _ in 0..2 {
        recorded(world.as_mut(), &depth(&elsewhere));
    }
    let told = notices(world.as_mut());
    assert!(told.contains("0.100 m and 10.0 degrees from `camera.mount`"), "{told}");
    assert_eq!(told.lines().count(), 1, "once: {told}");
}

#[test]
fn pictures_that_cannot_be_shown_are_skipped_and_told() {
    let folder = folder("broken", DepthEncoding::Gray16);
    let list = std::fs::read_to_string(folder.0.join("depth.txt")).unwrap();
    let names: Vec<&str> = list.lines().skip(1).map(|line| line.split(' ').nth(1).unwrap()).collect();
    std::fs::write(folder.0.join(names[0]), b"\x89PNG").unwrap();
    let small = DepthPicture { width: 1, height: 1, counts: vec![7] };
    rumbo_kit::depth_file::write_depth(&folder.0.join(names[3]), DepthEncoding::Gray16, &small).unwrap();
    let mut world = build(&params(&folder));
    let mut n_pictures = 0;
    while world.advance(world.next_recorded().unwrap()) != Ok(Advance::Ended) {
        n_pictures += recorded(world.as_mut(), &Probe::Channel { name: "depth" }).len();
    }
    let told = notices(world.as_mut());
    assert!(n_pictures == 6 && told.contains("skipped 2 pictures, the first: "), "{n_pictures}: {told}");
    assert!(told.contains(names[0]) && told.contains("broken picture"), "{told}");
    world.advance(world.now()).unwrap();
    assert_eq!(notices(world.as_mut()), "", "the end is told once");
    for name in &names {
        std::fs::write(folder.0.join(name), b"nothing").unwrap();
    }
    let none = fault(&params(&folder));
    assert!(none.path == "file" && none.help.is_some(), "{none:?}");
    assert!(none.message.contains("none of its pictures can be read; the first: "), "{}", none.message);
}

#[test]
fn pictures_that_nobody_asks_for_are_dropped() {
    let path = std::env::temp_dir().join(format!("rumbo-rgbd-world-{}-late", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    let mut writer = FolderWriter::create(&path, DepthEncoding::Gray16).unwrap();
    for k in 0..50 {
        let picture = DepthPicture { width: 1, height: 1, counts: vec![k] };
        writer.picture(Time::from_secs(f64::from(k)), &picture).unwrap();
    }
    writer.finish().unwrap();
    let folder = Folder(path);
    let mut world = build(&LogParams { file: folder.0.clone(), ..LogParams::default() });
    assert_eq!((world.start(), world.truth().is_some()), (None, false), "nobody said where the robot is");
    world.advance(Time::from_secs(60.0)).unwrap();
    let seen = recorded(world.as_mut(), &Probe::Channel { name: "depth" });
    assert_eq!((seen.len(), seen[0].stamp), (32, Time::from_secs(18.0)), "the newest stay");
    assert_eq!(world.advance(Time::from_secs(60.0)), Ok(Advance::Ended));
    let told = notices(world.as_mut());
    assert!(told.contains("18 pictures were dropped because no sensor asked for them"), "{told}");
}

#[test]
fn faults_are_told_with_their_key() {
    let folder = folder("faults", DepthEncoding::Gray16);
    let channels = BTreeMap::from([("laser".to_owned(), "front_laser".to_owned())]);
    let channel = fault(&LogParams { channels, ..params(&folder) });
    assert_eq!(channel.path, "channels.laser");
    assert!(channel.message.contains("expected depth or imu: this is a TUM RGB-D folder"));
    let mut bad = params(&folder);
    bad.camera.encoding = DepthEncoding::TwoChannel;
    assert!(fault(&bad).message.contains("one channel of 16 bits, expected red and green"));
    bad.camera.unit_m = 0.0;
    bad.camera.focal_px = Some([0.0, 500.0]);
    bad.camera.center_px = Some([1.0, f64::NAN]);
    bad.camera.mount.pitch_deg = f64::INFINITY;
    bad.camera.map_from_world.z_m = f64::NAN;
    let keys: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(
        keys,
        ["unit_m", "focal_px[0]", "center_px[1]", "mount.pitch_deg", "map_from_world.z_m"]
            .map(|key| format!("camera.{key}"))
    );
    std::fs::remove_file(folder.0.join("groundtruth.txt")).unwrap();
    let poses = fault(&params(&folder));
    assert!(poses.path == "truth" && poses.message.contains("groundtruth.txt"), "{}", poses.message);
    std::fs::write(folder.0.join("depth.txt"), "1.0 depth/none.png\n").unwrap();
    let pictures = fault(&params(&folder));
    assert!(pictures.path == "file" && pictures.message.contains("none of the 1 pictures"), "{pictures}");
}
