//! From bytes to sentences whose checksums are right.

use std::collections::VecDeque;

use super::Refusal;

/// A line that is longer than this is dropped. The standard has at most 82 characters with `$` and the end of line;
/// receivers with more digits send a few more.
pub const MOST_BYTES: usize = 120;

/// A sentence whose checksum is right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sentence {
    /// Between `$` and `*`.
    body: String,
}

impl Sentence {
    /// Who talks: `GP`, `GN` and so on.
    pub fn talker(&self) -> &str {
        self.body.get(..2).unwrap_or_default()
    }

    /// What about: `GGA`, `RMC` and so on.
    pub fn kind(&self) -> &str {
        self.address().get(2..).unwrap_or_default()
    }

    /// The fields after talker and type.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.body.split(',').skip(1)
    }

    fn address(&self) -> &str {
        self.body.split(',').next().unwrap_or_default()
    }

    /// The sentence of a line without `$` and end of line.
    fn of_line(line: &[u8]) -> Result<Self, Refusal> {
        let (body, digits) = match line.iter().rposition(|byte| *byte == b'*') {
            Some(star) => line.split_at(star),
            None => return Err(Refusal::NoChecksum),
        };
        let digits = digits.get(1..).unwrap_or_default();
        let is_hexadecimal = digits.len() == 2 && digits.iter().all(u8::is_ascii_hexdigit);
        let received = std::str::from_utf8(digits).ok().and_then(|text| u8::from_str_radix(text, 16).ok());
        let received = received.filter(|_| is_hexadecimal).ok_or(Refusal::NoChecksum)?;
        let computed = checksum(body);
        if computed != received {
            return Err(Refusal::Checksum { computed, received });
        }
        let is_printable = body.iter().all(|byte| (0x20..0x7F).contains(byte));
        let body = std::str::from_utf8(body).map_err(|_| Refusal::Form)?.to_owned();
        let sentence = Self { body };
        let address = sentence.address();
        let is_address = address.len() >= 4 && address.bytes().all(|byte| byte.is_ascii_alphanumeric());
        if is_printable && is_address { Ok(sentence) } else { Err(Refusal::Form) }
    }
}

/// The exclusive or of all characters between `$` and `*`.
pub fn checksum(body: &[u8]) -> u8 {
    body.iter().fold(0, |sum, byte| sum ^ byte)
}

/// Finds sentences in a stream that may be cut anywhere.
///
/// A `$` always begins a sentence: none has one inside, so that a sentence that follows one that was cut off is found.
#[derive(Debug, Clone, Default)]
pub struct Sentences {
    line: Vec<u8>,
    place: Place,
    found: VecDeque<Result<Sentence, Refusal>>,
    n_discarded: u64,
}

/// Where in the stream the next byte stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Place {
    /// Between lines.
    #[default]
    Between,
    /// In a sentence.
    Inside,
    /// In what is no sentence, or no sentence any more.
    Astray,
}

impl Sentences {
    /// Takes bytes in.
    pub fn push(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.take(*byte));
    }

    /// The next sentence, or why a line is none: each line once.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Option<Result<Sentence, Refusal>> {
        self.found.pop_front()
    }

    /// The line is lost: what has come of a sentence will not become whole.
    pub fn break_off(&mut self) {
        match self.place {
            Place::Inside => self.found.push_back(Err(Refusal::CutOff)),
            Place::Astray if !self.line.is_empty() => self.found.push_back(Err(Refusal::NoStart)),
            _ => {}
        }
        self.line.clear();
        self.place = Place::Between;
    }

    /// Bytes that belong to no sentence.
    pub fn n_discarded(&self) -> u64 {
        self.n_discarded
    }

    fn take(&mut self, byte: u8) {
        match (byte, self.place) {
            (b'$', _) => {
                self.break_off();
                self.place = Place::Inside;
            }
            (b'\n', _) => self.end_line(),
            (_, Place::Inside) => self.grow(byte),
            (b'\r', _) => self.n_discarded += 1,
            _ => {
                self.n_discarded += 1;
                if self.place == Place::Between {
                    self.place = Place::Astray;
                    self.line.push(byte);
                }
            }
        }
    }

    fn grow(&mut self, byte: u8) {
        // With `$` and the end of the line.
        if self.line.len() + 3 > MOST_BYTES {
            self.found.push_back(Err(Refusal::TooLong));
            self.n_discarded += self.line.len() as u64 + 1;
            // Its refusal is told; the rest is nothing new.
            self.line.clear();
            self.place = Place::Astray;
            return;
        }
        self.line.push(byte);
    }

    fn end_line(&mut self) {
        if self.place == Place::Inside {
            let line = self.line.strip_suffix(b"\r").unwrap_or(&self.line);
            self.found.push_back(Sentence::of_line(line));
            self.line.clear();
            self.place = Place::Between;
        } else {
            self.break_off();
        }
    }
}
