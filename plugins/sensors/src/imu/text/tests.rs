//! The text of the literature, a twin that sees the whole stream at once, and everything that is no record.

use rumbo_core::rng::{self, Rng, RngExt as _};

use super::*;

fn vectors() -> toml::Table {
    toml::from_str(include_str!("../../../tests/data/dc_serial_lines.toml")).unwrap()
}

fn listen(pieces: &[&str]) -> (Vec<Result<Spoken, Refusal>>, Tally) {
    let mut decoder = Decoder::new(360.0);
    pieces.iter().for_each(|piece| decoder.push(piece.as_bytes()));
    (std::iter::from_fn(|| decoder.next()).collect(), decoder.tally())
}

#[test]
fn the_lines_of_the_literature_are_records() {
    let vectors = vectors();
    let cases = vectors["imu"].as_array().unwrap();
    assert_eq!(cases.len(), 8);
    for case in cases {
        let (found, tally) = listen(&[case["line"].as_str().unwrap(), "\n"]);
        let number = |key: &str| case[key].as_float().unwrap();
        let spoken = Spoken { yaw: number("yaw"), pitch: number("pitch"), roll: number("roll") };
        assert_eq!(found, [Ok(spoken)]);
        assert_eq!((tally.n_good, tally.n_refused()), (1, 0));
        assert!((spoken.yaw.to_radians() - number("yaw_if_degrees_rad")).abs() < 1e-9);
    }
}

#[test]
fn the_broken_stream_of_the_literature_gives_its_records_however_it_is_cut() {
    let vectors = vectors();
    let stream = &vectors["imu_stream"][0];
    let chunks: Vec<&str> =
        stream["chunks"].as_array().unwrap().iter().map(|c| c.as_str().unwrap()).collect();
    let yaws: Vec<f64> =
        stream["yaws"].as_array().unwrap().iter().map(|yaw| yaw.as_float().unwrap()).collect();
    let yaws_of = |pieces: &[&str]| {
        let (found, tally) = listen(pieces);
        assert_eq!(tally.n_refused(), 0);
        found.into_iter().map(|spoken| spoken.unwrap().yaw).collect::<Vec<f64>>()
    };
    assert_eq!(yaws_of(&chunks), yaws);
    let bytes = chunks.concat();
    for cut in 0..=bytes.len() {
        assert_eq!(yaws_of(&[&bytes[..cut], &bytes[cut..]]), yaws, "cut at {cut}");
    }
}

#[test]
fn the_invalid_lines_of_the_literature_are_refused() {
    let vectors = vectors();
    let cases = vectors["imu_invalid"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let (line, error) = (case["line"].as_str().unwrap(), case["error"].as_str().unwrap());
        let (found, _) = listen(&[line, "\n"]);
        if error.contains("incomplete") {
            assert_eq!(found, [], "{line}: more may come");
        }
        // A record that follows is a good one in any case.
        let (found, tally) = listen(&[line, "\nY: 1.0 P: 2.0 R: 3.0\n"]);
        assert_eq!(found.len(), 2, "{line}");
        assert_eq!((tally.n_good, tally.n_refused()), (1, 1));
        let refusal = found[0].as_ref().unwrap_err().to_string();
        let reason = error.split(" (").next().unwrap();
        assert!(refusal.starts_with(reason) || refusal.starts_with("incomplete"), "{refusal} for {error}");
        assert_eq!(found[1], Ok(Spoken { yaw: 1.0, pitch: 2.0, roll: 3.0 }));
    }
}

#[test]
fn the_offending_word_is_told_and_each_bad_record_once() {
    let word = |word: &str| word.to_owned();
    for (text, expected) in [
        ("Y: 1 P: x R: 3 ", Refusal::NotANumber { angle: "pitch", word: word("x") }),
        ("Y: 1 P: 2 R: inf ", Refusal::NotFinite { angle: "roll", word: word("inf") }),
        ("Y: 361 P: 2 R: 3 ", Refusal::OutOfRange { angle: "yaw", word: word("361") }),
        ("Y: 1 R: 2 P: 3 ", Refusal::Unexpected { expected: "P:", word: word("R:") }),
        ("Y: 1 P: 2 3 ", Refusal::Unexpected { expected: "R:", word: word("3") }),
        ("hello world ", Refusal::Unexpected { expected: "Y:", word: word("hello") }),
        ("Y:1 P: 2 R: 3 ", Refusal::Unexpected { expected: "Y:", word: word("Y:1") }),
        ("Y: P: 1 ", Refusal::NotANumber { angle: "yaw", word: word("P:") }),
        ("Y: 1 P: 2 Y: 1 P: 2 R: 3 ", Refusal::Incomplete),
        ("Y: 1 P: 2 R: 0.4Y: 1 P: 2 R: 3 ", Refusal::Incomplete),
    ] {
        let (found, tally) = listen(&[text, "Y: 0 P: 0 R: 0\n"]);
        let refusals: Vec<&Refusal> = found.iter().filter_map(|found| found.as_ref().err()).collect();
        assert_eq!(refusals, [&expected], "{text}");
        assert_eq!(tally.n_refused(), 1);
        assert_eq!(found.last(), Some(&Ok(Spoken { yaw: 0.0, pitch: 0.0, roll: 0.0 })));
    }
}

