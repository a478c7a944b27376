use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::layout::{END, PACKED_STEP, RUN, SCHEMA};
use super::observation::put_observation_head;
use super::outputs::{StepMark, put_command, put_event, put_step};
use super::*;
use rumbo_core::boundary::Buffer;
use rumbo_core::engine::{Event, EventKind, State};
use rumbo_core::messages::{Command, Data, LaserScan, Observation, ObservationKind, PointCloud, SensorId};
use rumbo_core::time::Time;
use std::io::Cursor;

/// A recording of `n` steps with a scan, a command and an event each.
fn recording(n: u64) -> Vec<u8> {
    let mut bag = BagWriter::new(Cursor::new(Vec::new())).unwrap();
    let mut cdr = CdrWriter::default();
    put_header(&mut cdr, &RunHeader { program: "test".into(), ..RunHeader::default() });
    let run = bag.topic("/rumbo/run", &RUN).unwrap();
    bag.write(run, Time::ZERO, cdr.bytes()).unwrap();
    let topic = bag.topic("/rumbo/step", &PACKED_STEP).unwrap();
    let mut packer = StepPacker::default();
    for idx in 0..n {
        let now = Time::from_secs(idx as f64);
        let scan = scan(idx);
        let (message, readings) = copy_of(&scan);
        let viewers = bag.topic("/sensor/eyes", &ros::layout::LASER_SCAN).unwrap();
        bag.write(viewers, now, &message).unwrap();
        let copy = ViewerCopy { number: 0, start: readings.start, len: readings.len() };
        bag.write_with(topic, now, |out| {
            put_observation_head(&mut cdr, &scan);
            let said = Said::Observation(SensorId(0), ObservationKind::LaserScan);
            packer.add(said, cdr.bytes(), Some(copy), out);
            put_command(&mut cdr, &Command { stamp: now, ..Command::default() }, true);
            packer.add(Said::Command, cdr.bytes(), None, out);
            put_event(&mut cdr, &Event { stamp: now, kind: EventKind::TimedOut });
            packer.add(Said::Event, cdr.bytes(), None, out);
            put_step(&mut cdr, &StepMark { step: idx, now, truth: None }, State::Waiting);
            packer.add(Said::Step, cdr.bytes(), None, out);
            packer.finish(out);
        })
        .unwrap();
        bag.rest(now).unwrap();
    }
    put_end(&mut cdr, "arrived", "");
    let end = bag.topic("/rumbo/end", &END).unwrap();
    bag.write(end, Time::from_secs(n as f64), cdr.bytes()).unwrap();
    bag.finish().unwrap().into_inner()
}

/// A scan with ranges that no rounding survives, and with a not-a-number of its own.
fn scan(idx: u64) -> Observation {
    let odd = f32::from_bits(0x7f80_0001 + idx as u32);
    let ranges_m = [0.1f32, odd, f32::INFINITY, idx as f32].as_slice().into();
    let data = Data::LaserScan(LaserScan { ranges_m, ..LaserScan::default() });
    seen(Time(idx as i64), data)
}

fn seen(stamp: Time, data: Data) -> Observation {
    let base_from_sensor = pose::pose3_of([0.1, 0.2, 0.3, 0.5, -0.5, 0.5, 0.5]);
    Observation { sensor: SensorId(0), stamp, base_from_sensor, valid: true, data }
}

/// What viewers get of it, and where its readings are.
fn copy_of(observation: &Observation) -> (Vec<u8>, std::ops::Range<usize>) {
    let mut cdr = CdrWriter::default();
    let at = ros::Stamped { stamp: observation.stamp, frame: "eyes" };
    let readings = match &observation.data {
        Data::LaserScan(scan) => ros::put_scan(&mut cdr, at, scan),
        Data::PointCloud(cloud) => ros::put_cloud(&mut cdr, at, cloud),
        other => panic!("{other:?}"),
    };
    (cdr.bytes().to_vec(), readings)
}

fn open(bytes: &[u8]) -> Result<RecordingReader, RecordingError> {
    let bag = BagReader::new(Box::new(Cursor::new(bytes.to_vec())), "a.mcap".into())?;
    RecordingReader::new(bag)
}

