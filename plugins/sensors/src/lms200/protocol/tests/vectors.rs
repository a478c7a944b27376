//! The published telegrams, and others made with the same checksum.

use super::*;

#[derive(serde::Deserialize)]
struct Vectors {
    telegram: Vec<Whole>,
    checksum: Vec<Sum>,
    scan_telegram: Vec<Ends>,
}

#[derive(serde::Deserialize)]
struct Whole {
    name: String,
    direction: String,
    payload: String,
    length_field: u16,
    crc: u16,
    bytes: String,
}

#[derive(serde::Deserialize)]
struct Sum {
    input: String,
    crc: u16,
}

#[derive(serde::Deserialize)]
struct Ends {
    name: String,
    values: u16,
    value_rule: String,
    length_field: u16,
    total_bytes: usize,
    first_bytes: String,
    last_bytes: String,
    crc: u16,
}

fn vectors() -> Vectors {
    toml::from_str(include_str!("../../../../tests/data/lms200_telegrams.toml")).unwrap()
}

#[test]
fn checksums_are_those_of_the_listing() {
    let sums = vectors().checksum;
    assert_eq!(sums.len(), 5);
    for Sum { input, crc } in sums {
        assert_eq!(checksum(&bytes_of(&input)), crc, "{input}");
    }
}

/// Bytes to meaning and back to the same bytes.
#[test]
fn every_published_telegram_is_read_and_written() {
    let telegrams = vectors().telegram;
    assert_eq!(telegrams.len(), 44);
    for Whole { name, direction, payload, length_field, crc, bytes } in telegrams {
        let (payload, bytes) = (bytes_of(&payload), bytes_of(&bytes));
        assert_eq!(usize::from(length_field), payload.len(), "{name}");
        assert_eq!(checksum(&bytes[..bytes.len() - 2]), crc, "{name}");
        if direction == "host" {
            let command = Command::of_payload(&payload).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(command.to_bytes(), bytes, "{name}");
        } else {
            let mut decoder = Decoder::default();
            decoder.push(&bytes);
            assert_eq!(decoder.next(), Some(Token::Frame(payload.clone())), "{name}");
            assert_eq!((decoder.next(), decoder.is_amid_frame()), (None, false));
            let telegram = Telegram::of_payload(&payload).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(telegram.to_bytes(), bytes, "{name}");
        }
    }
}

#[test]
fn telegrams_mean_what_the_listing_says() {
    let reply = |name: &str| {
        let vectors = vectors().telegram;
        let found = vectors.iter().find(|telegram| telegram.name.starts_with(name)).unwrap();
        Telegram::of_payload(&bytes_of(&found.payload)).unwrap()
    };
    assert_eq!(reply("power-on message").reply, Reply::PowerOn("LMS200;301063;V02.30 ".to_owned()));
    assert_eq!(reply("mode switch refused: wrong password").reply, Reply::ModeSwitched(1));
    let fault = reply("mode switch refused: device fault");
    assert_eq!((fault.reply, fault.status.severity()), (Reply::ModeSwitched(2), Severity::Error));
    assert_eq!(reply("no errors stored").reply, Reply::Errors(Vec::new()));
    assert_eq!(
        reply("variant refused").reply,
        Reply::Variant(false, Variant { field_deg: 180, resolution_centideg: 50 })
    );
    let Reply::Status(report) = reply("status answer").reply else { panic!() };
    assert_eq!(report.version().as_deref(), Some("V02.30"));
    assert_eq!((report.mode_code(), report.is_defective()), (Some(0x25), Some(false)));
    assert_eq!(report.variant(), Some(Variant { field_deg: 180, resolution_centideg: 50 }));
    assert_eq!((report.speed(), report.unit_code()), (Some(LineSpeed::Baud9600), Some(1)));
    assert_eq!(report.measuring_mode(), Some(MeasuringMode::FieldsAbDazzle));
    let Reply::ConfigurationWritten(true, written) = reply("write configuration accepted").reply else {
        panic!()
    };
    assert_eq!(written.unit(), Some(CountUnit::Millimeters));
    assert!(!written.sends_indices());
    let Reply::Part(part, measured) = reply("sub-range answer").reply else { panic!() };
    assert_eq!((part, measured.unit), (IndexRange { first: 1, last: 5 }, CountUnit::Millimeters));
    let mode = MeasuringMode::FieldsAbDazzle;
    let readings: Vec<Reading> = measured.words.iter().map(|word| mode.reading(*word)).collect();
    let [a, b, c, d] = [1000, 1005, 1010, 1020].map(Reading::Count);
    assert_eq!(readings, [a, b, c, Reading::NothingWithinReach, d]);
    assert_eq!(mode.flags(measured.words[4]), 1);
}

