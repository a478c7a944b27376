//! Frames: start byte, address, length, payload, checksum; and single bytes between them.

use super::checksum;

/// Starts a frame.
pub const STX: u8 = 0x02;
/// Sent alone: the telegram came through.
pub const ACK: u8 = 0x06;
/// Sent alone: the telegram did not come through.
pub const NAK: u8 = 0x15;
/// Address of telegrams to the one device on a line.
pub const HOST_TO_DEVICE: u8 = 0x00;
/// Address of telegrams from it.
pub const DEVICE_TO_HOST: u8 = 0x80;
/// No length field is larger: 401 values with their indices stay below.
pub const MOST_LEN: usize = 812;
/// Start byte, address, two bytes of length and two of checksum.
pub const OVERHEAD: usize = 6;

/// The frame around a payload.
pub fn encode(address: u8, payload: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(payload.len() + OVERHEAD);
    frame.extend([STX, address]);
    // No payload of ours is longer than a length field can say.
    frame.extend(u16::try_from(payload.len()).unwrap_or(u16::MAX).to_le_bytes());
    frame.extend(payload);
    frame.extend(checksum(&frame).to_le_bytes());
    frame
}

/// What stands on the line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Token {
    /// [`ACK`].
    Ack,
    /// [`NAK`].
    Nak,
    /// The payload of a whole frame whose checksum is right.
    Frame(Vec<u8>),
}

/// What the decoder had to throw away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Frames of full length with a wrong checksum.
    pub n_checksum_failures: u64,
    /// Bytes that belong to nothing.
    pub n_discarded: u64,
}

/// Finds telegrams of the device in a stream of bytes, in pieces of any size.
///
/// Start bytes and acknowledgments also occur inside frames and nothing is escaped. So a frame that turns out to be
/// none loses its first byte only, and the search goes on behind it: the next telegram is found even inside a frame
/// whose length was damaged.
#[derive(Debug, Default)]
pub struct Decoder {
    pending: Vec<u8>,
    /// Bytes of `pending` that are used up.
    n_used: usize,
    tally: Tally,
}

enum Look {
    NeedMore,
    Found(Token, usize),
    NoFrame,
    WrongChecksum,
}

impl Decoder {
    /// More of the stream.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.n_used > 0 {
            self.pending.drain(..self.n_used);
            self.n_used = 0;
        }
        self.pending.extend(bytes);
    }

    /// The next token, as soon as it is whole.
    #[expect(clippy::should_implement_trait, reason = "more may come after `None`")]
    pub fn next(&mut self) -> Option<Token> {
        loop {
            match look(self.pending.get(self.n_used..).unwrap_or_default()) {
                Look::NeedMore => return None,
                Look::Found(token, n_bytes) => {
                    self.n_used += n_bytes;
                    return Some(token);
                }
                Look::NoFrame => self.skip(),
                Look::WrongChecksum => {
                    self.tally.n_checksum_failures += 1;
                    self.skip();
                }
            }
        }
    }

    /// A frame has begun and is not whole yet.
    pub fn is_amid_frame(&self) -> bool {
        self.n_used < self.pending.len()
    }

    /// The line fell silent: what has begun will not be finished. Ask for [`next`](Self::next) afterwards.
    pub fn give_up_frame(&mut self) {
        if self.is_amid_frame() {
            self.skip();
        }
    }

    /// Forgets what has come so far, as after a change of speed.
    pub fn clear(&mut self) {
        self.pending.clear();
        self.n_used = 0;
    }

    /// What had to be thrown away.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn skip(&mut self) {
        self.n_used += 1;
        self.tally.n_discarded += 1;
    }
}

fn look(bytes: &[u8]) -> Look {
    let &[STX, DEVICE_TO_HOST, low, high, ..] = bytes else {
        return match bytes {
            [] | [STX] | [STX, DEVICE_TO_HOST] | [STX, DEVICE_TO_HOST, _] => Look::NeedMore,
            [ACK, ..] => Look::Found(Token::Ack, 1),
            [NAK, ..] => Look::Found(Token::Nak, 1),
            _ => Look::NoFrame,
        };
    };
    let len = usize::from(u16::from_le_bytes([low, high]));
    // The shortest answer is a code and a status.
    if !(2..=MOST_LEN).contains(&len) {
        return Look::NoFrame;
    }
    let Some((body, rest)) = bytes.split_at_checked(len + OVERHEAD - 2) else { return Look::NeedMore };
    let &[low, high, ..] = rest else { return Look::NeedMore };
    if checksum(body) != u16::from_le_bytes([low, high]) {
        return Look::WrongChecksum;
    }
    let payload = body.get(OVERHEAD - 2..).unwrap_or_default();
    Look::Found(Token::Frame(payload.to_vec()), len + OVERHEAD)
}