#[test]
fn a_file_that_is_cut_at_any_byte_gives_every_step_before_the_cut() {
    let whole = recording(12);
    let mut most = 0;
    for len in 0..=whole.len() {
        let mut reader = match open(&whole[..len]) {
            Ok(reader) => reader,
            Err(error) => {
                assert_eq!(most, 0, "cut at {len}: {error}");
                continue;
            }
        };
        let mut n_steps = 0;
        while let Some(step) = reader.next_step() {
            assert_eq!(step.mark.unwrap().step, n_steps, "cut at {len}");
            assert_eq!((step.messages.len(), step.events.len(), step.is_actuated), (4, 1, Some(true)));
            let mut cdr = CdrWriter::default();
            put_observation(&mut cdr, &scan(n_steps));
            assert_eq!(step.messages[0].data, cdr.bytes(), "cut at {len}");
            n_steps += 1;
        }
        assert!(n_steps >= most, "cut at {len}: {n_steps} steps, {most} before");
        most = n_steps;
        let is_whole = reader.run_end().is_some();
        let damage = reader.damage();
        assert!(is_whole || damage.as_deref() == Some("the file is cut off"), "cut at {len}: {damage:?}");
    }
    assert_eq!(most, 12);
}

#[test]
fn any_single_damaged_byte_is_an_end_or_a_fault_and_never_a_panic() {
    let whole = recording(4);
    for place in MAGIC.len()..whole.len() {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x5a;
        let Ok(mut reader) = open(&bytes) else { continue };
        while reader.next_step().is_some() {}
        let _ = reader.damage();
    }
}

#[test]
fn what_is_no_recording_of_ours_is_told_apart() {
    let told = |bytes: &[u8]| open(bytes).err().unwrap().to_string();
    assert_eq!(
        told(b""),
        "a.mcap: this is no MCAP file: it begins with nothing, expected the MCAP magic bytes"
    );
    assert!(told(b"# pipeline\n").contains("begins with [23, 20"));
    let mut bag = BagWriter::new(Cursor::new(Vec::new())).unwrap();
    let topic = bag.topic("/log", &ros::layout::LOG).unwrap();
    let mut cdr = CdrWriter::default();
    ros::put_log(&mut cdr, Time::ZERO, false, "hello");
    bag.write(topic, Time::ZERO, cdr.bytes()).unwrap();
    let other = bag.finish().unwrap().into_inner();
    assert!(told(&other).ends_with("its first message is a rcl_interfaces/msg/Log on /log"));
    let mut later = recording(0);
    let at = later.windows(8).position(|w| w == [0, 1, 0, 0, SCHEMA as u8, 0, 0, 0]).unwrap();
    later[at + 4] = 9;
    assert_eq!(
        told(&later),
        "a.mcap: the recording has schema 9, this program reads up to 2; use a newer rumbo"
    );
}

#[test]
fn the_same_messages_make_the_same_bytes() {
    assert_eq!(recording(5), recording(5));
}

/// Packs a message that refers to a copy and unpacks it with what is left of the copies.
fn through(
    observation: &Observation,
    copies: impl Fn(Vec<u8>) -> Vec<Vec<u8>>,
) -> Result<(usize, bool), CdrError> {
    let (mut packer, mut cdr, mut packed) =
        (StepPacker::default(), CdrWriter::default(), CdrWriter::default());
    put_observation_head(&mut cdr, observation);
    let (message, readings) = copy_of(observation);
    let said = Said::Observation(observation.sensor, observation.data.kind());
    let copy = ViewerCopy { number: 0, start: readings.start, len: readings.len() };
    packer.add(said, cdr.bytes(), Some(copy), &mut packed);
    packer.finish(&mut packed);
    put_observation(&mut cdr, observation);
    let mut same = false;
    let octets = CdrReader::new(packed.bytes()).unwrap().octets().unwrap();
    StepUnpacker::default().unpack(octets, &copies(message.clone()), |found, bytes| {
        same = (found, bytes.as_slice()) == (said, cdr.bytes());
        Ok(())
    })?;
    Ok((octets.len(), same))
}

