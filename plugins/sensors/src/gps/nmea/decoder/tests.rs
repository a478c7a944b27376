//! The sentences of the literature, a twin that sees the whole stream at once, and everything that is no sentence.

use rumbo_core::rng::{self, Rng, RngExt as _};

use super::super::{Axis, Sentence, checksum, degrees, utc_s};
use super::*;

const VECTORS: &str = include_str!("../../../../tests/data/dc_serial_lines.toml");

pub(crate) fn vectors() -> toml::Table {
    toml::from_str(VECTORS).unwrap()
}

fn hear(bytes: &[u8]) -> Vec<Heard> {
    let mut decoder = Decoder::default();
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next()).collect()
}

fn only(line: &str) -> Heard {
    let heard = hear(format!("{line}\r\n").as_bytes());
    assert_eq!(heard.len(), 1, "{line}");
    heard[0].clone()
}

fn is_near(found: Option<f64>, case: &toml::Value, key: &str) {
    let expected = case.get(key).map(|value| value.as_float().unwrap());
    match (found, expected) {
        (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-8, "{key} of {case}: {found}"),
        // What the case does not say it does not judge.
        (_, None) => {}
        other => panic!("{key} of {case}: {other:?}"),
    }
}

fn is_gga_of(gga: &Gga, case: &toml::Value) {
    let Gga::Fix(fix) = gga else {
        return assert_eq!(case["fix"].as_bool(), Some(false), "{case}");
    };
    is_near(fix.utc_s, case, "utc_s");
    is_near(Some(fix.latitude_deg), case, "latitude_deg");
    is_near(Some(fix.longitude_deg), case, "longitude_deg");
    is_near(fix.hdop, case, "hdop");
    is_near(fix.altitude_m, case, "altitude_m");
    is_near(fix.geoid_separation_m, case, "geoid_separation_m");
    assert_eq!(i64::from(fix.quality), case["quality"].as_integer().unwrap());
    assert_eq!(fix.satellites.map(i64::from), case["satellites"].as_integer());
}

/// Only GGA is used, but angles and times of RMC are written alike.
fn is_rmc_of(line: &str, case: &toml::Value) {
    let fields: Vec<&str> = line.split(',').collect();
    is_near(Some(utc_s(fields[1]).unwrap()), case, "utc_s");
    assert_eq!(fields[2], case["status"].as_str().unwrap());
    is_near(Some(degrees(Axis::Latitude, fields[3], fields[4]).unwrap()), case, "latitude_deg");
    is_near(Some(degrees(Axis::Longitude, fields[5], fields[6]).unwrap()), case, "longitude_deg");
}

#[test]
fn the_sentences_of_the_literature_say_what_they_say_and_bad_ones_are_refused_with_the_reason() {
    let vectors = vectors();
    let cases = vectors["nmea"].as_array().unwrap();
    assert_eq!(cases.len(), 11);
    for case in cases {
        let line = case["line"].as_str().unwrap();
        let body = line.trim_start_matches('$').split('*').next().unwrap();
        assert_eq!(format!("{:02X}", checksum(body.as_bytes())), case["checksum_computed"].as_str().unwrap());
        match only(line) {
            Heard::Refused(refusal) => assert_eq!(refusal.to_string(), case["error"].as_str().unwrap()),
            Heard::Gga(gga) => {
                assert_eq!((&case["valid"], &case["type"]), (&true.into(), &"GGA".into()), "{case}");
                is_gga_of(&gga, case);
            }
            Heard::Other => {
                assert_eq!(case["valid"].as_bool(), Some(true), "{case}");
                let kind = case["type"].as_str().unwrap();
                assert!(line[3..].starts_with(kind) && kind != "GGA", "{line}");
                if kind == "RMC" {
                    is_rmc_of(line, case);
                }
            }
        }
    }
}

