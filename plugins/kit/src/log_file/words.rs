//! The words of one line, taken one after the other; a word that is not what it should be is a fault with its place.

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::time::Time;

use super::error::{FaultKind, LineFault};
use super::number::number;

/// A scan with more beams than this is damage, not a device.
pub(super) const MOST_BEAMS: usize = 100_000;

/// Farther from its origin than this is no robot, meters (or centimeters).
const FARTHEST: f64 = 1e9;

/// Stamps are kept as nanoseconds in 64 bits, which end 292 years away from zero, seconds.
const LATEST_S: f64 = 9e9;

/// What is left of a line, and which line it is.
#[derive(Debug, Clone)]
pub(crate) struct Words<'a> {
    rest: &'a [u8],
    line: u64,
    message: &'static str,
}

/// A word as a message may show it: short, and readable whatever its bytes are.
pub(crate) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let start = word.get(..LONGEST).unwrap_or(word);
    let more = if start.len() < word.len() { "..." } else { "" };
    format!("`{}{more}`", String::from_utf8_lossy(start).escape_debug())
}

impl<'a> Words<'a> {
    pub fn new(line: u64, bytes: &'a [u8]) -> Words<'a> {
        Words { rest: bytes, line, message: "" }
    }

    /// The same words, with faults told as of this kind of message.
    pub fn of(mut self, message: &'static str) -> Words<'a> {
        self.message = message;
        self
    }

    /// The next word as it stands.
    pub fn next(&mut self) -> Option<&'a [u8]> {
        let start = self.rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = self.rest.get(start..)?;
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        Some(word)
    }

    /// How many words are left.
    pub fn n_left(&self) -> usize {
        let mut words = self.clone();
        std::iter::from_fn(|| words.next()).count()
    }

    pub fn fault(&self, kind: FaultKind, field: &str, found: String, expected: &str) -> LineFault {
        let field = format!("{}.{field}", self.message);
        LineFault { line: self.line, kind, field, found, expected: expected.to_owned() }
    }

    /// A word that must be there.
    pub fn word(&mut self, field: &str) -> Result<&'a [u8], LineFault> {
        let missing = "missing at the end of the line".to_owned();
        self.next().ok_or_else(|| self.fault(FaultKind::TooFewFields, field, missing, "a value"))
    }

    /// A number that may be infinite or not-a-number.
    fn any_number(&mut self, field: &str) -> Result<f64, LineFault> {
        let word = self.word(field)?;
        number(word).ok_or_else(|| self.fault(FaultKind::NotANumber, field, shown(word), "a number"))
    }

    /// A finite number.
    pub fn number(&mut self, field: &str) -> Result<f64, LineFault> {
        self.number_up_to(field, FARTHEST, "a finite number of at most 1e9")
    }

    fn number_up_to(&mut self, field: &str, most: f64, expected: &str) -> Result<f64, LineFault> {
        let value = self.any_number(field)?;
        if value.abs() <= most {
            return Ok(value);
        }
        Err(self.fault(FaultKind::NotFinite, field, value.to_string(), expected))
    }

    /// x, y and angle, lengths in meters after `scale`.
    pub fn pose(&mut self, fields: [&str; 3], scale: f64) -> Result<Pose2, LineFault> {
        let [x, y, yaw] = fields;
        Ok(pose2(self.number(x)? * scale, self.number(y)? * scale, self.number(yaw)?))
    }

    /// A stamp in seconds.
    pub fn stamp(&mut self, field: &str) -> Result<Time, LineFault> {
        self.number_up_to(field, LATEST_S, "seconds between -9e9 and 9e9").map(Time::from_secs)
    }

    /// How many beams follow; at least `least`.
    pub fn n_beams(&mut self, field: &str, least: usize) -> Result<usize, LineFault> {
        let value = self.any_number(field)?;
        let is_whole = value.fract() == 0.0 && value >= least as f64 && value <= MOST_BEAMS as f64;
        if is_whole {
            return Ok(value as usize);
        }
        let expected = format!("a whole number from {least} to {MOST_BEAMS}");
        Err(self.fault(FaultKind::ImpossibleCount, field, value.to_string(), &expected))
    }

    /// `n` numbers of at least zero (times `scale`), into `out`; infinite and not-a-number go on as they are.
    pub fn beams(&mut self, field: &str, n: usize, scale: f64, out: &mut Vec<f32>) -> Result<(), LineFault> {
        out.clear();
        for idx in 0..n {
            let value = match self.next().map(|word| (word, number(word))) {
                Some((_, Some(value))) if value.is_nan() || value >= 0.0 => value,
                Some((_, Some(value))) => {
                    let field = format!("{field}[{idx}]");
                    let expected = "a number of at least 0";
                    return Err(self.fault(FaultKind::OutOfRange, &field, value.to_string(), expected));
                }
                Some((word, None)) => {
                    let field = format!("{field}[{idx}]");
                    return Err(self.fault(FaultKind::NotANumber, &field, shown(word), "a number"));
                }
                None => {
                    let (field, missing) = (format!("{field}[{idx}]"), "missing at the end of the line");
                    let expected = format!("{n} values");
                    return Err(self.fault(FaultKind::TooFewFields, &field, missing.to_owned(), &expected));
                }
            };
            out.push((value * scale) as f32);
        }
        Ok(())
    }
}
