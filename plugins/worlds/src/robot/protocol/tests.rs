use rumbo_core::frames::Twist;
use rumbo_core::rng::{self, RngExt as _};
use rumbo_core::robot::DriveKind;
use rumbo_core::stages::WheelMotion;

use super::*;

fn from_base() -> Vec<FromBase> {
    let wheels = WheelMotion {
        rolled_m: [1.234567, -0.000001, 0.0, 0.0],
        n_wheels: 2,
        turned_rad: -3.25,
        steering_rad: 0.5,
        twist: Twist { forward_m_s: 0.2, left_m_s: 0.0, turn_rad_s: -0.125 },
    };
    let ring = SonarGeometry {
        n_sonars: 16,
        first_bearing_rad: 0.0,
        bearing_step_rad: 0.4,
        cone_rad: 0.436332,
        ring_radius_m: 0.2,
        min_range_m: 0.15,
        max_range_m: 6.5,
    };
    let identity = BaseIdentity {
        version: 1,
        boot: 77,
        drive: DriveKind::Differential,
        track_m: 0.36,
        watchdog_s: 0.5,
        name: "SCOUT-2".to_owned(),
    };
    let status = BaseStatus {
        at_ms: 99,
        battery_mv: 12_600,
        is_battery_low: false,
        is_emergency: true,
        is_watchdog: false,
        last_command: 65_535,
    };
    let readings = vec![SonarReading::Echo(1234), SonarReading::Nothing, SonarReading::Lost];
    vec![
        FromBase::Base(identity),
        FromBase::Sonars(ring),
        FromBase::Bumpers(BumperGeometry { n_bumpers: 16, first_bearing_rad: 0.0, bearing_step_rad: 0.4 }),
        FromBase::No { version: 2 },
        FromBase::Wheels(WheelReport { at_ms: u32::MAX, wheels }),
        FromBase::Ranges { at_ms: 5, readings },
        FromBase::Touch { at_ms: 6, pressed: 0x8001 },
        FromBase::State(status),
        FromBase::Bye,
    ]
}

fn to_base() -> Vec<ToBase> {
    let twist = Twist { forward_m_s: -0.2, left_m_s: 0.000001, turn_rad_s: 0.148 };
    vec![ToBase::Hello { version: 1 }, ToBase::Drive(twist), ToBase::Bye]
}

/// Lines as the document shows them.
#[test]
fn lines_are_what_the_document_shows() {
    let document = include_str!("../../../../../docs/base-protocol.md");
    let shown: Vec<&str> =
        document.lines().filter(|line| line.starts_with('~') && !line.starts_with("~NUMBER")).collect();
    assert!(shown.len() >= 12, "{shown:?}");
    for line in shown {
        let mut decoder = Decoder::default();
        let frame = line.bytes().chain(*b"\n").find_map(|byte| decoder.push(byte));
        let frame = frame.unwrap_or_else(|| panic!("{line} has a wrong checksum"));
        let (to, from) = (ToBase::parse(&frame.text), FromBase::parse(&frame.text));
        let again = to.as_ref().map(|to| to.to_string()).or(from.as_ref().map(|from| from.to_string()));
        assert_eq!(again.as_deref(), Ok(frame.text.as_str()), "{line}");
    }
}

#[test]
fn every_line_comes_back_as_it_was_said() {
    for (number, said) in (65_500u16..).zip(from_base()) {
        let frame = only_frame(&encode(number, &said.to_string())).unwrap();
        assert_eq!((frame.number, FromBase::parse(&frame.text)), (number, Ok(said)));
    }
    for said in to_base() {
        let frame = only_frame(&encode(3, &said.to_string())).unwrap();
        assert_eq!(ToBase::parse(&frame.text), Ok(said));
    }
}

fn frames(bytes: &[u8]) -> (Vec<Frame>, Tally) {
    let mut decoder = Decoder::default();
    let frames = bytes.iter().filter_map(|byte| decoder.push(*byte)).collect();
    (frames, decoder.tally())
}

