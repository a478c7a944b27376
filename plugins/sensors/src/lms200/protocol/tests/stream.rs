//! Telegrams in a stream that is cut, damaged and full of garbage.

use rand::RngExt as _;
use rumbo_core::rng::{Rng, stream};

use super::*;

fn frames(bytes: &[u8], pieces: impl Iterator<Item = usize>) -> Vec<Vec<u8>> {
    let (mut decoder, mut found, mut rest) = (Decoder::default(), Vec::new(), bytes);
    for n in pieces {
        let (piece, left) = rest.split_at(n.min(rest.len()));
        decoder.push(piece);
        while let Some(token) = decoder.next() {
            if let Token::Frame(payload) = token {
                found.push(payload);
            }
        }
        rest = left;
        if rest.is_empty() {
            break;
        }
    }
    // Garbage at the end may look like the beginning of a frame that never comes whole.
    while decoder.is_amid_frame() {
        decoder.give_up_frame();
        while let Some(token) = decoder.next() {
            if let Token::Frame(payload) = token {
                found.push(payload);
            }
        }
    }
    found
}

fn garbage(rng: &mut Rng, most: usize) -> Vec<u8> {
    let n = rng.random_range(0..=most);
    (0..n)
        .map(|_| match rng.random_range(0..6) {
            0 => STX,
            1 => ACK,
            2 => NAK,
            3 => DEVICE_TO_HOST,
            _ => rng.random::<u8>(),
        })
        .collect()
}

#[test]
fn a_stream_in_pieces_of_any_size_gives_all_telegrams_and_invents_none() {
    let mut rng = stream(3, "lms200_stream");
    for round in 0..300 {
        let (mut bytes, mut sent) = (Vec::new(), Vec::new());
        for _ in 0..rng.random_range(1..8) {
            bytes.extend(garbage(&mut rng, 40));
            let (n, first) = (rng.random_range(0..=401u16), rng.random_range(0..8000u16));
            let frame = scan(n, |i| first.wrapping_mul(i).wrapping_add(0x0680 * (i % 3)));
            sent.push(frame[4..frame.len() - 2].to_vec());
            bytes.extend(frame);
        }
        bytes.extend(garbage(&mut rng, 40));
        let mut sizes = stream(round, "pieces");
        let most = [1, 3, 100, 5000][round as usize % 4];
        let pieces = std::iter::from_fn(move || Some(sizes.random_range(1..=most)));
        assert_eq!(frames(&bytes, pieces), sent, "round {round}");
    }
}

#[test]
fn acknowledgments_are_heard_between_frames_and_not_inside() {
    let frame = scan(3, |_| 0x1506);
    let mut decoder = Decoder::default();
    let stream: Vec<u8> = [&[ACK][..], &frame, &[NAK, ACK], &frame].concat();
    let mut tokens = Vec::new();
    for byte in stream {
        decoder.push(&[byte]);
        tokens.extend(decoder.next());
    }
    let payload = Token::Frame(frame[4..frame.len() - 2].to_vec());
    assert_eq!(tokens, [Token::Ack, payload.clone(), Token::Nak, Token::Ack, payload]);
    assert_eq!(decoder.tally(), Tally::default());
}

/// All 2976 single-bit errors of a scan of 181 values: none goes through, and the next telegram is found each time.
#[test]
fn no_single_flipped_bit_goes_through() {
    let frame = scan(181, |i| 2000 + i);
    assert_eq!(frame.len(), 372);
    let next = scan(5, |i| 7 * i);
    for bit in 0..frame.len() * 8 {
        let mut bytes = frame.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes.extend(&next);
        let found = frames(&bytes, std::iter::repeat(64));
        assert_eq!(found, [next[4..next.len() - 2].to_vec()], "bit {bit}");
    }
}

/// A damaged length that claims more swallows the next telegram only for as long as it takes to see it.
#[test]
fn a_frame_that_claims_to_be_longer_does_not_lose_the_next() {
    let (mut damaged, next) = (scan(10, |i| 100 + i), scan(400, |i| i));
    damaged[3] = 0x02;
    let mut decoder = Decoder::default();
    decoder.push(&damaged);
    assert_eq!(decoder.next(), None);
    decoder.push(&next);
    let found: Vec<Token> = std::iter::from_fn(|| decoder.next()).collect();
    assert_eq!(found.last(), Some(&Token::Frame(next[4..next.len() - 2].to_vec())));
    assert_eq!(decoder.tally().n_checksum_failures, 1);
}

#[test]
fn lengths_that_no_telegram_has_are_not_waited_for() {
    for len in [0u16, 1, 813, 0xFFFF] {
        let [low, high] = len.to_le_bytes();
        let next = scan(1, |_| 7);
        let mut decoder = Decoder::default();
        decoder.push(&[&[STX, DEVICE_TO_HOST, low, high], &next[..]].concat());
        let found: Vec<Token> = std::iter::from_fn(|| decoder.next()).collect();
        assert_eq!(found.last(), Some(&Token::Frame(next[4..next.len() - 2].to_vec())), "{len}");
    }
}
