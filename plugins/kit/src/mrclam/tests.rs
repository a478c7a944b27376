//! Folders, whole and damaged.

use std::io::Write as _;
use std::path::PathBuf;

use rumbo_core::time::Time;

use super::*;

/// A folder that goes with its test.
struct TempFolder(PathBuf);

impl Drop for TempFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const ODOMETRY: &str = "# made up\n100.0 0.1 0.0\n100.5 0.2 -0.4\n101.0\t0.0\t0.0\n";
const MEASUREMENT: &str = "100.2 63 2.5 0.1\n100.2 14 1.0 0.0\n100.7 63 2.25 -0.125\n";
const TRUTH: &str = "99.0 1.0 2.0 0.5\n101.0 1.5 2.0 0.5\n";
const LANDMARKS: &str = "# subject x y\n 6 \t 0.5 \t -4.25 \t 0.001 \t 0.002\n";
const BARCODES: &str = "1 5\n2 14\n6 63\n";

fn folder(name: &str) -> TempFolder {
    let path = std::env::temp_dir().join(format!("rumbo-mrclam-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    let folder = TempFolder(path);
    for (file, text) in [
        ("Robot1_Odometry.dat", ODOMETRY),
        ("Robot1_Measurement.dat", MEASUREMENT),
        ("Robot1_Groundtruth.dat", TRUTH),
        ("Landmark_Groundtruth.dat", LANDMARKS),
        ("Barcodes.dat", BARCODES),
    ] {
        folder.write(file, text);
    }
    folder
}

impl TempFolder {
    fn write(&self, file: &str, text: &str) {
        std::fs::write(self.0.join(file), text).unwrap();
    }

    fn write_gzip(&self, file: &str, text: &str, n_bytes_lost: usize) {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(text.as_bytes()).unwrap();
        let bytes = encoder.finish().unwrap();
        std::fs::write(self.0.join(file), &bytes[..bytes.len() - n_bytes_lost]).unwrap();
    }

    fn read(&self) -> RobotLog {
        read_robot(&self.0, 1).unwrap()
    }

    fn fault(&self) -> String {
        read_robot(&self.0, 1).unwrap_err().to_string()
    }
}

fn at(seconds: f64) -> Time {
    Time::from_secs(seconds)
}

#[test]
fn a_folder_is_read_as_it_is_and_robots_are_no_landmarks() {
    let folder = folder("whole");
    let log = folder.read();
    let velocity =
        |seconds, forward_m_s, turn_rad_s| Velocity { stamp: at(seconds), forward_m_s, turn_rad_s };
    assert_eq!(
        log.velocities,
        [velocity(100.0, 0.1, 0.0), velocity(100.5, 0.2, -0.4), velocity(101.0, 0.0, 0.0)]
    );
    let sighting =
        |seconds, range_m, bearing_rad| Sighting { stamp: at(seconds), subject: 6, range_m, bearing_rad };
    assert_eq!(log.sightings, [sighting(100.2, 2.5, 0.1), sighting(100.7, 2.25, -0.125)]);
    assert_eq!((log.n_robots_seen, log.sentences), (1, Vec::new()));
    let truth = read_truth(&folder.0, 1).unwrap();
    let middle = truth.track.between(at(100.0), rumbo_core::time::Span::from_secs(3.0)).unwrap();
    assert!((middle.translation.x - 1.25).abs() < 1e-12 && truth.sentences.is_empty());
    let place = LandmarkPlace { subject: 6, position_m: [0.5, -4.25], deviation_m: [0.001, 0.002] };
    assert_eq!(read_landmarks(&folder.0).unwrap(), [place]);
}

#[test]
fn gzip_is_read_as_well_and_one_that_is_cut_off_up_to_the_cut() {
    let folder = folder("gzip");
    std::fs::remove_file(folder.0.join("Robot1_Odometry.dat")).unwrap();
    let many: String = (0..2000).map(|k| format!("{}.125 0.0{} -0.{k}\n", 100 + k, k % 7)).collect();
    folder.write_gzip("Robot1_Odometry.dat.gz", &many, 0);
    assert_eq!(folder.read().velocities.len(), 2000);
    folder.write_gzip("Robot1_Odometry.dat.gz", &many, 500);
    let log = folder.read();
    assert!((100..2000).contains(&log.velocities.len()), "{}", log.velocities.len());
    let told = &log.sentences[0];
    assert!(told.starts_with("Robot1_Odometry.dat.gz: line ") && told.contains("cut off"), "{told}");
}

#[test]
fn what_is_missing_is_named() {
    let folder = folder("missing");
    for file in ["Robot1_Odometry.dat", "Robot1_Measurement.dat", "Barcodes.dat", "Landmark_Groundtruth.dat"]
    {
        let text = std::fs::read_to_string(folder.0.join(file)).unwrap();
        std::fs::remove_file(folder.0.join(file)).unwrap();
        let fault = folder.fault();
        assert!(fault.ends_with(&format!("there is neither {file} nor {file}.gz")), "{fault}");
        folder.write(file, &text);
    }
    assert!(read_robot(&folder.0, 4).unwrap_err().to_string().contains("Robot4_Odometry.dat"));
    assert!(read_truth(&folder.0, 4).unwrap_err().to_string().contains("Robot4_Groundtruth.dat"));
    let nowhere = read_robot(&folder.0.join("nowhere"), 1).unwrap_err().to_string();
    assert!(nowhere.contains("no such folder"), "{nowhere}");
    folder.write("Robot1_Odometry.dat", "# nothing\n");
    assert!(folder.fault().contains("no row can be read; expected lines of `time forward_velocity"));
    folder.write("Robot1_Odometry.dat", "100.0 fast 0.0\n");
    let fault = folder.fault();
    assert!(fault.contains("line 1: Odometry.forward_velocity is `fast`, expected a number"), "{fault}");
}

#[test]
fn lines_that_cannot_be_read_are_skipped_and_told_with_their_place() {
    let folder = folder("lines");
    let damaged = "100.0 0.1 0.0\n100.1 quick 0.0\n100.2 0.1\n100.3 0.1 0.0 0.0\n100.4 0.1 inf\n100.5 0.3 0.0\n100.6 0.1 0.";
    folder.write("Robot1_Odometry.dat", damaged);
    folder.write(
        "Robot1_Measurement.dat",
        "100.2 63 -2.5 0.1\n100.3 63.5 1.0 0.0\n100.4 77 1.0 0.0\n100.5 63 2.0 0.0\n",
    );
    let log = folder.read();
    assert_eq!(log.velocities.iter().map(|v| v.forward_m_s).collect::<Vec<_>>(), [0.1, 0.3]);
    assert_eq!(log.sightings.iter().map(|s| s.range_m).collect::<Vec<_>>(), [2.0]);
    let told = log.sentences.join("\n");
    for sentence in [
        "Robot1_Odometry.dat: line 7: the file is cut off: the last line has no end; what comes before was read",
        "first line 2: Odometry.forward_velocity is `quick`, expected a number",
        "first line 3: Odometry.angular_velocity is missing at the end of the line, expected a value",
        "first line 4: Odometry.the row is `0.0`, expected the end of the line",
        "first line 5: Odometry.angular_velocity is inf",
        "Robot1_Measurement.dat: skipped 2 lines with a number out of its range, first line 1: Measurement.range is -2.5",
        "left out 1 sightings of bar codes that Barcodes.dat does not have, first 77 in line 3",
    ] {
        assert!(told.contains(sentence), "{sentence} is not in:\n{told}");
    }
}

#[test]
fn small_disorder_is_sorted_and_wrong_stamps_are_left_out() {
    let folder = folder("order");
    let rows = "100.0 0.0 0\n100.2 0.2 0\n100.1 0.1 0\n999.0 0.9 0\n100.3 0.3 0\n5.0 0.9 0\n100.4 0.4 0\n200.0 0.5 0\n200.1 0.6 0\n";
    folder.write("Robot1_Odometry.dat", rows);
    let log = folder.read();
    let speeds: Vec<f64> = log.velocities.iter().map(|v| v.forward_m_s).collect();
    assert_eq!(speeds, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "a gap is no wrong stamp");
    let told = log.sentences.join("\n");
    assert!(told.contains("stamps step backward 1 times, first in line 3, at most 0.100 s"), "{told}");
    assert!(told.contains("left out 2 rows") && told.contains("the first in line 4"), "{told}");
}

#[test]
fn tables_that_all_robots_share_must_be_whole() {
    let folder = folder("shared");
    for (file, text, told) in [
        ("Barcodes.dat", "1 5\n2 fourteen\n", "line 2: barcode.barcode is `fourteen`, expected a number"),
        ("Barcodes.dat", "1 5\n2 14\n2 15\n", "line 3: subject 2 is there twice, first in line 2"),
        ("Barcodes.dat", "1 5\n2 5\n", "line 2: bar code 5 is there twice, first in line 1"),
        ("Barcodes.dat", "1 5\n2 14", "line 2: the file is cut off"),
        ("Barcodes.dat", "# none\n", "no row can be read"),
        ("Landmark_Groundtruth.dat", "6 0 0 0 -1\n", "line 1: landmark.y_deviation is -1"),
        ("Landmark_Groundtruth.dat", "6 0 0 0 0\n6 1 1 0 0\n", "line 2: landmark 6 is there twice"),
    ] {
        let before = std::fs::read_to_string(folder.0.join(file)).unwrap();
        folder.write(file, text);
        let fault = folder.fault();
        assert!(fault.contains(file) && fault.contains(told), "{fault}");
        folder.write(file, &before);
    }
}
