//! Lines: `~NUMBER TEXT*SUM` and a line feed, where SUM is the checksum of what stands between `~` and `*`.
//!
//! No character that may stand in a line is one flipped bit away from `~`, so a damaged line never looks like the end of
//! another one; a lost line feed costs one line, not two.

use super::checksum;

/// No line is longer, its line feed included.
pub const MOST_LINE: usize = 512;
const START: u8 = b'~';
const BEFORE_SUM: u8 = b'*';
const END: u8 = b'\n';
/// `*` and four hexadecimal digits.
const SUM_LEN: usize = 5;

/// A line that came through.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Counts lines of its side, from 0 to 65535 and again.
    pub number: u16,
    /// What it says.
    pub text: String,
}

/// What the decoder had to throw away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Lines that were accepted.
    pub n_lines: u64,
    /// Lines that were damaged.
    pub n_rejected: u64,
    /// Lines that were missed, by their numbers.
    pub n_missed: u64,
}

/// The line that says this.
pub fn encode(number: u16, text: &str) -> Vec<u8> {
    let body = format!("{number} {text}");
    let sum = checksum(body.as_bytes());
    format!("~{body}*{sum:04X}\n").into_bytes()
}

/// Finds lines in a stream of bytes, in pieces of any size.
#[derive(Debug, Default)]
pub struct Decoder {
    line: Vec<u8>,
    /// The rest of a line that is too long.
    skips: bool,
    last_number: Option<u16>,
    tally: Tally,
}

impl Decoder {
    /// One more byte; a line if it was the last of one.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        if byte != END {
            // A start in the middle is the start of another line: the end of the one before is lost.
            if byte == START {
                self.tally.n_rejected += u64::from(!self.line.is_empty());
                self.line.clear();
                self.skips = false;
            }
            if self.line.len() + 1 >= MOST_LINE {
                self.tally.n_rejected += u64::from(!self.skips);
                self.skips = true;
                self.line.clear();
            }
            if !self.skips {
                self.line.push(byte);
            }
            return None;
        }
        let skipped = std::mem::take(&mut self.skips);
        let frame = frame_of(&self.line);
        match &frame {
            Some(frame) => self.count(frame.number),
            None => self.tally.n_rejected += u64::from(!self.line.is_empty() && !skipped),
        }
        self.line.clear();
        frame
    }

    /// What was accepted and what was not.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The other side begins to count anew.
    pub fn restart_count(&mut self) {
        self.last_number = None;
    }

    fn count(&mut self, number: u16) {
        self.tally.n_lines += 1;
        if let Some(last) = self.last_number {
            self.tally.n_missed += u64::from(number.wrapping_sub(last).saturating_sub(1));
        }
        self.last_number = Some(number);
    }
}

fn frame_of(line: &[u8]) -> Option<Frame> {
    let (&START, line) = line.split_first()? else { return None };
    let (body, sum) = line.split_at_checked(line.len().checked_sub(SUM_LEN)?)?;
    let (&BEFORE_SUM, digits) = sum.split_first()? else { return None };
    let is_digit = |byte: &u8| matches!(byte, b'0'..=b'9' | b'A'..=b'F');
    let sum = std::str::from_utf8(digits).ok().filter(|_| digits.iter().all(is_digit))?;
    if u16::from_str_radix(sum, 16) != Ok(checksum(body)) {
        return None;
    }
    let is_allowed = |byte: &u8| matches!(byte, b'0'..=b'9' | b'A'..=b'Z' | b' ' | b'.' | b'-');
    let body = std::str::from_utf8(body).ok().filter(|body| body.as_bytes().iter().all(is_allowed))?;
    let (number, text) = body.split_once(' ')?;
    Some(Frame { number: number.parse().ok()?, text: text.to_owned() })
}
