//! A recording that the simulator wrote is played back: the pictures, the poses and the accelerations are those of the
//! simulator, and the recording that is shipped is what the program writes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::{Path, PathBuf};

use rumbo_core::frames::{Point3, Pose3, Twist, flatten};
use rumbo_core::messages::{Data, DepthImage, Intrinsics};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::{Advance, Answer, BuildContext, Probe, World};
use rumbo_kit::depth::Rays;
use rumbo_kit::depth_file::DepthEncoding;
use rumbo_kit::tum_rgbd::PlaceInSpace;
use rumbo_worlds::log::{LogParams, RecordedCamera};
use rumbo_worlds::sim::Start;

#[path = "../examples/record_frames/recorder.rs"]
mod recorder;
#[path = "../examples/record_frames/shipped.rs"]
mod shipped;

/// A folder that is gone with the test.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn scratch(test: &str) -> Folder {
    let folder = std::env::temp_dir().join(format!("rumbo-recorded-frames-{}-{test}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    Folder(folder)
}

fn pipelines() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines")
}

fn play(folder: &Path, camera: RecordedCamera) -> Box<dyn World> {
    let truth = Some("log".into());
    let params = LogParams { file: folder.to_owned(), truth, camera, ..LogParams::default() };
    params.build(&BuildContext::bare("world")).unwrap()
}

/// Everything in the room that a recorded picture shows, in the map.
fn points_m(image: &DepthImage, map_from_camera: &Pose3) -> Vec<Point3> {
    let rays = Rays::pinhole(&image.intrinsics).unwrap();
    let columns = image.intrinsics.width as usize;
    let seen = image.depth.iter().enumerate().filter(|(_, count)| **count > 0);
    seen.map(|(idx, count)| {
        let depth_m = f64::from(*count) * f64::from(image.unit_m);
        let point_m = rays.point(idx % columns, idx / columns, depth_m).unwrap();
        map_from_camera * Point3::from(point_m)
    })
    .collect()
}

/// A room of 6 m by 4 m, 2.5 m high.
const ROOM: &str = "name = \"room\"\nbounds = [-1.0, -1.0, 7.0, 5.0]\n\
    [[wall]]\nfrom = [0.0, 0.0]\nto = [6.0, 0.0]\nheight_m = 2.5\n\
    [[wall]]\nfrom = [6.0, 0.0]\nto = [6.0, 4.0]\nheight_m = 2.5\n\
    [[wall]]\nfrom = [6.0, 4.0]\nto = [0.0, 4.0]\nheight_m = 2.5\n\
    [[wall]]\nfrom = [0.0, 4.0]\nto = [0.0, 0.0]\nheight_m = 2.5\n";

#[test]
fn recorded_points_lie_on_the_walls_and_the_floor_of_the_room() {
    let folder = scratch("room");
    std::fs::create_dir_all(&folder.0).unwrap();
    let world = folder.0.join("room.toml");
    std::fs::write(&world, ROOM).unwrap();
    let mount = PlaceInSpace { x_m: 0.2, y_m: -0.1, z_m: 0.6, roll_deg: 3.0, pitch_deg: 15.0, yaw_deg: 20.0 };
    let intrinsics = Intrinsics { width: 40, height: 30, focal_px: [36.0, 37.0], center_px: [19.0, 15.5] };
    for encoding in [DepthEncoding::Gray16, DepthEncoding::TwoChannel] {
        let recorder = recorder::Recorder {
            world: world.clone(),
            start: Start { x_m: 2.0, y_m: 1.5, yaw_deg: 30.0 },
            way: vec![(Twist::new(0.3, 0.4), 2.0), (Twist::new(0.2, -0.3), 1.0)],
            mount,
            intrinsics,
            encoding,
            unit_m: 0.001,
            max_range_m: 8.0,
            interval_s: 0.25,
            begins_s: 1000.0,
        };
        let frames = folder.0.join(format!("{encoding:?}"));
        assert_eq!(recorder.record(&frames).unwrap(), 12);
        let camera = RecordedCamera {
            encoding,
            unit_m: 0.001,
            focal_px: Some(intrinsics.focal_px),
            center_px: Some(intrinsics.center_px),
            mount,
            ..RecordedCamera::default()
        };
        let mut log = play(&frames, camera);
        let (mut n_points, mut n_pictures) = (0, 0);
        while log.advance(log.next_recorded().unwrap()) != Ok(Advance::Ended) {
            let map_from_base = log.truth().unwrap().map_from_base;
            let seen = match log.probe(&Probe::Channel { name: "depth" }) {
                Ok(Answer::Recorded(seen)) => seen.to_vec(),
                other => panic!("{other:?}"),
            };
            for observation in seen {
                let Data::DepthImage(image) = &observation.data else { panic!("{observation:?}") };
                n_pictures += 1;
                for point in points_m(image, &(map_from_base * mount.pose())) {
                    let walls = [point.x, 6.0 - point.x, point.y, 4.0 - point.y, point.z];
                    let off_m =
                        walls.into_iter().fold(f64::INFINITY, |least, wall_m| least.min(wall_m.abs()));
                    assert!(off_m < 0.003, "{point} is {off_m} m from walls and floor");
                    n_points += 1;
                }
            }
        }
        assert!(n_pictures == 12 && n_points > 12 * 1000, "{n_pictures} pictures, {n_points} points");
    }
}

