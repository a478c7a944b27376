use super::*;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rumbo_core::frames::Pose3;
use rumbo_core::time::Time;
use rumbo_kit::recording::cdr::CdrReader;
use rumbo_kit::recording::ros::{RosData, RosMessage, read_ros};
use rumbo_kit::recording::{BagReader, RecordingReader};
use std::collections::{BTreeMap, BTreeSet};

/// Runs a pipeline and records it.
pub fn recorded(folder: &Path, name: &str, args: &[&str]) -> String {
    let path = folder.join(name).display().to_string();
    let given = give(&[&["run"], args, &["--no-report", "--quiet", "--record", &path]].concat());
    assert!(given.code < 2, "{}", given.stderr);
    path
}

#[test]
fn recording_changes_no_figure_of_the_run() {
    let file = scratch("record_figures").join("a.mcap");
    let figures = |args: &[&str]| {
        let given =
            give(&[&["run", "pipelines/office_blocked.toml", "--no-report", "--json"], args].concat());
        let measured = |line: &&str| line.contains("\"realtime_factor\"") || line.contains("\"cpu_");
        given.stdout.lines().filter(|line| !measured(line)).map(str::to_owned).collect::<Vec<String>>()
    };
    assert_eq!(figures(&[]), figures(&["--record", file.to_str().unwrap()]));
    assert!(file.is_file());
}

#[test]
fn the_same_run_makes_the_same_recording() {
    let folder = scratch("record_twice");
    let read = |name| std::fs::read(recorded(&folder, name, &[OFFICE, "--set", SHORT])).unwrap();
    assert!(read("a.mcap") == read("b.mcap"));
}