#[test]
fn the_broken_stream_of_the_literature_gives_its_lines_however_it_is_cut() {
    let vectors = vectors();
    let stream = &vectors["nmea_stream"][0];
    let chunks: Vec<&str> =
        stream["chunks"].as_array().unwrap().iter().map(|c| c.as_str().unwrap()).collect();
    let mut decoder = Decoder::default();
    chunks.iter().for_each(|chunk| decoder.push(chunk.as_bytes()));
    let whole: Vec<Heard> = std::iter::from_fn(|| decoder.next()).collect();
    assert_eq!(whole.len() as i64, stream["complete_lines"].as_integer().unwrap());
    assert_eq!(decoder.tally().n_fixes as i64, stream["fixes"].as_integer().unwrap());
    assert_eq!(decoder.tally().n_refused(), 0);
    let bytes = chunks.concat();
    for cut in 0..=bytes.len() {
        let mut pieces = Decoder::default();
        pieces.push(&bytes.as_bytes()[..cut]);
        pieces.push(&bytes.as_bytes()[cut..]);
        assert_eq!(std::iter::from_fn(|| pieces.next()).collect::<Vec<_>>(), whole, "cut at {cut}");
    }
}

/// A sentence with this body.
fn sentence(body: &str) -> String {
    format!("${body}*{:02X}", checksum(body.as_bytes()))
}

const GOOD: &str = "GPGGA,183706.000,2200.8942,S,04753.7441,W,1,05,1.4,831.7,M,-4.3,M,,0000";

fn with(from: &str, to: &str) -> Heard {
    assert!(GOOD.contains(from), "{from}");
    only(&sentence(&GOOD.replacen(from, to, 1)))
}

#[test]
fn a_right_checksum_does_not_make_nonsense_a_fix() {
    for (from, to, reason) in [
        ("2200.8942", "22nan", "latitude is not as in NMEA 0183"),
        ("2200.8942", "22-0.8942", "latitude is not"),
        ("2200.8942", "220e1", "latitude is not"),
        ("2200.8942", "22.008942", "latitude is not"),
        ("2200.8942", "200.8942", "latitude is not"),
        ("2200.8942", "9000.0001", "latitude out of range"),
        ("04753.7441", "18000.0001", "longitude out of range"),
        ("04753.7441", "04760.0000", "minutes out of range"),
        ("04753.7441", "4753.7441", "longitude is not"),
        ("04753.7441", "0475é.744", "no sentence"),
        (",S,", ",W,", "hemisphere is not"),
        (",W,", ",w,", "hemisphere is not"),
        (",S,", ",,", "hemisphere is not"),
        (",1,05", ",x,05", "quality is not"),
        (",1,05", ",,05", "quality is not"),
        (",1,05", ",1,-5", "satellites is not"),
        ("1.4", "inf", "dilution is not"),
        ("831.7", "8e2", "altitude is not"),
        (",M,,", ",F,,", "unit is not"),
        ("183706.000", "243706.000", "time out of range"),
        ("183706.000", "186006.000", "time out of range"),
        ("183706.000", "183761.000", "time out of range"),
        ("183706.000", "18370.000", "time is not"),
        (",0000", "", "13 fields, expected 14"),
        (",0000", ",0000,7", "15 fields, expected 14"),
        ("GPGGA", "XXGGA", "talker `XX` is unknown"),
    ] {
        match with(from, to) {
            Heard::Refused(refusal) => assert!(refusal.to_string().contains(reason), "{to}: {refusal}"),
            other => panic!("{from} -> {to}: {other:?}"),
        }
    }
}

