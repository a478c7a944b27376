use rumbo_core::time::Span;

use super::*;
use crate::lms200::protocol::{CountUnit, Decoder, FACTORY_PASSWORD, Measured, MeasuringMode, Mode, Token};

fn device() -> Emulator {
    Emulator::new(Box::new(|_, _| Some((2.0, 5))), Faults::none(1), Time::ZERO)
}

/// Says something and listens for a while.
fn ask(device: &mut Emulator, now: &mut Time, command: &Command) -> Vec<Token> {
    tell(device, now, &command.to_bytes())
}

fn tell(device: &mut Emulator, now: &mut Time, bytes: &[u8]) -> Vec<Token> {
    let speed = device.speed();
    let mut heard = Vec::new();
    *now = *now + Span::from_secs(1.0);
    device.transmit(*now, speed, &mut Vec::new());
    device.receive(*now, speed, bytes);
    for _ in 0..2 {
        *now = *now + Span::from_secs(0.5);
        device.transmit(*now, speed, &mut heard);
    }
    let mut decoder = Decoder::default();
    decoder.push(&heard);
    std::iter::from_fn(|| decoder.next()).collect()
}

fn answer(tokens: &[Token]) -> Reply {
    let [Token::Ack, Token::Frame(payload)] = tokens else { panic!("{tokens:?}") };
    Telegram::of_payload(payload).unwrap().reply
}

#[test]
fn commands_are_answered_as_the_listing_has_it() {
    let (mut device, mut now) = (device(), Time::ZERO);
    let switched = |tokens: &[Token]| answer(tokens) == Reply::ModeSwitched(0);
    let factory = device.configuration().clone();
    let millimeters = factory.with(CountUnit::Millimeters, MeasuringMode::Reflector8);
    let write = Command::WriteConfiguration(millimeters.clone());
    assert_eq!(
        answer(&ask(&mut device, &mut now, &Command::ReadConfiguration)),
        Reply::Configuration(factory)
    );
    assert_eq!(answer(&ask(&mut device, &mut now, &write)), Reply::NotAccepted);
    let wrong = Command::Switch(Mode::Installation(*b"PASSWORD"));
    assert_eq!(answer(&ask(&mut device, &mut now, &wrong)), Reply::ModeSwitched(1));
    assert!(switched(&ask(&mut device, &mut now, &Command::Switch(Mode::Installation(FACTORY_PASSWORD)))));
    assert_eq!(answer(&ask(&mut device, &mut now, &write)), Reply::ConfigurationWritten(true, millimeters));
    assert_eq!(answer(&ask(&mut device, &mut now, &Command::OneScan)), Reply::NotAccepted);
    assert!(switched(&ask(&mut device, &mut now, &Command::Switch(Mode::OnRequest))));
    let Reply::Scan(Measured { words, unit, .. }) = answer(&ask(&mut device, &mut now, &Command::OneScan))
    else {
        panic!()
    };
    assert_eq!((words.len(), words[7], unit), (361, 2000 | 5 << 13, CountUnit::Millimeters));
    let part = IndexRange { first: 2, last: 4 };
    let Reply::Part(_, measured) = answer(&ask(&mut device, &mut now, &Command::Part(part))) else {
        panic!()
    };
    assert_eq!(measured.words.len(), 3);
    let Reply::Mean(4, mean) = answer(&ask(&mut device, &mut now, &Command::Mean(4))) else { panic!() };
    assert_eq!((mean.words.len(), mean.words[0]), (361, 2000));
    let refused = Variant { field_deg: 180, resolution_centideg: 25 };
    let refused = answer(&ask(&mut device, &mut now, &Command::Variant(refused)));
    assert_eq!(refused, Reply::Variant(false, FIRST_VARIANT));
    for variant in Variant::OFFERED {
        let reply = answer(&ask(&mut device, &mut now, &Command::Variant(variant)));
        assert_eq!(reply, Reply::Variant(true, variant));
    }
}

/// The status report of a device in millimeters at 9600 baud, byte for byte.
#[test]
fn the_status_report_is_that_of_the_vectors() {
    let (mut device, mut now) = (device(), Time::ZERO);
    device.configuration = device.configuration.with(CountUnit::Millimeters, MeasuringMode::FieldsAbDazzle);
    let tokens = ask(&mut device, &mut now, &Command::Status);
    let vectors = include_str!("../../../tests/data/lms200_telegrams.toml");
    let vectors: toml::Table = toml::from_str(vectors).unwrap();
    let telegrams = vectors["telegram"].as_array().unwrap();
    let status = telegrams.iter().find(|t| t["name"].as_str().unwrap().starts_with("status answer")).unwrap();
    let expected: Vec<u8> = status["payload"]
        .as_str()
        .unwrap()
        .split(' ')
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect();
    assert_eq!(tokens, [Token::Ack, Token::Frame(expected)]);
}

