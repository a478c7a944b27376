//! Folders that come back, folders with faults, and poses worked out by hand.

use std::fs::write;
use std::path::PathBuf;

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rumbo_core::frames::{Point3, Pose3, flatten, lift, pose2};
use rumbo_core::time::Time;

use super::*;
use crate::depth_file::{DepthEncoding, DepthPicture, read_depth};

fn scratch(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-tum-rgbd-{}-{test}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("depth")).unwrap();
    folder
}

fn picture(count: u16) -> DepthPicture {
    DepthPicture { width: 2, height: 1, counts: vec![count, 0] }
}

#[test]
fn optical_axes_point_where_rep_103_says() {
    let axis = |x, y, z| camera_from_optical() * Point3::new(x, y, z);
    for (optical, [x, y, z]) in [
        (axis(0.0, 0.0, 1.0), [1.0, 0.0, 0.0]),
        (axis(1.0, 0.0, 0.0), [0.0, -1.0, 0.0]),
        (axis(0.0, 1.0, 0.0), [0.0, 0.0, -1.0]),
    ] {
        assert!((optical - Point3::new(x, y, z)).norm() < 1e-12, "{optical}");
    }
}

#[test]
fn a_robot_stands_behind_and_below_its_camera() {
    // A camera that looks along the world's y axis: z of the optical frame along y, x right along x, y down along -z.
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let optical = UnitQuaternion::from_quaternion(Quaternion::new(quarter, -quarter, 0.0, 0.0));
    let world_from_optical = Pose3::from_parts(Translation3::new(1.0, 2.0, 0.7), optical);
    let mount = PlaceInSpace { x_m: 0.2, y_m: 0.1, z_m: 0.7, ..PlaceInSpace::default() };
    let mut place = CameraPlace { base_from_camera: mount.pose(), map_from_world: Pose3::identity() };
    let map_from_base = place.base_in_map(&world_from_optical);
    // It looks along y, so 0.2 m behind is at y - 0.2, and 0.1 m to the right of the camera is at x + 0.1.
    assert!((map_from_base.translation.vector - nalgebra::Vector3::new(1.1, 1.8, 0.0)).norm() < 1e-12);
    assert!((flatten(&map_from_base).rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    place.map_from_world = lift(&pose2(10.0, 0.0, std::f64::consts::PI));
    let turned = flatten(&place.base_in_map(&world_from_optical));
    assert!((turned.translation.vector - nalgebra::Vector2::new(8.9, -1.8)).norm() < 1e-12);
    assert!((turned.rotation.angle() + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    // A camera that looks down changes nothing of that where its mount says so.
    let down = PlaceInSpace { pitch_deg: 30.0, ..mount };
    let tilted = Pose3::from_parts(
        world_from_optical.translation,
        world_from_optical.rotation
            * (camera_from_optical().rotation.inverse()
                * UnitQuaternion::from_euler_angles(0.0, 30_f64.to_radians(), 0.0)
                * camera_from_optical().rotation),
    );
    let place = CameraPlace { base_from_camera: down.pose(), map_from_world: Pose3::identity() };
    let level = place.base_in_map(&tilted);
    assert!((level.translation.vector - map_from_base.translation.vector).norm() < 1e-12);
    assert!(level.rotation.angle_to(&map_from_base.rotation) < 1e-7);
}

#[test]
fn what_is_written_comes_back() {
    for encoding in [DepthEncoding::Gray16, DepthEncoding::TwoChannel] {
        let folder = scratch(&format!("back-{encoding:?}")).join("new");
        assert!(!is_folder(&folder));
        let mut writer = FolderWriter::create(&folder, encoding).unwrap();
        let pose = |k: i64| {
            let place =
                PlaceInSpace { x_m: k as f64, pitch_deg: 10.0, yaw_deg: -20.0, ..PlaceInSpace::default() };
            place.pose() * camera_from_optical()
        };
        let stamp = |k: i64| Time(1_305_031_453_000_000_000 + k * 33_333_000);
        for k in 0..5 {
            writer.picture(stamp(k), &picture(1000 + k as u16)).unwrap();
            writer.pose(stamp(k), &pose(k)).unwrap();
            writer.acceleration(stamp(k), [0.0, 9.81, k as f64]).unwrap();
        }
        assert!(matches!(writer.picture(stamp(4), &picture(1)), Err(RgbdError::Order { .. })));
        writer.finish().unwrap();
        assert!(is_folder(&folder));
        let read = read_folder(&folder).unwrap();
        let (track, sentences) = read_camera_track(&folder).unwrap();
        assert_eq!((read.sentences.len(), sentences.len()), (0, 0));
        assert_eq!((read.frames.len(), track.poses().len(), read.accelerations_m_s2.len()), (5, 5, 5));
        for (k, frame) in (0..).zip(&read.frames) {
            assert!((frame.stamp - stamp(k)).0.abs() < 1000, "stamps are read as seconds in 64 bits");
            assert_eq!(read_depth(&frame.path, encoding).unwrap(), picture(1000 + k as u16));
            let at = &track.poses()[k as usize].world_from_body;
            assert!((at.translation.vector - pose(k).translation.vector).norm() < 1e-6);
            assert!(at.rotation.angle_to(&pose(k).rotation) < 1e-6);
            assert_eq!(read.accelerations_m_s2[k as usize].1, [0.0, 9.81, k as f64]);
        }
        std::fs::remove_dir_all(folder.parent().unwrap()).unwrap();
    }
}

#[test]
fn damage_is_left_out_and_told() {
    let folder = scratch("damage");
    for name in ["a", "b", "c", "d", "e"] {
        write(folder.join("depth").join(name), "").unwrap();
    }
    let list = "# timestamp filename\n10.0 depth/a\n10.2 depth/b\n10.1 depth/c\n10.1 depth/d\n10.3 depth/missing\n\
                10.4 ../secret\n10.5 /etc/passwd\n10.6\nnoon depth/a\n13.0 depth/e\n500.0 depth/a\n13.1 depth/e extra\n\
                13.2 depth/d\n";
    write(folder.join("depth.txt"), list).unwrap();
    write(folder.join("accelerometer.txt"), "10.0 0 9.8 0\n10.0 0 9.9 0\n10.1 0 nan 0\n").unwrap();
    let read = read_folder(&folder).unwrap();
    let names: Vec<String> =
        read.frames.iter().map(|frame| frame.path.file_name().unwrap().to_string_lossy().into()).collect();
    assert_eq!(names, ["a", "c", "b", "e", "d"]);
    assert!(read.frames.is_sorted_by(|a, b| a.stamp < b.stamp));
    assert_eq!(read.accelerations_m_s2, [(Time::from_secs(10.0), [0.0, 9.8, 0.0])]);
    let told = read.sentences.join("\n");
    for expected in [
        "depth.txt: skipped 2 lines with a number out of its range, first line 7: depth.filename is `../secret`, expected \
         a path inside of the folder",
        "depth.txt: skipped 1 line with too few fields, first line 9",
        "depth.txt: skipped 1 line with no number, first line 10",
        "depth.txt: skipped 1 line with a count that disagrees",
        "depth.txt: stamps step backward 1 times, first in line 4, at most 0.100 s",
        "depth.txt: left out 1 rows whose stamps are more than 2 s out of order, the first in line 12",
        "depth.txt: left out 1 pictures that are not there, first depth/missing",
        "depth.txt: left out 1 pictures with the stamp of the picture before them, first depth/d",
        "depth.txt: 1 gaps of more than 1 s between pictures, the longest of 2.800 s after the one of 10.200000 s",
        "accelerometer.txt: skipped 1 line with a number that is not finite",
        "accelerometer.txt: left out 1 rows with the stamp of the row before them",
    ] {
        assert!(told.contains(expected), "{expected}\n---\n{told}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn folders_that_are_of_no_use_say_why() {
    let folder = scratch("no-use");
    let said = |folder: &std::path::Path| read_folder(folder).unwrap_err().to_string();
    assert!(said(&folder.join("no")).contains("there is no such folder"));
    assert!(said(&folder).contains("there is neither depth.txt nor depth.txt.gz"));
    write(folder.join("depth.txt"), "# timestamp filename\n").unwrap();
    assert!(said(&folder).contains("expected lines of `timestamp filename`"));
    write(folder.join("depth.txt"), "1.0 depth/a.png\n2.0 depth/b.png\n").unwrap();
    assert!(said(&folder).contains("none of the 2 pictures of depth.txt is there, the first is depth/a.png"));
    let poses = || read_camera_track(&folder).unwrap_err().to_string();
    assert!(poses().contains("neither groundtruth.txt nor"), "{}", poses());
    write(folder.join("groundtruth.txt"), "1.0 0 0 0 0 0 0 1\n2.0 0 0\n").unwrap();
    assert!(poses().contains("groundtruth.txt:2"), "{}", poses());
    std::fs::remove_dir_all(&folder).unwrap();
}