#[test]
fn ranges_and_points_are_taken_from_the_copy_for_viewers_to_the_bit() {
    let points_m: Buffer<[f32; 3]> = vec![[1.0, f32::from_bits(0x7fc0_0123), -0.0]; 1000].into();
    let cloud = seen(Time(1), Data::PointCloud(PointCloud { points_m }));
    let ranges_m: Buffer<f32> = vec![f32::from_bits(0xffc0_0001); 3001].into();
    let scan = seen(Time(1), Data::LaserScan(LaserScan { ranges_m, ..LaserScan::default() }));
    for observation in [cloud, scan] {
        let (n_bytes, same) = through(&observation, |copy| vec![copy]).unwrap();
        assert!(same && n_bytes < 200, "{n_bytes} bytes: {same}");
        let fault = through(&observation, |_| Vec::new()).unwrap_err().to_string();
        assert!(fault.starts_with("readings is not in the 0 messages for viewers of this step"), "{fault}");
        assert!(through(&observation, |copy| vec![copy[..100].to_vec()]).is_err());
    }
}

#[test]
fn another_reader_finds_everything_that_was_written_and_its_sums_are_right() {
    let bytes = recording(12);
    let read: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().collect::<Result<_, _>>().unwrap();
    assert_eq!(read.len(), 2 * 12 + 2);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let stats = summary.stats.as_ref().unwrap();
    let counts = (stats.message_count, stats.channel_count, stats.schema_count, stats.chunk_count);
    assert_eq!(counts, (26, 4, 4, summary.chunk_indexes.len() as u32));
    assert!(stats.chunk_count > 3, "{stats:?}");
    assert_eq!((stats.message_start_time, stats.message_end_time), (0, 12_000_000_000));
    let topics: Vec<&str> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
    assert_eq!(topics.len(), 4, "{topics:?}");
    let mut n_indexed = 0;
    for chunk in &summary.chunk_indexes {
        let indexes = summary.read_message_indexes(&bytes, chunk).unwrap();
        for (channel, places) in indexes {
            for place in places {
                let message = summary.seek_message(&bytes, chunk, &place).unwrap();
                assert_eq!((message.channel.id, message.log_time), (channel.id, place.log_time));
                n_indexed += 1;
            }
        }
    }
    assert_eq!(n_indexed, 26);
}

#[test]
fn a_message_that_nobody_writes_takes_no_place_and_no_number() {
    let bag = |is_said: bool| {
        let mut bag = BagWriter::new(Cursor::new(Vec::new())).unwrap();
        let topic = bag.topic("/log", &ros::layout::LOG).unwrap();
        for (now, text) in [(1, "first"), (2, "second")] {
            if is_said {
                bag.write_with(topic, Time(now), |_| {}).unwrap();
            }
            bag.write_with(topic, Time(now), |cdr| ros::put_log(cdr, Time(now), false, text)).unwrap();
        }
        bag.finish().unwrap().into_inner()
    };
    assert_eq!(bag(true), bag(false));
    let (bytes, mut cdr) = (bag(true), CdrWriter::default());
    let last = mcap::MessageStream::new(&bytes).unwrap().last().unwrap().unwrap();
    ros::put_log(&mut cdr, Time(2), false, "second");
    // Numbers are aligned to where the message begins, not to where it stands in the file.
    assert_eq!((last.sequence, last.data.as_ref()), (1, cdr.bytes()));
}

#[test]
fn a_map_is_hashed_anew_when_its_version_went_up() {
    let grid = rumbo_core::map::Grid::unknown(4, 4, 0.1).unwrap();
    let mut map = rumbo_core::map::Map { grid: Some(grid), ..Default::default() };
    let mut encoder = StepEncoder::default();
    let mut hash = |map: &rumbo_core::map::Map| {
        let (mut told, mut expected) = (Vec::new(), CdrWriter::default());
        encoder.map(map, &mut |_, message| told = message.to_vec());
        put_map_hash(&mut expected, map);
        assert_eq!(told, expected.bytes());
        told
    };
    let before = hash(&map);
    assert_eq!(hash(&map), before);
    map.grid.as_mut().unwrap().cells.make_mut()[3] = 1.0;
    map.touch();
    assert_ne!(hash(&map), before);
}

#[test]
fn a_bag_that_is_dropped_is_closed() {
    struct Shared(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);
    impl std::io::Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let written = std::sync::Arc::default();
    let mut bag = BagWriter::new(Shared(std::sync::Arc::clone(&written))).unwrap();
    let topic = bag.topic("/log", &ros::layout::LOG).unwrap();
    bag.write(topic, Time(5), &[0, 1, 0, 0]).unwrap();
    drop(bag);
    let bytes = written.lock().unwrap();
    assert_eq!(mcap::Summary::read(&bytes).unwrap().unwrap().stats.unwrap().message_count, 1);
}
