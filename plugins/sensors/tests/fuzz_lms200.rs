//! Whatever comes over the line: the decoder, the driver and the emulated device live through it.
//!
//! `PROPTEST_CASES=1000000 cargo test --release -p rumbo-sensors --test fuzz_lms200` is the long run.
#![allow(clippy::unwrap_used, missing_docs)]

use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_assert_eq, prop_oneof, proptest};
use rumbo_core::time::{Span, Time};
use rumbo_sensors::lms200::driver::{Action, Driver, Settings};
use rumbo_sensors::lms200::emulator::{Emulator, Faults};
use rumbo_sensors::lms200::protocol::{
    Command, CountUnit, DEVICE_TO_HOST, Decoder, HOST_TO_DEVICE, LineSpeed, MeasuringMode, STX, StatusReport,
    Telegram, Token, Variant, encode,
};

/// Bytes that mean something more often than chance would have it.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![
        4 => any::<u8>(),
        1 => Just(STX),
        1 => Just(DEVICE_TO_HOST),
        1 => Just(0x00),
        1 => Just(0xB0),
    ]
}

/// Garbage with telegrams in it whose checksums are right, whatever their payloads are.
fn stream(address: u8) -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        vec(byte(), 0..40),
        vec(any::<u8>(), 2..60).prop_map(move |payload| encode(address, &payload)),
    ];
    vec(piece, 0..8).prop_map(|pieces| pieces.concat())
}

fn tokens(decoder: &mut Decoder) -> Vec<Token> {
    std::iter::from_fn(|| decoder.next()).collect()
}

fn n_bytes(tokens: &[Token]) -> usize {
    tokens.iter().map(|token| if let Token::Frame(payload) = token { payload.len() + 6 } else { 1 }).sum()
}

fn settings() -> Settings {
    Settings {
        connect: LineSpeed::ALL.to_vec(),
        speed: LineSpeed::Baud500000,
        variant: Variant { field_deg: 180, resolution_centideg: 50 },
        partials: false,
        unit: CountUnit::Millimeters,
        measuring_mode: MeasuringMode::FieldsAbDazzle,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pieces_of_any_size_give_what_the_whole_gives(bytes in stream(DEVICE_TO_HOST), cut in 1usize..50) {
        let mut whole = Decoder::default();
        whole.push(&bytes);
        let expected = tokens(&mut whole);
        let mut pieces = Decoder::default();
        let mut found = Vec::new();
        for piece in bytes.chunks(cut) {
            pieces.push(piece);
            found.extend(tokens(&mut pieces));
        }
        prop_assert_eq!(&found, &expected);
        prop_assert_eq!(whole.tally(), pieces.tally());
        // In the end every byte is in a token or thrown away.
        while pieces.is_amid_frame() {
            pieces.give_up_frame();
            found.extend(tokens(&mut pieces));
        }
        prop_assert_eq!(n_bytes(&found) as u64 + pieces.tally().n_discarded, bytes.len() as u64);
        for token in &found {
            if let Token::Frame(payload) = token {
                let _ = Telegram::of_payload(payload);
            }
        }
    }

    /// Between telegrams stand bytes that begin none.
    #[test]
    fn every_telegram_is_found_and_none_beside(
        pieces in vec((vec(any::<u8>(), 2..60), vec(any::<u8>().prop_map(|b| b | 0x40), 0..20)), 0..6),
    ) {
        let mut decoder = Decoder::default();
        for (payload, garbage) in &pieces {
            decoder.push(&encode(DEVICE_TO_HOST, payload));
            decoder.push(garbage);
        }
        let frames: Vec<Token> = pieces.iter().map(|(payload, _)| Token::Frame(payload.clone())).collect();
        prop_assert_eq!(tokens(&mut decoder), frames);
    }

    #[test]
    fn payloads_of_any_bytes_are_understood_or_refused(payload in vec(byte(), 0..170)) {
        let _ = Telegram::of_payload(&payload);
        let _ = Command::of_payload(&payload);
        let _ = StatusReport::of_bytes(&payload);
    }

}

/// Each of these inputs is a whole conversation.
fn conversations() -> ProptestConfig {
    let usual = ProptestConfig::default();
    ProptestConfig { failure_persistence: None, cases: usual.cases.min(100_000), ..usual }
}

proptest! {
    #![proptest_config(conversations())]

    /// What the driver is told may be wrong, what it says never is.
    #[test]
    fn the_driver_says_nothing_but_commands(pieces in vec((stream(DEVICE_TO_HOST), 0u32..400), 0..12)) {
        let mut now = Time::ZERO;
        let mut driver = Driver::new(settings(), now);
        for (bytes, wait_ms) in pieces {
            now = now + Span(i64::from(wait_ms) * 1_000_000);
            driver.receive(now, &bytes);
            driver.tick(now);
            while let Some(action) = driver.next_action() {
                if let Action::Send(telegram) = action {
                    let payload = &telegram[4..telegram.len() - 2];
                    prop_assert_eq!(&encode(HOST_TO_DEVICE, payload), &telegram);
                    prop_assert_eq!(Command::of_payload(payload).is_some(), true);
                }
            }
        }
    }

    #[test]
    fn the_emulated_device_lives_through_everything(pieces in vec((stream(HOST_TO_DEVICE), 0u32..60), 0..12)) {
        let mut now = Time::ZERO;
        let mut device = Emulator::new(Box::new(|_, _| Some((2.0, 0))), Faults::none(1), now);
        let mut heard = Vec::new();
        for (bytes, wait_ms) in pieces {
            now = now + Span(i64::from(wait_ms) * 1_000_000);
            let speed = device.speed();
            device.receive(now, speed, &bytes);
            device.transmit(now, speed, &mut heard);
        }
        // A line carries no more than its speed allows.
        prop_assert_eq!(heard.len() as f64 <= now.as_secs() * 50_000.0 + 1.0, true);
    }
}
