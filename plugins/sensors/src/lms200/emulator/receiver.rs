//! The device's ear: whole telegrams of the host.

use rumbo_core::time::{Span, Time};

use crate::lms200::protocol::{HOST_TO_DEVICE, MOST_LEN, OVERHEAD, STX, checksum};

/// Bytes of a telegram may not be further apart.
const MOST_GAP: Span = Span(6_000_000);

/// What came in.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Heard {
    /// A whole telegram with a right checksum.
    Payload(Vec<u8>),
    /// A telegram that is none.
    Damaged,
}

#[derive(Debug, Default)]
pub(super) struct Receiver {
    frame: Vec<u8>,
    last_at: Time,
}

impl Receiver {
    /// A byte. Those outside of a frame are not heeded.
    pub fn hear(&mut self, now: Time, byte: u8) -> Option<Heard> {
        let late = self.wait(now);
        self.last_at = now;
        if self.frame.is_empty() && byte != STX {
            return late;
        }
        self.frame.push(byte);
        late.or_else(|| self.finish())
    }

    /// Time has passed.
    pub fn wait(&mut self, now: Time) -> Option<Heard> {
        let is_late = !self.frame.is_empty() && now - self.last_at > MOST_GAP;
        is_late.then(|| self.damaged())
    }

    fn finish(&mut self) -> Option<Heard> {
        let &[_, address, low, high, ..] = &self.frame[..] else { return None };
        let len = usize::from(u16::from_le_bytes([low, high]));
        if len == 0 || len > MOST_LEN {
            return Some(self.damaged());
        }
        if self.frame.len() < len + OVERHEAD {
            return None;
        }
        let (body, sum) = self.frame.split_at(len + OVERHEAD - 2);
        let is_right = *sum == checksum(body).to_le_bytes();
        let payload = body.get(OVERHEAD - 2..).unwrap_or_default().to_vec();
        self.frame.clear();
        match (is_right, address == HOST_TO_DEVICE) {
            (false, _) => Some(Heard::Damaged),
            (true, true) => Some(Heard::Payload(payload)),
            // For another device on the line.
            (true, false) => None,
        }
    }

    fn damaged(&mut self) -> Heard {
        self.frame.clear();
        Heard::Damaged
    }
}
