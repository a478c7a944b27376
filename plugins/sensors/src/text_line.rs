//! The wire of an emulated device that talks by itself: every byte takes its time, and lines come to harm.

use std::collections::VecDeque;

use rand::RngExt as _;
use rumbo_core::rng::{self, Rng};
use rumbo_core::time::Time;

/// What goes wrong with whole lines, to be switched on and off at any time. Shares are of lines.
#[derive(Debug, Clone)]
pub struct TextFaults {
    /// Lines that end somewhere, without an end of line.
    pub truncated: f64,
    /// Lines into which the next one is written.
    pub interleaved: f64,
    /// Lines in which a character is another one.
    pub corrupted: f64,
    /// Nothing passes the wire.
    pub is_unplugged: bool,
    rng: Rng,
}

impl TextFaults {
    /// None yet; `seed` is for those that come by chance.
    pub fn none(seed: u64) -> Self {
        let rng = rng::stream(seed, "text_faults");
        Self { truncated: 0.0, interleaved: 0.0, corrupted: 0.0, is_unplugged: false, rng }
    }

    fn happens(&mut self, share: f64) -> bool {
        // Asked in any case, so that a share that changes leaves all others as they are.
        self.rng.random::<f64>() < share
    }

    /// A place inside of a line: something stands before it and behind it.
    fn inside(&mut self, line: &[u8]) -> usize {
        self.rng.random_range(1..line.len().saturating_sub(2).max(2))
    }
}

/// Start and stop bit beside eight of data.
const BITS_A_BYTE: f64 = 10.0;

/// See the module.
#[derive(Debug)]
pub(crate) struct TextLine {
    baud: u32,
    on_its_way: VecDeque<(Time, u8)>,
    free_at: Time,
    /// What follows the line that is written into this one.
    rest: Vec<u8>,
}

impl TextLine {
    /// The wire of a device that talks at this speed.
    pub fn new(baud: u32) -> Self {
        Self { baud, on_its_way: VecDeque::new(), free_at: Time::ZERO, rest: Vec::new() }
    }

    /// Sends a line, end included, as soon as the wire is free.
    pub fn send(&mut self, now: Time, line: &[u8], faults: &mut TextFaults) {
        let (truncated, interleaved, corrupted) = (faults.truncated, faults.interleaved, faults.corrupted);
        let [is_truncated, is_interleaved, is_corrupted] =
            [truncated, interleaved, corrupted].map(|share| faults.happens(share));
        let mut bytes = line.to_vec();
        if is_corrupted {
            let at = faults.inside(line);
            if let Some(byte) = bytes.get_mut(at) {
                *byte = if *byte == b'x' { b'z' } else { b'x' };
            }
        }
        let rest = std::mem::take(&mut self.rest);
        if is_truncated {
            bytes.truncate(faults.inside(line));
        } else if is_interleaved && rest.is_empty() {
            self.rest = bytes.split_off(faults.inside(line));
        }
        bytes.extend(rest);
        self.write(now, &bytes);
    }

    fn write(&mut self, now: Time, bytes: &[u8]) {
        let starts_at = self.free_at.max(now);
        for (idx, byte) in (1..).zip(bytes) {
            self.free_at = starts_at
                + rumbo_core::time::Span::from_secs(f64::from(idx) * BITS_A_BYTE / f64::from(self.baud));
            self.on_its_way.push_back((self.free_at, *byte));
        }
    }

    /// Bytes that are through by now, to a host whose port runs at this speed, where it has one.
    pub fn take(&mut self, now: Time, host_baud: Option<u32>, faults: &TextFaults, out: &mut Vec<u8>) {
        let is_garbled = host_baud.is_some_and(|baud| baud != self.baud);
        while let Some((_, byte)) = self.on_its_way.pop_front_if(|(at, _)| *at <= now) {
            if !faults.is_unplugged {
                // At another speed other bytes are heard.
                out.push(if is_garbled { byte.rotate_left(3) ^ 0x5A } else { byte });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &[u8] = b"0123456789\r\n";

    fn heard(faults: &mut TextFaults, n_lines: usize) -> Vec<u8> {
        let (mut line, mut out) = (TextLine::new(1200), Vec::new());
        (0..n_lines).for_each(|_| line.send(Time::ZERO, LINE, faults));
        line.take(Time::from_secs(1e6), None, faults, &mut out);
        out
    }

    #[test]
    fn bytes_take_their_time_and_another_speed_hears_other_bytes() {
        let (mut line, mut out, mut faults) = (TextLine::new(1200), Vec::new(), TextFaults::none(1));
        line.send(Time::ZERO, LINE, &mut faults);
        line.take(Time::from_secs(5.01 * 10.0 / 1200.0), Some(1200), &faults, &mut out);
        assert_eq!(out, b"01234");
        line.take(Time::from_secs(6.01 * 10.0 / 1200.0), Some(9600), &faults, &mut out);
        assert_ne!(out[5], b'5');
        faults.is_unplugged = true;
        line.take(Time::from_secs(1.0), None, &faults, &mut out);
        assert_eq!(out.len(), 6, "without a plug nothing passes");
    }

    #[test]
    fn as_many_lines_come_to_harm_as_are_asked_for() {
        let mut faults = TextFaults::none(1);
        assert_eq!(heard(&mut faults, 3), LINE.repeat(3));
        faults.corrupted = 0.25;
        let bad = heard(&mut faults, 4000).chunks(LINE.len()).filter(|line| *line != LINE).count();
        assert!((900..1100).contains(&bad), "{bad}");
        (faults.corrupted, faults.truncated) = (0.0, 0.25);
        let n_ends = heard(&mut faults, 4000).iter().filter(|byte| **byte == b'\n').count();
        assert!((2900..3100).contains(&n_ends), "{n_ends}");
        (faults.truncated, faults.interleaved) = (0.0, 1.0);
        let both = heard(&mut faults, 2);
        assert_eq!(both.len(), 2 * LINE.len());
        let inner = both.windows(LINE.len()).position(|window| window == LINE).unwrap();
        assert!(inner > 0 && inner < LINE.len());
        let outer: Vec<u8> = both[..inner].iter().chain(&both[inner + LINE.len()..]).copied().collect();
        assert_eq!(outer, LINE);
    }
}
