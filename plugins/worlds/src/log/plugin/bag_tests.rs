//! Bags played through the traits.

use super::*;
use rumbo_core::frames::{Pose3, Twist};
use rumbo_core::messages::{Data, LaserScan, Observation};
use rumbo_kit::recording::cdr::CdrWriter;
use rumbo_kit::recording::ros::{self, Stamped, layout};
use rumbo_kit::recording::{BagWriter, TopicId};
use std::io::Cursor;

struct TempBag(PathBuf);

impl Drop for TempBag {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A bag with scans on /scan, an odometer on /tf, and a log; stamps are those of a clock of its own.
fn bag(name: &str) -> TempBag {
    let mut bag = BagWriter::new(Cursor::new(Vec::new())).unwrap();
    let mut cdr = CdrWriter::default();
    let [scan, tf, log] =
        [("/scan", &layout::LASER_SCAN), ("/tf", &layout::TRANSFORMS), ("/rosout", &layout::LOG)]
            .map(|(topic, layout)| bag.topic(topic, layout).unwrap());
    let mut say = |topic: TopicId, log_time: f64, cdr: &CdrWriter| {
        bag.write(topic, Time::from_secs(log_time), cdr.bytes()).unwrap();
    };
    for k in 0..10 {
        let (seconds, log_time) = (500.0 + f64::from(k), 1.7e9 + f64::from(k));
        let stamp = Time::from_secs(seconds);
        let moved = Pose3::translation(0.5 * f64::from(k), 0.0, 0.0);
        let places = [("base", "laser", Pose3::identity()), ("odom", "base", moved)];
        ros::put_transforms(&mut cdr, stamp, &places);
        say(tf, log_time, &cdr);
        let ranges_m = [1.0f32, 2.0, 99.0].as_slice().into();
        let data = LaserScan { bearing_step_rad: 0.5, max_range_m: 8.0, ranges_m, ..LaserScan::default() };
        // Scans are written down late, behind the transforms of the next second.
        let stamp = Time::from_secs(seconds - 0.5);
        if k > 0 {
            ros::put_scan(&mut cdr, Stamped { stamp, frame: "laser" }, &data);
            say(scan, log_time, &cdr);
        }
        ros::put_log(&mut cdr, stamp, false, "on the way");
        say(log, log_time, &cdr);
    }
    let bytes = bag.finish().unwrap().into_inner();
    let path = std::env::temp_dir().join(format!("rumbo-bag-{name}-{}.mcap", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    TempBag(path)
}

/// The same bag, packed by the format's own writer as `ros2 bag record` does.
fn packed(bag: &TempBag, name: &str, compression: Option<mcap::Compression>) -> TempBag {
    let bytes = std::fs::read(&bag.0).unwrap();
    let options = mcap::WriteOptions::new().profile("ros2").compression(compression).chunk_size(Some(500));
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    let path = std::env::temp_dir().join(format!("rumbo-bag-{name}-{}.mcap", std::process::id()));
    std::fs::write(&path, writer.into_inner().into_inner()).unwrap();
    TempBag(path)
}

#[test]
fn bags_that_are_packed_play_the_same_and_up_to_a_cut() {
    let plain = bag("plain");
    let played = |bag: &TempBag| {
        let mut world = build(&params(bag, &[("laser", "/scan")])).unwrap();
        play(world.as_mut(), &Probe::Channel { name: "laser" })
    };
    let (expected, _) = played(&plain);
    assert_eq!(expected.len(), 9);
    for (name, compression) in
        [("unpacked", None), ("lz4", Some(mcap::Compression::Lz4)), ("zstd", Some(mcap::Compression::Zstd))]
    {
        let file = packed(&plain, name, compression);
        assert_eq!(played(&file), (expected.clone(), Vec::new()), "{name}");
        let bytes = std::fs::read(&file.0).unwrap();
        // Every piece says how it is packed.
        let is_packed = bytes.windows(name.len()).any(|window| window == name.as_bytes());
        assert_eq!(is_packed, compression.is_some(), "{name}");
        // The index at the end is about half of so short a file.
        std::fs::write(&file.0, &bytes[..bytes.len() * 2 / 5]).unwrap();
        let (cut, notices) = played(&file);
        assert!(cut.len() > 1 && cut.len() < 9 && cut[..] == expected[..cut.len()], "{name}: {}", cut.len());
        assert_eq!(notices.len(), 1, "{name}: {notices:?}");
    }
}

fn params(bag: &TempBag, channels: &[(&str, &str)]) -> LogParams {
    let channels = channels.iter().map(|(sensor, topic)| ((*sensor).to_owned(), (*topic).to_owned()));
    LogParams { file: bag.0.clone(), channels: channels.collect(), ..LogParams::default() }
}

fn build(params: &LogParams) -> Result<Box<dyn World>, BuildError> {
    params.build(&BuildContext::bare("world"))
}

fn play(world: &mut dyn World, probe: &Probe<'_>) -> (Vec<Observation>, Vec<String>) {
    let (mut observations, mut notices) = (Vec::new(), Vec::new());
    loop {
        let due = world.next_recorded().unwrap();
        let advanced = world.advance(due).unwrap();
        notices.extend(std::iter::from_fn(|| world.take_notice()));
        if advanced == Advance::Ended {
            return (observations, notices);
        }
        let Ok(Answer::Recorded(new)) = world.probe(probe) else { panic!("no recording") };
        observations.extend(new.iter().cloned());
    }
}

#[test]
fn a_bag_plays_at_the_stamps_of_its_messages_whatever_its_name_and_clock() {
    let file = bag("plays");
    let mut world = build(&params(&file, &[("laser", "/scan"), ("wheels", "/tf")])).unwrap();
    assert_eq!((world.now(), world.next_recorded()), (Time::ZERO, Some(Time::ZERO)));
    let (scans, notices) = play(world.as_mut(), &Probe::Channel { name: "laser" });
    let stamps: Vec<f64> = scans.iter().map(|scan| scan.stamp.as_secs()).collect();
    assert_eq!(stamps, [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5]);
    assert!(notices.is_empty(), "{notices:?}");
    let Data::LaserScan(scan) = &scans[0].data else { panic!("a scan") };
    assert_eq!(scan.ranges_m.as_slice(), [1.0, 2.0, f32::INFINITY]);
    let mut world = build(&params(&file, &[("wheels", "/tf")])).unwrap();
    let (odometry, _) = play(world.as_mut(), &Probe::Channel { name: "wheels" });
    let Data::Odometry(last) = &odometry[9].data else { panic!("odometry") };
    assert_eq!((last.odom_from_base, last.twist), (pose2(4.5, 0.0, 0.0), Twist::new(0.5, 0.0)));
}

#[test]
fn without_channels_a_sensor_gets_the_topic_of_its_name_or_the_only_one_of_its_kind() {
    let file = bag("unnamed");
    let beams = Probe::Beams {
        base_from_sensor: &Pose3::identity(),
        first_bearing_rad: 0.0,
        bearing_step_rad: 0.1,
        n_beams: 3,
        max_range_m: 8.0,
    };
    let count = |probe: &Probe<'_>| play(build(&params(&file, &[])).unwrap().as_mut(), probe).0.len();
    assert_eq!(count(&beams), 9);
    assert_eq!(count(&Probe::Wheels), 10);
    assert_eq!(count(&Probe::Channel { name: "scan" }), 9);
    let (none, notices) =
        play(build(&params(&file, &[])).unwrap().as_mut(), &Probe::Channel { name: "nothing" });
    assert!(none.is_empty() && notices[0].ends_with("asked for /nothing, of which this bag has nothing"));
}

#[test]
fn a_topic_that_is_missing_or_nothing_for_sensors_is_named_with_what_there_is() {
    let file = bag("missing");
    let fault = build(&params(&file, &[("laser", "/scna")])).err().unwrap();
    assert_eq!(fault.path, "channels.laser");
    assert!(
        fault
            .message
            .contains("is `/scna`, which this bag does not have; it has /rosout (rcl_interfaces/msg/Log)"),
        "{fault}"
    );
    let fault = build(&params(&file, &[("laser", "/rosout")])).err().unwrap();
    assert!(fault.message.contains("is `/rosout`, a rcl_interfaces/msg/Log, expected one of"), "{fault}");
    let inside = LogParams { truth: Some("log".into()), ..params(&file, &[]) };
    assert_eq!(build(&inside).err().unwrap().path, "truth");
}

#[test]
fn a_bag_that_is_cut_plays_up_to_the_cut_and_says_so() {
    let file = bag("cut");
    let whole = std::fs::read(&file.0).unwrap();
    std::fs::write(&file.0, &whole[..whole.len() / 2]).unwrap();
    let mut world = build(&params(&file, &[])).unwrap();
    let (odometry, notices) = play(world.as_mut(), &Probe::Wheels);
    assert!(!odometry.is_empty() && odometry.len() < 10, "{}", odometry.len());
    assert!(notices.len() == 1 && notices[0].ends_with("the file is cut off"), "{notices:?}");
}
