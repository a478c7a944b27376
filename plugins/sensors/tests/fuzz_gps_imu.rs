//! Whatever comes over the lines of a satellite receiver and an inertial measurement unit: their decoders live through it.
//!
//! `PROPTEST_CASES=1000000 cargo test --release -p rumbo-sensors --test fuzz_gps_imu` is the long run.
#![allow(clippy::unwrap_used, missing_docs)]

use proptest::collection::vec;
use proptest::prelude::{
    Just, ProptestConfig, Strategy, any, prop_assert, prop_assert_eq, prop_oneof, proptest,
};
use rumbo_sensors::gps::nmea::{self, Gga, Heard, checksum};
use rumbo_sensors::imu::text::{self, Spoken};

/// Bytes that mean something more often than chance would have it.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![3 => any::<u8>(), 4 => proptest::sample::select(b"$*,.\r\n0123456789NSEWMYPR: -".to_vec())]
}

fn sentence(body: &[u8]) -> Vec<u8> {
    [b"$", body, format!("*{:02X}\r\n", checksum(body)).as_bytes()].concat()
}

/// Garbage with sentences in it whose checksums are right, whatever their fields are.
fn sentences() -> impl Strategy<Value = Vec<u8>> {
    let field = prop_oneof![
        2 => Just(Vec::new()),
        2 => Just(b"2200.8942".to_vec()),
        1 => Just(b"04753.7441".to_vec()),
        1 => Just(b"1".to_vec()),
        1 => Just(b"S".to_vec()),
        1 => Just(b"W".to_vec()),
        1 => Just(b"M".to_vec()),
        2 => vec(proptest::sample::select(b"0123456789.-einfaNSEWM".to_vec()), 0..8),
    ];
    let gga = vec(field, 10..17)
        .prop_map(|fields| sentence(&[b"GPGGA,".as_slice(), &fields.join(b",".as_slice())].concat()));
    let piece = prop_oneof![
        2 => vec(byte(), 0..60),
        1 => vec(byte(), 0..60).prop_map(|body| sentence(&body)),
        3 => gga,
    ];
    vec(piece, 0..8).prop_map(|pieces| pieces.concat())
}

fn heard(decoder: &mut nmea::Decoder) -> Vec<Heard> {
    std::iter::from_fn(|| decoder.next()).collect()
}

/// Garbage with records in it.
fn records() -> impl Strategy<Value = Vec<u8>> {
    let word = prop_oneof![
        Just(b"Y:".to_vec()),
        Just(b"P:".to_vec()),
        Just(b"R:".to_vec()),
        any::<f32>().prop_map(|number| number.to_string().into_bytes()),
        (-360.0f32..360.0).prop_map(|number| format!("{number:.2}").into_bytes()),
        vec(byte(), 0..40),
    ];
    vec(word, 0..40).prop_map(|words| words.join(b" ".as_slice()))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sentences_in_pieces_of_any_size_give_what_the_whole_gives(bytes in sentences(), cut in 1usize..50) {
        let mut whole = nmea::Decoder::default();
        whole.push(&bytes);
        let expected = heard(&mut whole);
        let mut pieces = nmea::Decoder::default();
        bytes.chunks(cut).for_each(|piece| pieces.push(piece));
        prop_assert_eq!(&heard(&mut pieces), &expected);
        prop_assert_eq!(pieces.tally(), whole.tally());
        for heard in &expected {
            if let Heard::Gga(Gga::Fix(fix)) = heard {
                prop_assert!(fix.latitude_deg.abs() <= 90.0 && fix.longitude_deg.abs() <= 180.0);
                prop_assert!(fix.quality > 0 && fix.utc_s.is_none_or(|utc_s| (0.0..86_461.0).contains(&utc_s)));
                let numbers = [fix.hdop, fix.altitude_m, fix.geoid_separation_m];
                prop_assert!(numbers.into_iter().flatten().all(f64::is_finite));
            }
        }
        let tally = whole.tally();
        let n_good = tally.n_fixes + tally.n_without_fix + tally.n_others;
        prop_assert_eq!(n_good + tally.n_refused(), expected.len() as u64);
        whole.break_off();
        prop_assert!(heard(&mut whole).len() <= 1);
    }

    /// After whatever came, a good sentence is found.
    #[test]
    fn a_sentence_is_found_behind_anything(bytes in sentences()) {
        let mut decoder = nmea::Decoder::default();
        decoder.push(&bytes);
        decoder.push(b"$GPGGA,183706.000,2200.8942,S,04753.7441,W,1,05,1.4,831.7,M,-4.3,M,,0000*4B\r\n");
        prop_assert!(matches!(heard(&mut decoder).last(), Some(Heard::Gga(Gga::Fix(_)))));
    }

    #[test]
    fn records_in_pieces_of_any_size_give_what_the_whole_gives(bytes in records(), cut in 1usize..50) {
        let all = |decoder: &mut text::Decoder| -> Vec<_> { std::iter::from_fn(|| decoder.next()).collect() };
        let mut whole = text::Decoder::new(360.0);
        whole.push(&bytes);
        let expected = all(&mut whole);
        let mut pieces = text::Decoder::new(360.0);
        bytes.chunks(cut).for_each(|piece| pieces.push(piece));
        prop_assert_eq!(&all(&mut pieces), &expected);
        for Spoken { yaw, pitch, roll } in expected.iter().filter_map(|found| found.as_ref().ok()) {
            prop_assert!([yaw, pitch, roll].into_iter().all(|angle| angle.abs() <= 360.0));
        }
        let tally = whole.tally();
        prop_assert_eq!(tally.n_good + tally.n_refused(), expected.len() as u64);
        // After whatever came, a good record is found.
        whole.push(b"\nY: 1.0 P: 2.0 R: 3.0\n");
        prop_assert_eq!(all(&mut whole).pop(), Some(Ok(Spoken { yaw: 1.0, pitch: 2.0, roll: 3.0 })));
    }
}
