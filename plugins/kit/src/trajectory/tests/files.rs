use super::*;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A file that goes with its test.
struct TempFile(PathBuf);

impl TempFile {
    fn new(bytes: impl AsRef<[u8]>) -> TempFile {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("rumbo-trajectory-{}-{n}.txt", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        TempFile(path)
    }
}

impl Drop for TempFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn read(text: impl AsRef<[u8]>) -> Result<TrajectoryFile, TrajectoryError> {
    read_trajectory(&TempFile::new(text).0, None, None)
}

fn error(text: impl AsRef<[u8]>) -> String {
    let file = TempFile::new(text);
    let message = read_trajectory(&file.0, None, None).unwrap_err().to_string();
    message.replace(&file.0.display().to_string(), "FILE")
}

const TUM: &str =
    "# t tx ty tz qx qy qz qw\n1305031102.160407 1 2 3 0 0 0 2\n\n1305031102.260407 4 5 6 0 0 1 0\n";
const KITTI: &str = "1 0 0 5 0 1 0 6 0 0 1 7\n0 -1 0 1 1 0 0 2 0 0 1 3\n";
const LOG: &str = "# a log\nODOM 1 2 0.5 0 0 0 10.0 x 0\nFLASER 2 1.0 2.0 7 8 0.9 3 4 -0.5 11.0 x 0\nODOM 9 9 0 0 0 0 11.0 x 0\n";

#[test]
fn every_format_is_recognized_and_read_plain_or_gzip() {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(TUM.as_bytes()).unwrap();
    let zipped = encoder.finish().unwrap();
    for bytes in [TUM.as_bytes(), &zipped] {
        let tum = read(bytes).unwrap();
        assert_eq!((tum.format, tum.has_stamps, tum.notes.len()), (TrajectoryFormat::Tum, true, 0));
        let last = tum.trajectory.poses()[1];
        assert_eq!(last.stamp, Time::from_secs(1_305_031_102.260_407));
        let expected = pose(4.0, 5.0, 6.0, [0.0, 0.0, std::f64::consts::PI]);
        assert!(last.world_from_body.rotation.angle_to(&expected.rotation) < 1e-7);
    }
    let planar = read("1 2 3 0.5\n2 3 4 -0.5\n").unwrap();
    assert_eq!(planar.format, TrajectoryFormat::Planar);
    assert_eq!(planar.trajectory.poses()[0], stamped(1.0, pose(2.0, 3.0, 0.0, [0.0, 0.0, 0.5])));
    let kitti = read(KITTI).unwrap();
    assert_eq!((kitti.format, kitti.has_stamps), (TrajectoryFormat::Kitti, false));
    let second = kitti.trajectory.poses()[1];
    assert_eq!(second.stamp, Time::from_secs(1.0));
    assert!((second.world_from_body.rotation.euler_angles().2 - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert_eq!(second.world_from_body.translation.vector, Vector3::new(1.0, 2.0, 3.0));
}

#[test]
fn a_log_gives_the_poses_of_its_scans_or_those_of_its_odometer() {
    let file = TempFile::new(LOG);
    let corrected = read_trajectory(&file.0, None, None).unwrap();
    assert_eq!(corrected.format, TrajectoryFormat::Log);
    assert_eq!(corrected.trajectory.poses(), [stamped(11.0, pose(7.0, 8.0, 0.0, [0.0, 0.0, 0.9]))]);
    let odometry = read_trajectory(&file.0, Some(TrajectoryFormat::Odometry), None).unwrap();
    let expected = [
        stamped(10.0, pose(1.0, 2.0, 0.0, [0.0, 0.0, 0.5])),
        stamped(11.0, pose(3.0, 4.0, 0.0, [0.0, 0.0, -0.5])),
    ];
    assert_eq!(odometry.trajectory.poses(), expected, "of equal stamps the scan's stays");
    assert!(odometry.notes.is_empty(), "{:?}", odometry.notes);
}

#[test]
fn stamps_of_a_kitti_file_come_from_a_file_of_times() {
    let (poses, times) = (TempFile::new(KITTI), TempFile::new("0.0e+00\n1.037359e-01\n"));
    let read = read_trajectory(&poses.0, None, Some(&times.0)).unwrap();
    assert!(read.has_stamps);
    assert_eq!(read.trajectory.poses()[1].stamp, Time::from_secs(0.103_735_9));
    let short = TempFile::new("0\n");
    let error = read_trajectory(&poses.0, None, Some(&short.0)).unwrap_err().to_string();
    assert!(error.contains("1 stamps for the 2 poses"), "{error}");
    let bad = TempFile::new("0\nnoon\n");
    let error = read_trajectory(&poses.0, None, Some(&bad.0)).unwrap_err().to_string();
    assert!(error.contains(":2: times.t is `noon`, expected a number"), "{error}");
    let stamped = TempFile::new(TUM);
    let read = read_trajectory(&stamped.0, None, Some(&times.0)).unwrap();
    assert!(read.notes[0].contains("the times file was not used"));
}

#[test]
fn a_format_that_is_named_is_taken() {
    let file = TempFile::new("1 2 3 0.5 0.1 0.2 0.3 0.4\n");
    let planar = read_trajectory(&file.0, Some(TrajectoryFormat::Planar), None).unwrap();
    assert_eq!(planar.trajectory.poses(), [stamped(1.0, pose(2.0, 3.0, 0.0, [0.0, 0.0, 0.5]))]);
    let error = read_trajectory(&file.0, Some(TrajectoryFormat::Kitti), None).unwrap_err().to_string();
    assert!(error.contains(":1: pose.r31 is missing at the end of the line"), "{error}");
}

#[test]
fn what_can_be_mended_is_mended_and_noted() {
    let mended = read("2 1 0 0\n1 2 0 0\n3 nan 0 0\n4 inf 0 0\n2 7 0 0\n5 1 2").unwrap();
    let places: Vec<f64> =
        mended.trajectory.poses().iter().map(|pose| pose.world_from_body.translation.x).collect();
    assert_eq!(places, [2.0, 1.0]);
    let notes = mended.notes.join("\n");
    for words in [
        "2 lines were left out, first line 3: pose.x is NaN",
        "line 6: the file is cut off: pose.theta is missing",
        "step backwards in 1 places",
        "1 of 3 poses have the stamp of another one",
    ] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
    let zipped = {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::none());
        encoder.write_all("1 2 3 0\n".repeat(5000).as_bytes()).unwrap();
        encoder.finish().unwrap()
    };
    let cut = read(&zipped[..zipped.len() - 9]).unwrap();
    assert!(cut.notes[0].contains("the gzip stream ends early"), "{:?}", cut.notes);
}

#[test]
fn what_cannot_be_mended_is_told_with_file_line_and_the_way_out() {
    for (text, expected) in [
        ("", "FILE: the file is empty, expected a trajectory (TUM, KITTI or `t x y theta`) or a robot log"),
        ("# nothing\n\n", "FILE: 2 lines, all of them empty or comments, expected a trajectory"),
        ("1 2 3 4 5\n", "FILE:1: the line has 5 words, expected 4 (t x y theta), 8"),
        ("1 2 3 0\n2 2 x 0\n", "FILE:2: pose.y is `x`, expected a number; correct or remove the line"),
        (
            "1 2 3 0 0 0 0 0\n",
            "FILE:1: pose.quaternion is 0 0 0 0, expected four numbers that are not all zero",
        ),
        ("1 2 3 0 0 0 0 1\n1 2 3\n", "FILE:2: pose.tz is missing at the end of the line"),
        (
            "1 2 3 0 0 0 0 1\n1 2 3 0 0 0 0 1 9\n",
            "FILE:2: pose.end is followed by 1 more words, expected t tx",
        ),
        ("2 0 0 0 0 1 0 0 0 0 1 0\n", "FILE:1: pose.rotation is [2 0 0; 0 1 0; 0 0 1], expected a rotation"),
        (
            "-1 0 0 0 0 1 0 0 0 0 1 0\n",
            "FILE:1: pose.rotation is [-1 0 0; 0 1 0; 0 0 1], expected a rotation",
        ),
        ("1 nan 3 0\n", "FILE: no pose (1 line was left out, first line 1: pose.x is NaN"),
        ("hello\n", "FILE: no record found: 1 lines, line 1 begins with `hello`, expected a CARMEN log"),
    ] {
        let message = error(text);
        assert!(message.contains(expected), "{text:?} gave {message}");
    }
    let folder = read_trajectory(&std::env::temp_dir(), None, None).unwrap_err();
    assert!(matches!(folder, TrajectoryError::Folder { .. }));
    let missing = read_trajectory(&PathBuf::from("no/such/file.txt"), None, None).unwrap_err();
    assert!(missing.to_string().contains("no/such/file.txt: cannot read the file"));
}