#[test]
fn fields_that_may_be_empty_may_be_empty_and_other_talkers_and_qualities_are_fixes() {
    for (from, to) in [
        ("183706.000", ""),
        ("183706.000", "183706"),
        (",05,1.4,831.7,M,-4.3,M,,0000", ",,,,,,,,"),
        (",1,05", ",2,05"),
        (",1,05", ",9,05"),
        ("GPGGA", "GNGGA"),
        ("GPGGA", "GLGGA"),
        ("GPGGA", "GAGGA"),
        ("GPGGA", "GBGGA"),
        ("2200.8942", "9000.0000"),
        ("04753.7441", "18000"),
        (",,0000", ",3.5,0120"),
    ] {
        assert!(matches!(with(from, to), Heard::Gga(Gga::Fix(_))), "{from} -> {to}");
    }
    // Old numbers beside the quality 0 are no fix.
    assert!(matches!(with(",1,05", ",0,05"), Heard::Gga(Gga::NoFix { utc_s: Some(_) })));
    assert!(matches!(with("2200.8942,S", ","), Heard::Gga(Gga::NoFix { .. })));
    assert_eq!(only(&sentence("PGRME,15.0,M,45.0,M,25.0,M")), Heard::Other);
    assert_eq!(only(&sentence("GPGSV,3,1,11")), Heard::Other);
}

#[test]
fn what_is_no_sentence_is_told_once_and_the_next_one_is_found() {
    let good = sentence(GOOD);
    let fix = only(&good);
    let long = format!("$GPGGA,{}", "1".repeat(150));
    for (before, expected) in [
        (format!("{long}\r\n"), vec![Refusal::TooLong]),
        (long.clone(), vec![Refusal::TooLong]),
        ("noise\r\n".to_owned(), vec![Refusal::NoStart]),
        ("noise".to_owned(), vec![Refusal::NoStart]),
        ("\r\n\r\n\n".to_owned(), vec![]),
        (good[..30].to_owned(), vec![Refusal::CutOff]),
        ("$".to_owned(), vec![Refusal::CutOff]),
        ("$\r\n".to_owned(), vec![Refusal::NoChecksum]),
        (format!("{}\r\n", &good[..good.len() - 3]), vec![Refusal::NoChecksum]),
        (format!("{}\r\n", &good[..good.len() - 1]), vec![Refusal::NoChecksum]),
        (format!("{good}0\r\n"), vec![Refusal::NoChecksum]),
        (format!("{}+B\r\n", &good[..good.len() - 2]), vec![Refusal::NoChecksum]),
        ("$*00\r\n".to_owned(), vec![Refusal::Form]),
        ("$GP*17\r\n".to_owned(), vec![Refusal::Form]),
    ] {
        let heard = hear(format!("{before}{good}\r\n").as_bytes());
        let expected = expected.into_iter().map(Heard::Refused).chain([fix.clone()]);
        assert_eq!(heard, expected.collect::<Vec<_>>(), "{before}");
    }
    // 120 bytes with `$` and the end of line are still one line, 121 are none.
    let padded = |n: usize| format!("{}\r\n", sentence(&format!("GPTXT,{}", "1".repeat(n))));
    assert_eq!((padded(108).len(), hear(padded(108).as_bytes())), (120, vec![Heard::Other]));
    assert_eq!(hear(padded(109).as_bytes()), [Heard::Refused(Refusal::TooLong)]);
}

#[test]
fn a_line_that_is_lost_is_told_and_what_comes_after_it_is_read_anew() {
    let good = sentence(GOOD);
    let mut decoder = Decoder::default();
    decoder.push(&good.as_bytes()[..40]);
    decoder.break_off();
    decoder.push(format!("{}\r\n{good}\r\n", &good[40..]).as_bytes());
    decoder.break_off();
    let heard: Vec<Heard> = std::iter::from_fn(|| decoder.next()).collect();
    let refusals = [Refusal::CutOff, Refusal::NoStart].map(Heard::Refused);
    assert_eq!(heard[..2], refusals);
    assert!(heard.len() == 3 && matches!(heard[2], Heard::Gga(Gga::Fix(_))));
}