#[test]
fn a_camera_at_rest_feels_gravity_along_its_own_axes() {
    let folder = scratch("gravity");
    let mut recorder = shipped::recorder(&pipelines());
    recorder.mount.pitch_deg = 30.0;
    recorder.way = vec![(Twist::ZERO, 0.5)];
    assert_eq!(recorder.record(&folder.0).unwrap(), 1);
    let mut log = play(&folder.0, RecordedCamera { unit_m: 0.001, ..RecordedCamera::default() });
    log.advance(log.now()).unwrap();
    let Ok(Answer::Recorded([observation])) = log.probe(&Probe::Attitude) else { panic!("no reading") };
    let Data::Imu(imu) = &observation.data else { panic!("{observation:?}") };
    // Looking down by 30 degrees, what holds the camera up pushes half of its weight backward.
    let expected = [-9.81 * 0.5, 0.0, 9.81 * 0.75_f64.sqrt()];
    for (found, expected) in imu.accelerations_m_s2.iter().zip(expected) {
        assert!((found - expected).abs() < 0.01, "{:?}", imu.accelerations_m_s2);
    }
}

/// `cargo run -p rumbo-worlds --example record_frames` writes them anew.
#[test]
fn the_shipped_frames_are_what_the_program_writes() {
    let folder = scratch("shipped");
    let n = shipped::recorder(&pipelines()).record(&folder.0).unwrap();
    let shipped = pipelines().join("logs/laboratory_frames");
    for name in ["depth.txt", "groundtruth.txt", "accelerometer.txt"] {
        let [ours, committed] = [&folder.0, &shipped].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(ours == committed, "{name} differs from what the program writes");
    }
    let read = |folder: &Path| {
        let frames = rumbo_kit::tum_rgbd::read_folder(folder).unwrap().frames;
        let pictures = frames
            .iter()
            .map(|frame| rumbo_kit::depth_file::read_depth(&frame.path, DepthEncoding::Gray16).unwrap());
        pictures.collect::<Vec<_>>()
    };
    let (ours, committed) = (read(&folder.0), read(&shipped));
    assert!(ours.len() == n && ours == committed, "the pictures differ from what the program writes");
    let n_bytes: u64 = std::fs::read_dir(shipped.join("depth"))
        .unwrap()
        .map(|entry| entry.unwrap().metadata().unwrap().len())
        .sum();
    assert!(n_bytes < 300_000, "{n_bytes} bytes are too many to ship");
    let mount = shipped::recorder(&pipelines()).mount;
    let log = play(&shipped, RecordedCamera { unit_m: 0.001, mount, ..RecordedCamera::default() });
    let start = flatten(&log.truth().unwrap().map_from_base);
    assert!((start.translation.x - 6.6).abs() < 1e-5 && (start.translation.y - 3.4).abs() < 1e-5);
    // The camera sits 0.1 m before the axle, so that it moves while the robot turns.
    let (track, _) = rumbo_kit::tum_rgbd::read_camera_track(&shipped).unwrap();
    let way_m = track.length_m();
    assert!((3.4..4.2).contains(&way_m), "{way_m} m");
    assert!(committed.iter().zip(committed.iter().skip(1)).all(|(a, b)| a != b));
}
