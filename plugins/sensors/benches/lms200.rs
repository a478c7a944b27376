//! How fast the stream of an LMS 200 is decoded. The device itself gives 37.5 scans or 27 kB a second at most.
#![allow(clippy::unwrap_used, missing_docs)]

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use rumbo_sensors::lms200::protocol::{
    CountUnit, Decoder, Measured, Reply, StatusByte, Telegram, Token, checksum,
};

fn main() {
    divan::main();
}

const N_SCANS: usize = 100;

/// Scans of 361 values, all different.
fn stream() -> Vec<u8> {
    let scan = |k: usize| {
        let words = (0..361).map(|idx| ((k * 31 + idx * 7) % 8000) as u16).collect();
        let measured = Measured { unit: CountUnit::Millimeters, partial: None, words, indices: None };
        Telegram { reply: Reply::Scan(measured), status: StatusByte::HEALTHY }.to_bytes()
    };
    (0..N_SCANS).flat_map(scan).collect()
}

fn n_scans(decoder: &mut Decoder) -> usize {
    let mut n_scans = 0;
    while let Some(token) = decoder.next() {
        if let Token::Frame(payload) = token
            && let Ok(Telegram { reply: Reply::Scan(_), .. }) = Telegram::of_payload(&payload)
        {
            n_scans += 1;
        }
    }
    n_scans
}

/// In pieces as a port gives them.
#[divan::bench(args = [16, 256, 4096])]
fn decode(bencher: Bencher<'_, '_>, piece: usize) {
    let stream = stream();
    bencher.counter(BytesCount::new(stream.len())).counter(ItemsCount::new(N_SCANS)).bench(|| {
        let mut decoder = Decoder::default();
        let mut n_found = 0;
        for bytes in stream.chunks(piece) {
            decoder.push(bytes);
            n_found += n_scans(&mut decoder);
        }
        assert_eq!(n_found, N_SCANS);
    });
}

/// Nothing but start bytes: each of them could begin a telegram.
#[divan::bench]
fn garbage(bencher: Bencher<'_, '_>) {
    let stream = [0x02, 0x80, 0xD6, 0x02].repeat(10_000);
    bencher.counter(BytesCount::new(stream.len())).bench(|| {
        let mut decoder = Decoder::default();
        let mut n_found = 0;
        for bytes in stream.chunks(256) {
            decoder.push(bytes);
            n_found += n_scans(&mut decoder);
        }
        n_found
    });
}

#[divan::bench]
fn sum(bencher: Bencher<'_, '_>) {
    let stream = stream();
    bencher.counter(BytesCount::new(stream.len())).bench(|| checksum(divan::black_box(&stream)));
}