/// The same by looking at all of the stream at once: fixes, other good lines, refused ones.
pub(crate) fn twin(stream: &[u8]) -> (Vec<Fix>, usize, usize) {
    let (mut fixes, mut n_good, mut n_bad) = (Vec::new(), 0, 0);
    let n_astray =
        |text: &[u8]| text.split(|b| *b == b'\n').filter(|line| line.iter().any(|b| *b != b'\r')).count();
    let mut parts = stream.split(|byte| *byte == b'$');
    n_bad += n_astray(parts.next().unwrap_or_default());
    for part in parts {
        let (line, after) = match part.iter().position(|byte| *byte == b'\n') {
            Some(end) => (&part[..end], &part[end + 1..]),
            None => {
                n_bad += 1;
                continue;
            }
        };
        n_bad += n_astray(after);
        let text = String::from_utf8_lossy(line);
        let text = text.strip_suffix('\r').unwrap_or(&text);
        let right = text.rsplit_once('*').is_some_and(|(body, digits)| {
            line.len() <= 117 && digits.to_uppercase() == format!("{:02X}", checksum(body.as_bytes()))
        });
        let Some((body, _)) = text.rsplit_once('*').filter(|_| right) else {
            n_bad += 1;
            continue;
        };
        let fields: Vec<&str> = body.split(',').collect();
        if fields[0] != "GPGGA" || fields[6] == "0" {
            n_good += 1;
            continue;
        }
        let Ok(Gga::Fix(fix)) = Fix::of_fields(fields[1..].iter().copied()) else { panic!("{body}") };
        fixes.push(fix);
    }
    (fixes, n_good, n_bad)
}

/// Good lines, cut off, written into each other, with wrong characters and garbage between them.
fn damaged(rng: &mut Rng, n_lines: usize) -> Vec<u8> {
    let mut stream = Vec::new();
    for k in 0..n_lines {
        let minutes = format!("22{:02}.{:04}", k % 60, rng.random_range(0..10_000));
        let mut line = format!("{}\r\n", sentence(&GOOD.replace("2200.8942", &minutes))).into_bytes();
        match rng.random_range(0..8) {
            0 => line.truncate(rng.random_range(1..line.len())),
            1 => {
                let at = rng.random_range(1..line.len());
                line[at] = b'x';
            }
            2 => {
                line.remove(rng.random_range(0..line.len()));
            }
            3 => {
                let at = rng.random_range(1..line.len());
                line.splice(at..at, *b"$GPGSA,A,1*2A\r\n");
            }
            4 => line.extend((0..rng.random_range(1..200)).map(|_| rng.random_range(32..126u8))),
            _ => {}
        }
        stream.extend(line);
    }
    stream.extend(b"\r\n");
    stream
}

#[test]
fn on_a_bad_line_every_good_sentence_is_found_once_and_every_bad_one_counted() {
    let mut rng = rng::stream(11, "nmea");
    for _ in 0..50 {
        let stream = damaged(&mut rng, 60);
        let (fixes, n_good, n_bad) = twin(&stream);
        let mut decoder = Decoder::default();
        let mut rest = stream.as_slice();
        while !rest.is_empty() {
            let (piece, after) = rest.split_at(rng.random_range(1..=rest.len().min(40)));
            decoder.push(piece);
            rest = after;
        }
        let found = std::iter::from_fn(|| decoder.next()).filter_map(|heard| match heard {
            Heard::Gga(Gga::Fix(fix)) => Some(fix),
            _ => None,
        });
        assert_eq!(found.collect::<Vec<_>>(), fixes);
        let Tally { n_without_fix, n_others, .. } = decoder.tally();
        assert_eq!((n_without_fix + n_others, decoder.tally().n_refused()), (n_good as u64, n_bad as u64));
        assert!(fixes.len() > 20 && n_bad > 10, "{} {n_bad}", fixes.len());
    }
}

#[test]
fn a_sentence_says_who_talks_about_what() {
    let mut sentences = Sentences::default();
    sentences.push(format!("{}\r\n", sentence("GNGGA,1,,x")).as_bytes());
    let found: Sentence = sentences.next().unwrap().unwrap();
    assert_eq!((found.talker(), found.kind()), ("GN", "GGA"));
    assert_eq!(found.fields().collect::<Vec<_>>(), ["1", "", "x"]);
    sentences.push(b"abc\r\n");
    assert_eq!(sentences.n_discarded(), 4);
}