fn only_frame(bytes: &[u8]) -> Option<Frame> {
    frames(bytes).0.into_iter().next()
}

/// In the line before, the damaged one, and the one behind it.
#[test]
fn a_line_with_one_flipped_bit_is_rejected_and_its_neighbors_are_not() {
    let mut texts: Vec<String> = from_base().iter().map(FromBase::to_string).collect();
    texts.extend(to_base().iter().map(ToBase::to_string));
    let mut n_flips = 0;
    for text in texts {
        let (before, line, behind) = (encode(1, "BYE"), encode(2, &text), encode(3, "HELLO 1"));
        for bit in 0..line.len() * 8 {
            let mut damaged = line.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            let (found, tally) = frames(&[before.clone(), damaged, behind.clone()].concat());
            let numbers: Vec<u16> = found.iter().map(|frame| frame.number).collect();
            assert_eq!(numbers, [1, 3], "bit {bit} of {text}");
            assert_eq!((tally.n_missed, tally.n_rejected >= 1), (1, true), "bit {bit} of {text}");
            n_flips += 1;
        }
    }
    assert!(n_flips > 2900, "{n_flips}");
}

/// Any one byte, or any stretch of bytes.
#[test]
fn lost_bytes_cost_their_own_line_and_a_lost_line_feed_no_other() {
    let (line, behind) = (encode(2, &from_base()[4].to_string()), encode(3, "BYE"));
    for first in 0..line.len() {
        for last in first..line.len() {
            let mut cut = line.clone();
            cut.drain(first..=last);
            let (found, _) = frames(&[cut, behind.clone()].concat());
            let numbers: Vec<u16> = found.iter().map(|frame| frame.number).collect();
            assert_eq!(numbers, [3], "without {first} to {last}");
        }
    }
}

#[test]
fn nothing_is_found_in_garbage_and_lines_behind_it_are() {
    let mut rng = rng::stream(4, "garbage");
    let mut decoder = Decoder::default();
    for round in 0..2000 {
        let garbage: Vec<u8> = (0..rng.random_range(0..1200)).map(|_| rng.random()).collect();
        let invented = garbage.iter().filter_map(|byte| decoder.push(*byte)).count();
        assert_eq!(invented, 0, "round {round}");
        // What has begun ends at the next line feed or start.
        let found: Vec<Frame> = encode(round, "BYE").iter().filter_map(|byte| decoder.push(*byte)).collect();
        assert_eq!(found, [Frame { number: round, text: "BYE".to_owned() }]);
    }
}

#[test]
fn lines_with_a_right_checksum_and_a_wrong_meaning_are_refused() {
    for text in [
        "",
        "WHEELS 1 2 3",
        "WHEELS 1 2 3 4 5 6 7 8 9",
        "WHEELS -1 2 3 4 5 6 7 8",
        "WHEELS 1 2.5 3 4 5 6 7 8",
        "BASE 1 1 LEGS 0 500 X",
        "SONARS 65 0 0 0 0 0 0",
        "RANGES 1 5 Y",
        "TOUCH 1 G",
        "TOUCH 1 10000000000000000",
        "STATE 1 2 3 0 0 0",
        "NO 65536",
        "LATER 1",
    ] {
        assert!(FromBase::parse(text).is_err(), "{text}");
    }
    for text in ["HELLO", "HELLO 1 2", "HELLO X", "DRIVE 1 2", "DRIVE 1 2 3 4", "STOP"] {
        assert!(ToBase::parse(text).is_err(), "{text}");
    }
    let too_many = format!("RANGES 1{}", " 5".repeat(65));
    assert!(FromBase::parse(&too_many).is_err());
    let longest = format!("RANGES {}{}", u32::MAX, " 65535".repeat(64));
    assert!(encode(65_535, &longest).len() <= MOST_LINE);
}
