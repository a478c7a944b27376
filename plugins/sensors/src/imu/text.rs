//! The text of boards with the usual firmware for yaw, pitch and roll: `Y: -1.82 P: -0.05 R: 0.48`.
//!
//! Words are parted by any white space, lines mean nothing: devices and serial readers break them where they like. The
//! protocol has no checksum. A digit that came to harm on the way, or a last digit that got lost, cannot be told from a
//! good one.

use std::collections::VecDeque;

/// Yaw, pitch and roll as the device says them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spoken {
    /// In the device's unit and sense.
    pub yaw: f64,
    /// In the device's unit.
    pub pitch: f64,
    /// In the device's unit.
    pub roll: f64,
}

/// Why a record is not used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Another record began before this one was over.
    #[error("incomplete: a new `Y:` came before the number after `R:`")]
    Incomplete,
    /// A word that is no number stands where one should.
    #[error("{angle} is not a number: `{word}`")]
    NotANumber {
        /// Which angle.
        angle: &'static str,
        /// The word.
        word: String,
    },
    /// Infinite, or not a number by its own word.
    #[error("{angle} is not finite: `{word}`")]
    NotFinite {
        /// Which angle.
        angle: &'static str,
        /// The word.
        word: String,
    },
    /// More than a full turn: a point got lost, or the unit is another one.
    #[error("{angle} is more than a full turn: `{word}`")]
    OutOfRange {
        /// Which angle.
        angle: &'static str,
        /// The word.
        word: String,
    },
    /// A word that does not belong here.
    #[error("expected `{expected}`, found `{word}`")]
    Unexpected {
        /// What should come.
        expected: &'static str,
        /// The word.
        word: String,
    },
}

/// How many records came to what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Good ones.
    pub n_good: u64,
    /// Broken off by a new one.
    pub n_incomplete: u64,
    /// With a word that does not belong there.
    pub n_malformed: u64,
}

impl Tally {
    /// Records that were refused.
    pub fn n_refused(&self) -> u64 {
        self.n_incomplete + self.n_malformed
    }
}

/// No word of a record is so long.
const LONGEST_WORD: usize = 32;
/// How a record begins.
const BEGIN: &str = "Y:";
const LABELS: [&str; 3] = [BEGIN, "P:", "R:"];
const ANGLES: [&str; 3] = ["yaw", "pitch", "roll"];

/// Finds records in a stream that may be cut anywhere.
#[derive(Debug, Clone)]
pub struct Decoder {
    full_turn: f64,
    word: Vec<u8>,
    /// The record is lost: words until the next beginning are nothing new.
    is_astray: bool,
    /// Words of the record so far: 0 before its beginning, then labels and numbers in turn.
    n_words: usize,
    angles: [f64; 3],
    found: VecDeque<Result<Spoken, Refusal>>,
    tally: Tally,
}

impl Decoder {
    /// For a device that calls a full turn so much.
    pub fn new(full_turn: f64) -> Self {
        Self {
            full_turn,
            word: Vec::new(),
            is_astray: false,
            n_words: 0,
            angles: [0.0; 3],
            found: VecDeque::new(),
            tally: Tally::default(),
        }
    }

    /// Takes bytes in, however they are cut.
    pub fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if byte.is_ascii_whitespace() {
                self.end_word();
            } else {
                // One more than fits: what is too long is no word, but a record may begin at its end.
                if self.word.len() > LONGEST_WORD {
                    self.word.remove(0);
                }
                self.word.push(byte);
            }
        }
    }

    /// The line is lost: what has come of a record will not become whole.
    pub fn break_off(&mut self) {
        if self.n_words > 0 || !(self.is_astray || self.word.is_empty()) {
            self.refuse(Refusal::Incomplete);
        }
        self.word.clear();
        (self.n_words, self.is_astray) = (0, false);
    }

    /// The next record, or why it is none: each once.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Option<Result<Spoken, Refusal>> {
        self.found.pop_front()
    }

    /// All records so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn end_word(&mut self) {
        if self.word.is_empty() {
            return;
        }
        let word = String::from_utf8_lossy(&std::mem::take(&mut self.word)).into_owned();
        // A record that was cut off has no white space at its end: its last word and the next beginning are one.
        if word.ends_with(BEGIN) {
            self.begin(word.len() > BEGIN.len());
        } else if !self.is_astray {
            self.take(word);
        }
    }

    fn begin(&mut self, has_remnant: bool) {
        if self.n_words > 0 || (has_remnant && !self.is_astray) {
            self.refuse(Refusal::Incomplete);
        }
        (self.n_words, self.is_astray) = (1, false);
    }

    /// A word inside of a record, or where one should begin.
    fn take(&mut self, word: String) {
        let which = self.n_words / 2;
        let (Some(label), Some(angle)) = (LABELS.get(which), ANGLES.get(which)) else { return };
        if self.n_words.is_multiple_of(2) {
            if word == *label {
                self.n_words += 1;
            } else {
                self.refuse(Refusal::Unexpected { expected: label, word });
            }
            return;
        }
        match self.number(angle, word) {
            Ok(number) => {
                if let Some(slot) = self.angles.get_mut(which) {
                    *slot = number;
                }
                self.n_words += 1;
                self.end_record();
            }
            Err(refusal) => self.refuse(refusal),
        }
    }

    fn number(&self, angle: &'static str, word: String) -> Result<f64, Refusal> {
        match word.parse::<f64>() {
            Ok(_) if word.len() > LONGEST_WORD => Err(Refusal::NotANumber { angle, word }),
            Err(_) => Err(Refusal::NotANumber { angle, word }),
            Ok(number) if !number.is_finite() => Err(Refusal::NotFinite { angle, word }),
            Ok(number) if number.abs() > self.full_turn => Err(Refusal::OutOfRange { angle, word }),
            Ok(number) => Ok(number),
        }
    }

    fn end_record(&mut self) {
        if self.n_words < 2 * LABELS.len() {
            return;
        }
        let [yaw, pitch, roll] = self.angles;
        self.n_words = 0;
        self.tally.n_good += 1;
        self.found.push_back(Ok(Spoken { yaw, pitch, roll }));
    }

    fn refuse(&mut self, refusal: Refusal) {
        match refusal {
            Refusal::Incomplete => self.tally.n_incomplete += 1,
            _ => self.tally.n_malformed += 1,
        }
        self.found.push_back(Err(refusal));
        (self.n_words, self.is_astray) = (0, true);
    }
}

#[cfg(test)]
pub(crate) mod tests;
