mod stream;
mod vectors;

use super::*;

fn bytes_of(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

/// A scan of `n` values in millimeters.
fn scan(n: u16, value: impl Fn(u16) -> u16) -> Vec<u8> {
    let words = (0..n).map(value).collect();
    let measured = Measured { unit: CountUnit::Millimeters, partial: None, words, indices: None };
    Telegram { reply: Reply::Scan(measured), status: StatusByte::HEALTHY }.to_bytes()
}

/// Mode, bits, a value, its flags and its distance.
#[test]
fn values_are_shared_between_distance_and_flags_as_the_mode_has_it() {
    use MeasuringMode::*;
    for (mode, bits, word, flags, count) in [
        (FieldsAbDazzle, 13, 0xA3E8, 0b101, 1000),
        (Reflector8, 13, 0xE3E8, 7, 1000),
        (FieldsAbc, 13, 0x43E8, 0b010, 1000),
        (Reflector4, 14, 0xF3E8, 3, 0x33E8),
        (FieldsAb, 14, 0x83E8, 0b10, 1000),
        (Reflector2, 15, 0xC3E8, 1, 0x43E8),
        (FieldA, 15, 0x83E8, 1, 1000),
        (Distance, 16, 0xC3E8, 0, 0xC3E8),
    ] {
        assert_eq!((mode.distance_bits(), mode.flags(word)), (bits, flags), "{mode:?}");
        assert_eq!(mode.reading(word), Reading::Count(count), "{mode:?}");
        assert_eq!(mode.word(Some(count), flags), word, "{mode:?}");
        assert_eq!(MeasuringMode::of_code(mode.code()), Some(mode));
        let top = (u32::from(u16::MAX) >> (16 - bits)) as u16;
        assert_eq!(mode.reading(top - 9), Reading::Count(top - 9));
        for (below_top, reading) in [
            (8, Reading::NothingWithinReach),
            (7, Reading::Reserved),
            (6, Reading::Reserved),
            (5, Reading::ChannelError),
            (4, Reading::WeakSignal),
            (3, Reading::Reserved),
            (2, Reading::Overflow),
            (1, Reading::Dazzled),
            (0, Reading::NotValid),
        ] {
            assert_eq!(mode.reading(mode.word(Some(5), flags) - 5 + (top - below_top)), reading, "{mode:?}");
        }
        assert_eq!(mode.reading(mode.word(None, flags)), Reading::NothingWithinReach);
    }
    assert_eq!(FieldsAbDazzle.reading(0x1FF7), Reading::NothingWithinReach);
    assert_eq!(FieldsAb.reading(0x3FF7), Reading::NothingWithinReach);
    assert_eq!(FieldA.reading(0x7FF7), Reading::NothingWithinReach);
    assert_eq!(Reflectivity.distance_bits(), 0);
    assert_eq!(MeasuringMode::of_code(7), None);
}

#[test]
fn a_scan_with_indices_is_known_by_its_length_and_other_lengths_are_refused() {
    let mut measured = Measured {
        unit: CountUnit::Decimeters,
        partial: Some(3),
        words: vec![1, 2, 3],
        indices: Some(Indices { scan: 7, telegram: 9 }),
    };
    for indices in [measured.indices, None] {
        measured.indices = indices;
        let telegram = Telegram { reply: Reply::Scan(measured.clone()), status: StatusByte(0x12) };
        assert_eq!(Telegram::of_payload(&telegram.payload()), Ok(telegram));
    }
    let payload = Telegram { reply: Reply::Scan(measured), status: StatusByte(0x10) }.payload();
    for cut in 1..payload.len() {
        let mut short = payload[..payload.len() - cut].to_vec();
        short.push(0x10);
        // One byte less and the status in its place is the same telegram.
        if cut > 1 {
            assert!(Telegram::of_payload(&short).is_err(), "cut by {cut}");
        }
    }
    let mut long = payload.clone();
    long.push(0x10);
    assert_eq!(Telegram::of_payload(&long), Err(BadTelegram::Length));
    let no_unit = [0xB0, 0x00, 0xC0, 0x10];
    assert_eq!(Telegram::of_payload(&no_unit), Err(BadTelegram::Unit));
    assert_eq!(Telegram::of_payload(&[0x10]), Err(BadTelegram::Length));
    assert_eq!(Telegram::of_payload(&[]), Err(BadTelegram::Length));
    assert_eq!(Telegram::of_payload(&[0x42, 0x10]), Err(BadTelegram::Code(0x42)));
}

#[test]
fn the_status_byte_says_how_bad_it_is() {
    let healthy = StatusByte::HEALTHY;
    assert_eq!((healthy.severity(), healthy.family()), (Severity::Fine, 2));
    assert!(!healthy.has_restarted() && !healthy.is_implausible() && !healthy.is_polluted());
    assert_eq!(StatusByte(0x13).severity(), Severity::Error);
    assert_eq!(StatusByte(0x14).severity(), Severity::Fatal);
    assert!(StatusByte(0x30).has_restarted());
    assert!(StatusByte(0x50).is_implausible());
    assert!(StatusByte(0x90).is_polluted());
}

#[test]
fn a_configuration_keeps_its_length_and_all_other_bytes() {
    let old: Vec<u8> = (0..32).collect();
    let new = Configuration::of_bytes(&old).unwrap().with(CountUnit::Centimeters, MeasuringMode::FieldA);
    assert_eq!(
        (new.unit(), new.measuring_mode()),
        (Some(CountUnit::Centimeters), Some(MeasuringMode::FieldA))
    );
    assert_eq!((new.bytes().len(), new.bytes()[5], new.bytes()[6]), (32, 6, 0));
    assert!(new.bytes().iter().zip(&old).enumerate().all(|(idx, (a, b))| a == b || [5, 6].contains(&idx)));
    assert_eq!(Configuration::of_bytes(&old[..6]), None);
}

/// Lengths and times of the listing's table.
#[test]
fn lines_take_as_long_as_ten_bits_a_byte() {
    for (n_bytes, ms) in [
        (372, [387.5, 96.9, 193.8, 7.4]),
        (732, [762.5, 190.6, 381.3, 14.6]),
        (812, [845.8, 211.5, 422.9, 16.2]),
    ] {
        for (speed, ms) in LineSpeed::ALL.into_iter().zip(ms) {
            assert!((speed.time_of(n_bytes).as_secs() * 1000.0 - ms).abs() < 0.051, "{n_bytes} at {speed:?}");
        }
    }
    let n_values: Vec<usize> = Variant::OFFERED.iter().map(|variant| variant.n_values()).collect();
    assert_eq!(n_values, [101, 201, 401, 181, 361]);
    let n_turns: Vec<u32> = Variant::OFFERED.iter().map(|variant| variant.n_turns()).collect();
    assert_eq!(n_turns, [1, 2, 4, 1, 2]);
}