#[test]
fn words_without_end_take_no_memory_and_are_no_numbers() {
    let mut decoder = Decoder::new(360.0);
    decoder.push(b"Y: ");
    (0..100_000).for_each(|_| decoder.push(b"1111111111"));
    assert_eq!(decoder.word.len(), LONGEST_WORD + 1);
    decoder.push(b" \xFF\xFE P: Y: 1 P: 2 R: 3\n");
    assert!(decoder.next().unwrap().is_err());
    assert!(decoder.next().unwrap().is_ok() && decoder.next().is_none());
}

#[test]
fn a_line_that_is_lost_is_told_and_what_comes_after_it_is_read_anew() {
    let mut decoder = Decoder::new(360.0);
    for lost in ["Y: 1 P", "Y: 1 P: 2 R: ", "Y"] {
        decoder.push(lost.as_bytes());
        decoder.break_off();
        assert_eq!(decoder.next(), Some(Err(Refusal::Incomplete)), "{lost}");
        decoder.push(b"Y: 1 P: 2 R: 3\n");
        assert!(decoder.next().unwrap().is_ok());
        decoder.break_off();
        assert_eq!(decoder.next(), None);
    }
}

/// The same by looking at all of the stream at once: records, and how many are bad.
pub(crate) fn twin(stream: &str) -> (Vec<Spoken>, usize) {
    let (mut good, mut n_bad) = (Vec::new(), 0);
    let mut parts: Vec<(Vec<&str>, bool)> = vec![(Vec::new(), false)];
    for word in stream.split_ascii_whitespace() {
        match word.strip_suffix("Y:") {
            Some(remnant) => {
                parts.last_mut().unwrap().1 = !remnant.is_empty();
                parts.push((Vec::new(), false));
            }
            None => parts.last_mut().unwrap().0.push(word),
        }
    }
    let n_parts = parts.len();
    for (idx, (words, has_remnant)) in parts.into_iter().enumerate() {
        let number = |word: &&str| word.parse::<f64>().ok().filter(|n| n.is_finite() && n.abs() <= 360.0);
        let is_fine = |(k, word): (usize, &&str)| match k {
            0 | 2 | 4 => number(word).is_some(),
            1 => *word == "P:",
            3 => *word == "R:",
            _ => false,
        };
        let n_fine = words.iter().enumerate().take_while(|(k, word)| is_fine((*k, word))).count();
        let is_first = idx == 0;
        if is_first {
            n_bad += usize::from(!words.is_empty() || has_remnant);
            continue;
        }
        if n_fine >= 5 {
            let [yaw, pitch, roll] = [0, 2, 4].map(|k| number(&words[k]).unwrap());
            good.push(Spoken { yaw, pitch, roll });
            n_bad += usize::from(words.len() > 5 || has_remnant);
        } else if words.len() > n_fine || idx + 1 < n_parts {
            n_bad += 1;
        }
    }
    (good, n_bad)
}

fn damaged(rng: &mut Rng, n_lines: usize) -> Vec<u8> {
    let mut stream = Vec::new();
    for _ in 0..n_lines {
        let mut angle = |most: f64| rng.random_range(-most..most);
        let (yaw, pitch, roll) = (angle(180.0), angle(10.0), angle(10.0));
        let mut line = format!("Y: {yaw:.2} P: {pitch:.2} R: {roll:.2}\r\n").into_bytes();
        match rng.random_range(0..6) {
            0 => line.truncate(rng.random_range(1..line.len())),
            1 => {
                let at = rng.random_range(0..line.len());
                line[at] = b'x';
            }
            2 => {
                let at = rng.random_range(1..line.len());
                line.splice(at..at, *b"Y: 1.00 P: 2.00 R: 3.00\r\n");
            }
            3 => line.extend((0..rng.random_range(1..80)).map(|_| rng.random_range(b'#'..b'T'))),
            _ => {}
        }
        stream.extend(line);
    }
    stream.extend(b"\r\n");
    stream
}

#[test]
fn on_a_bad_line_every_good_record_is_found_once_and_every_bad_one_counted() {
    let mut rng = rng::stream(12, "imu");
    for _ in 0..50 {
        let stream = damaged(&mut rng, 60);
        let (good, n_bad) = twin(std::str::from_utf8(&stream).unwrap());
        let mut decoder = Decoder::new(360.0);
        let mut rest = stream.as_slice();
        while !rest.is_empty() {
            let (piece, after) = rest.split_at(rng.random_range(1..=rest.len().min(40)));
            decoder.push(piece);
            rest = after;
        }
        let found = std::iter::from_fn(|| decoder.next()).filter_map(Result::ok);
        assert_eq!(found.collect::<Vec<_>>(), good);
        assert_eq!((decoder.tally().n_good, decoder.tally().n_refused()), (good.len() as u64, n_bad as u64));
        assert!(good.len() > 20 && n_bad > 10, "{} {n_bad}", good.len());
    }
}
