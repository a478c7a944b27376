use super::cdr::CdrWriter;
use super::layout::{COMMAND, END, EVENT, RUN, SCHEMA, STEP};
use super::outputs::{StepMark, put_command, put_event, put_step};
use super::*;
use rumbo_core::engine::{Event, EventKind, State};
use rumbo_core::messages::Command;
use rumbo_core::time::Time;
use std::io::Cursor;

/// A recording of `n` steps with a command and an event each.
fn recording(n: u64) -> Vec<u8> {
    let mut bag = BagWriter::new(Cursor::new(Vec::new())).unwrap();
    let mut cdr = CdrWriter::default();
    put_header(&mut cdr, &RunHeader { program: "test".into(), ..RunHeader::default() });
    let run = bag.topic("/rumbo/run", &RUN).unwrap();
    bag.write(run, Time::ZERO, cdr.bytes()).unwrap();
    let [command, event, step] =
        [("/rumbo/command", &COMMAND), ("/rumbo/event", &EVENT), ("/rumbo/step", &STEP)]
            .map(|(topic, layout)| bag.topic(topic, layout).unwrap());
    for idx in 0..n {
        let now = Time::from_secs(idx as f64);
        put_command(&mut cdr, &Command { stamp: now, ..Command::default() }, true);
        bag.write(command, now, cdr.bytes()).unwrap();
        put_event(&mut cdr, &Event { stamp: now, kind: EventKind::TimedOut });
        bag.write(event, now, cdr.bytes()).unwrap();
        put_step(&mut cdr, &StepMark { step: idx, now, truth: None }, State::Waiting);
        bag.write(step, now, cdr.bytes()).unwrap();
        bag.rest(now).unwrap();
    }
    put_end(&mut cdr, "arrived", "");
    let end = bag.topic("/rumbo/end", &END).unwrap();
    bag.write(end, Time::from_secs(n as f64), cdr.bytes()).unwrap();
    bag.finish().unwrap().into_inner()
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
            assert_eq!((step.messages.len(), step.events.len(), step.is_actuated), (3, 1, Some(true)));
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