#[test]
fn every_scan_telegram_has_its_ends_length_and_checksum() {
    let scans = vectors().scan_telegram;
    assert_eq!(scans.len(), 9);
    for vector in scans {
        let name = vector.name;
        let rule: Box<dyn Fn(u16) -> u16> = if name.contains("partial") {
            let partial = name.split(' ').nth(2).unwrap().parse::<u16>().unwrap();
            assert!(
                vector.value_rule.contains(&format!("{} + 4*i", 3000 + partial)),
                "{}",
                vector.value_rule
            );
            Box::new(move |i| 3000 + partial + 4 * i)
        } else if name.contains("reflector") {
            Box::new(|i| 1000 + i + 0x2000 * (i % 8))
        } else if vector.value_rule.contains("mod 8000") {
            Box::new(|i| (1000 + 7 * i) % 8000)
        } else if name.contains("centi") {
            Box::new(|i| 150 + i)
        } else {
            Box::new(|i| 2000 + i)
        };
        let unit = if name.contains("centi") { CountUnit::Centimeters } else { CountUnit::Millimeters };
        let partial = name.strip_prefix("partial scan ").map(|rest| rest.as_bytes()[0] - b'0');
        let words = (0..vector.values).map(rule).collect();
        let measured = Measured { unit, partial, words, indices: None };
        let telegram = Telegram { reply: Reply::Scan(measured), status: StatusByte::HEALTHY };
        let bytes = telegram.to_bytes();
        assert_eq!(bytes.len(), vector.total_bytes, "{name}");
        assert_eq!(bytes[2..4], vector.length_field.to_le_bytes(), "{name}");
        assert!(bytes.starts_with(&bytes_of(&vector.first_bytes)), "{name}: {:02X?}", &bytes[..13]);
        assert!(bytes.ends_with(&bytes_of(&vector.last_bytes)), "{name}");
        assert!(bytes.ends_with(&vector.crc.to_le_bytes()), "{name}");
        let mut decoder = Decoder::default();
        decoder.push(&bytes);
        let Some(Token::Frame(payload)) = decoder.next() else { panic!("{name}") };
        assert_eq!(Telegram::of_payload(&payload), Ok(telegram), "{name}");
    }
}

/// Commands that the vectors do not have.
#[test]
fn all_other_commands_come_back_as_they_went() {
    let part = IndexRange { first: 91, last: 271 };
    for command in [
        Command::Hours,
        Command::KeepSpeed(1),
        Command::Switch(Mode::SmallestValues(0x22)),
        Command::Switch(Mode::Means(10)),
        Command::Switch(Mode::MeansOfPart(10, part)),
        Command::Switch(Mode::PartWithFields(part)),
        Command::Switch(Mode::WithReflectivity(part)),
    ] {
        assert_eq!(Command::of_payload(&command.payload()), Some(command));
    }
    for wrong in
        ["", "11", "20", "20 43", "20 24 00", "20 00 53", "36 01", "37 01 00", "3B B4 00 64", "77 00"]
    {
        assert_eq!(Command::of_payload(&bytes_of(wrong)), None, "{wrong}");
    }
}