#[test]
fn a_recording_has_what_viewers_draw_and_what_a_replay_needs() {
    let file = recorded(&scratch("record_topics"), "a.mcap", &[OFFICE, "--set", SHORT]);
    let mut counts = BTreeMap::new();
    for message in BagReader::open(Path::new(&file)).unwrap() {
        assert_eq!(message.channel.encoding, "cdr");
        *counts.entry((message.channel.topic.clone(), message.channel.schema.clone())).or_insert(0) += 1;
    }
    let count = |topic: &str, schema: &str| counts.get(&(topic.into(), schema.into())).copied().unwrap_or(0);
    let n_scans = count("/sensor/front_laser", "sensor_msgs/msg/LaserScan");
    assert!(n_scans > 10, "{counts:#?}");
    for (topic, schema) in [
        ("/tf", "tf2_msgs/msg/TFMessage"),
        ("/tf_static", "tf2_msgs/msg/TFMessage"),
        ("/pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
        ("/truth", "geometry_msgs/msg/PoseStamped"),
        ("/cmd_vel", "geometry_msgs/msg/TwistStamped"),
        ("/plan", "nav_msgs/msg/Path"),
        ("/map", "nav_msgs/msg/OccupancyGrid"),
        ("/log", "rcl_interfaces/msg/Log"),
        ("/rumbo/run", "rumbo_msgs/msg/Run"),
        ("/rumbo/step", "rumbo_msgs/msg/PackedStep"),
        ("/rumbo/end", "rumbo_msgs/msg/End"),
    ] {
        assert!(count(topic, schema) > 0, "{topic}: {counts:#?}");
    }
    let mut said = BTreeMap::new();
    let mut reader = RecordingReader::open(Path::new(&file)).unwrap();
    while let Some(step) = reader.next_step() {
        for message in step.messages {
            *said.entry((message.channel.topic.clone(), message.channel.schema.clone())).or_insert(0) += 1;
        }
    }
    let count = |topic: &str, schema: &str| said.get(&(topic.into(), schema.into())).copied().unwrap_or(0);
    assert_eq!(count("/rumbo/sensor/front_laser/laser_scan", "rumbo_msgs/msg/LaserScan"), n_scans);
    for (topic, schema) in [
        ("/rumbo/estimate", "rumbo_msgs/msg/Estimate"),
        ("/rumbo/path", "rumbo_msgs/msg/Path"),
        ("/rumbo/command", "rumbo_msgs/msg/Command"),
        ("/rumbo/event", "rumbo_msgs/msg/Event"),
        ("/rumbo/step", "rumbo_msgs/msg/Step"),
        ("/rumbo/map", "rumbo_msgs/msg/MapHash"),
    ] {
        assert!(count(topic, schema) > 0, "{topic}: {said:#?}");
    }
    // Ranges are written once: for viewers, and the exact steps refer to them.
    let n_bytes = std::fs::metadata(&file).unwrap().len();
    assert!(n_bytes < n_scans * (2 * 361 * 4) + 500_000, "{n_bytes} bytes for {n_scans} scans");
}

#[test]
fn a_pipeline_can_ask_for_its_recording() {
    let folder = scratch("record_key");
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join(OFFICE).display().to_string();
    let run = |args: &[&str]| {
        let args = [&["run", &office, "--set", SHORT, "--no-report", "--quiet"], args].concat();
        given(rumbo(&args).current_dir(&folder))
    };
    assert_eq!(run(&["--set", "record=true"]).code, 0);
    assert!(folder.join("out/office.mcap").is_file());
    let named = folder.join("named.mcap");
    assert_eq!(run(&["--set", &format!("record={}", named.display())]).code, 0);
    assert!(named.is_file());
    let wrong = run(&["--set", "record=3"]);
    assert_eq!(wrong.code, 2);
    assert!(wrong.stderr.contains("record"), "{}", wrong.stderr);
    let text =
        std::fs::read_to_string(&office).unwrap().replace("seed = 7", "seed = 7\nrecord = \"sub/a.mcap\"");
    let pipelines = format!("include = [\"{}/pipelines/", env!("CARGO_MANIFEST_DIR"));
    let text = text.replace("include = [\"", &pipelines);
    let map = format!("\"{}/pipelines/worlds/", env!("CARGO_MANIFEST_DIR"));
    std::fs::write(folder.join("own.toml"), text.replace("\"worlds/", &map)).unwrap();
    let own = folder.join("own.toml").display().to_string();
    assert_eq!(give(&["run", &own, "--set", SHORT, "--no-report", "--quiet"]).code, 0);
    assert!(folder.join("sub/a.mcap").is_file(), "relative to the pipeline's folder");
}

#[test]
fn a_recording_that_cannot_be_written_is_the_commands_own_failure() {
    let folder = scratch("record_not_writable");
    std::fs::write(folder.join("file"), "").unwrap();
    let file = folder.join("file/a.mcap").display().to_string();
    let given = give(&["run", OFFICE, "--set", SHORT, "--no-report", "--record", &file]);
    assert_eq!(given.code, 3, "{}", given.stderr);
    if Path::new("/dev/full").exists() {
        let given = give(&["run", OFFICE, "--set", SHORT, "--no-report", "--record", "/dev/full"]);
        assert_eq!(given.code, 3, "{}", given.stderr);
        assert!(given.stderr.contains("cannot write /dev/full"), "{}", given.stderr);
    }
}

#[test]
fn a_recording_is_a_world_for_another_pipeline() {
    let folder = scratch("record_world");
    let file = recorded(&folder, "a.mcap", &[OFFICE, "--set", SHORT]);
    let text = format!(
        "[world]\nplugin = \"log\"\nfile = \"{file}\"\nchannels = {{ eyes = \"front_laser\" }}\n\
         [[sensor]]\nname = \"eyes\"\nplugin = \"laser_2d\"\n\
         [[sensor]]\nname = \"odometry\"\nplugin = \"wheel_encoders\"\n\
         [map_builder]\nplugin = \"occupancy_grid\"\n[localizer]\nplugin = \"odometry\"\n"
    );
    let pipeline = folder.join("again.toml");
    std::fs::write(&pipeline, &text).unwrap();
    let given = give(&["run", pipeline.to_str().unwrap(), "--no-report", "--json"]);
    let figures = given.json();
    assert_eq!(figures["reason"], "ended", "{}", given.stderr);
    assert!(figures["map_free_m2"].as_f64().unwrap() > 10.0, "{figures}");
    assert!(figures["final_error_m"].as_f64().unwrap() < 0.1, "{figures}");
    assert_eq!(figures["stage_failures"], 0, "{figures}");
    // A run in a recorded world can be recorded and replayed, too.
    let again = recorded(&folder, "b.mcap", &[pipeline.to_str().unwrap()]);
    let replayed = give(&["replay", &again]);
    assert_eq!(replayed.code, 0, "{}", replayed.stderr);
    std::fs::write(&pipeline, text.replace("\"front_laser\"", "\"front_lasr\"")).unwrap();
    let given = give(&["check", pipeline.to_str().unwrap()]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("recorded with the sensors front_laser"), "{}", given.stderr);
}

#[test]
fn viewers_get_frames_five_times_and_poses_twice_a_second() {
    let file = recorded(&scratch("record_rates"), "a.mcap", &[OFFICE, "--set", SHORT]);
    let mut times: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for message in BagReader::open(Path::new(&file)).unwrap() {
        times.entry(message.channel.topic.clone()).or_default().push(message.log_time.as_secs());
    }
    for (topic, period_s) in [("/tf", 0.2), ("/pose", 0.5), ("/truth", 0.5), ("/cmd_vel", 0.5)] {
        let steps_s: Vec<f64> = times[topic].windows(2).map(|pair| pair[1] - pair[0]).collect();
        let are_regular = steps_s.iter().all(|step_s| (step_s - period_s).abs() < 0.051);
        assert!(steps_s.len() > 3 && are_regular, "{topic}: {steps_s:?}");
    }
}

/// All transforms of a recording in order: topic, time, parent, child, and the pose.
fn transforms(file: &str) -> Vec<(String, Time, String, String, Pose3)> {
    let mut all = Vec::new();
    for message in BagReader::open(Path::new(file)).unwrap() {
        let said = read_ros(&message.channel.schema, &message.data).unwrap();
        let Some(RosMessage { stamp, data: RosData::Transforms(links), .. }) = said else { continue };
        let topic = &message.channel.topic;
        all.extend(
            links.into_iter().map(|(parent, child, pose)| (topic.clone(), stamp, parent, child, pose)),
        );
    }
    all
}

#[test]
fn a_body_that_sways_leans_in_the_recording_as_it_does_in_the_world() {
    let pipeline = "pipelines/finder_swaying.toml";
    let file = recorded(&scratch("record_body"), "a.mcap", &[pipeline, "--duration", "8"]);
    let truth =
        BagReader::open(Path::new(&file)).unwrap().filter(|message| message.channel.topic == "/truth");
    let attitudes: BTreeMap<Time, UnitQuaternion<f64>> = truth
        .map(|message| {
            let mut cdr = CdrReader::new(&message.data).unwrap();
            let (_seconds, _nanoseconds, _frame) =
                (cdr.i32().unwrap(), cdr.u32().unwrap(), cdr.text().unwrap());
            let (_place, [i, j, k, w]): ([f64; 3], [f64; 4]) = (cdr.array().unwrap(), cdr.array().unwrap());
            (message.log_time, UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)))
        })
        .collect();
    let links = transforms(&file);
    let leans = links.iter().filter(|(.., parent, child, _)| (parent.as_str(), child.as_str()) == STABILIZED);
    let (mut n_compared, mut most_deg) = (0, 0.0f64);
    for (topic, stamp, _, _, lean) in leans {
        assert_eq!(topic, "/tf");
        let Some(truth) = attitudes.get(stamp) else { continue };
        let (up, true_up) = (lean.rotation.inverse() * Vector3::z(), truth.inverse() * Vector3::z());
        assert!(up.angle(&true_up).to_degrees() < 3.0, "{stamp}: {up} instead of {true_up}");
        n_compared += 1;
        most_deg = most_deg.max(true_up.angle(&Vector3::z()).to_degrees());
    }
    assert!(n_compared >= 8 && most_deg > 15.0, "{n_compared} compared, up to {most_deg} degrees");
    let parents = |of: &str| -> BTreeSet<&str> {
        let those = links.iter().filter(|(_, _, _, child, _)| child == of);
        those.map(|(_, _, parent, _, _)| parent.as_str()).collect()
    };
    for (child, parent) in [
        ("odom", "map"),
        ("base_footprint", "odom"),
        ("base_stabilized", "base_footprint"),
        ("laser", "base_link"),
        ("level_laser", "base_stabilized"),
    ] {
        assert_eq!(parents(child), BTreeSet::from([parent]), "{child}");
    }
}

const STABILIZED: (&str, &str) = ("base_stabilized", "base_link");

#[test]
fn a_body_of_which_nobody_says_how_it_leans_stands_upright_once_and_for_all() {
    let file = recorded(&scratch("record_upright"), "a.mcap", &[OFFICE, "--set", SHORT]);
    let links = transforms(&file);
    let of_body: Vec<_> = links.iter().filter(|(.., child, _)| child.starts_with("base_")).collect();
    let upright: Vec<_> = of_body.iter().filter(|(.., child, _)| child != "base_footprint").collect();
    assert_eq!(upright.len(), 2);
    for (topic, _, _, child, pose) in upright {
        assert_eq!((topic.as_str(), pose), ("/tf_static", &Pose3::identity()), "{child}");
    }
    let mounts = links.iter().filter(|(.., child, _)| child == "front_laser");
    let mounts: BTreeSet<_> =
        mounts.map(|(topic, _, parent, ..)| (topic.as_str(), parent.as_str())).collect();
    assert_eq!(mounts, BTreeSet::from([("/tf_static", "base_link")]));
}