#[test]
fn damaged_telegrams_are_refused_and_those_of_others_not_heeded() {
    let (mut device, mut now) = (device(), Time::ZERO);
    assert_eq!(tell(&mut device, &mut now, &[0x02, 0x00, 0x01, 0x00, 0x31, 0x15, 0x13]), [Token::Nak]);
    assert_eq!(tell(&mut device, &mut now, &[0x02, 0x00, 0x00, 0x00]), [Token::Nak]);
    assert_eq!(tell(&mut device, &mut now, &[0x02, 0x00, 0x2D, 0x03]), [Token::Nak]);
    assert_eq!(tell(&mut device, &mut now, &[0x02, 0x00, 0x01]), [Token::Nak], "a gap inside the telegram");
    assert_eq!(tell(&mut device, &mut now, &[0x55, 0x06, 0x15]), []);
    let other = crate::lms200::protocol::encode(0x03, &[0x31]);
    assert_eq!(tell(&mut device, &mut now, &other), []);
    device.faults.n_naks = 1;
    assert_eq!(ask(&mut device, &mut now, &Command::Type), [Token::Nak]);
    assert_eq!(answer(&ask(&mut device, &mut now, &Command::Type)), Reply::Type(answers::TYPE.to_owned()));
    // At another speed there is nothing to understand.
    device.receive(now, LineSpeed::Baud38400, &Command::Type.to_bytes());
    let mut heard = Vec::new();
    device.transmit(now + Span::from_secs(1.0), LineSpeed::Baud9600, &mut heard);
    assert!(heard.is_empty());
}

/// Scans in ten seconds of continuous output: what the line lets through, and no more than the mirror gives.
#[test]
fn the_line_limits_how_many_scans_come() {
    for (speed, variant, per_second) in [
        (LineSpeed::Baud9600, Variant { field_deg: 180, resolution_centideg: 50 }, 1.31),
        (LineSpeed::Baud38400, Variant { field_deg: 180, resolution_centideg: 50 }, 5.25),
        (LineSpeed::Baud38400, Variant { field_deg: 180, resolution_centideg: 100 }, 10.32),
        (LineSpeed::Baud38400, Variant { field_deg: 100, resolution_centideg: 25 }, 4.73),
        (LineSpeed::Baud500000, Variant { field_deg: 180, resolution_centideg: 50 }, 37.5),
        (LineSpeed::Baud500000, Variant { field_deg: 180, resolution_centideg: 100 }, 75.0),
        (LineSpeed::Baud500000, Variant { field_deg: 100, resolution_centideg: 25 }, 18.75),
    ] {
        let (mut device, mut now) = (device(), Time::ZERO);
        ask(&mut device, &mut now, &Command::Variant(variant));
        ask(&mut device, &mut now, &Command::Switch(Mode::Speed(speed)));
        ask(&mut device, &mut now, &Command::Switch(Mode::Continuous));
        let before = device.n_whole_scans();
        let mut bytes = Vec::new();
        for _ in 0..10_000 {
            now = now + Span(1_000_000);
            device.transmit(now, speed, &mut bytes);
        }
        let found = (device.n_whole_scans() - before) as f64 / 10.0;
        assert!((found - per_second).abs() <= 0.11, "{speed:?} {variant:?}: {found} instead of {per_second}");
    }
}

#[test]
fn partial_scans_are_numbered_and_every_turn_is_one() {
    let (mut device, mut now) = (device(), Time::ZERO);
    ask(&mut device, &mut now, &Command::Switch(Mode::Speed(LineSpeed::Baud500000)));
    let tokens = ask(&mut device, &mut now, &Command::Switch(Mode::Partials));
    let scans: Vec<Measured> = tokens
        .iter()
        .filter_map(|token| match token {
            Token::Frame(payload) => match Telegram::of_payload(payload).unwrap().reply {
                Reply::Scan(measured) => Some(measured),
                _ => None,
            },
            _ => None,
        })
        .collect();
    assert!((73..=75).contains(&scans.len()), "{}", scans.len());
    for (idx, scan) in scans.iter().enumerate() {
        assert_eq!(scan.partial, Some((idx % 4) as u8));
        assert_eq!(scan.words.len(), if idx % 4 == 0 { 181 } else { 180 });
    }
}
