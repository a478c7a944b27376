//! The messages of a step in few bytes: of each, the [words](super::packed_words) in which it differs from the message of
//! its kind before it.
//!
//! A robot's numbers change one by one: mounts, heights, empty rows of covariances and figures of a device stay as they
//! are. What a copy for viewers has already, ranges and points, is taken from there. All of it is exact: what comes out
//! has the same bytes as what went in.

use super::cdr::{CdrError, CdrWriter};
use super::layout::OBSERVATIONS;
use super::packed_words::{LastWords, take};
use super::room::Room;
use super::step_encoder::Said;
use rumbo_core::messages::SensorId;

/// What every message begins with: plain CDR, little endian.
const ENCODING: [u8; 4] = [0, 1, 0, 0];
/// The message has another length than the one before; it follows.
const OTHER_LENGTH: u8 = 1;
/// The message ends in bytes of a copy for viewers; number of the copy, place and length follow.
const COPIED: u8 = 2;
/// Observations are numbered from here in the order of [`OBSERVATIONS`].
const FIRST_OBSERVATION: u8 = 16;
/// What is no observation, by its number.
const FIXED: [Said; 7] =
    [Said::Order, Said::Map, Said::Estimate, Said::Path, Said::Command, Said::Event, Said::Step];

/// Where the ranges or points of an observation stand: in a copy for viewers that was written before the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ViewerCopy {
    /// How many copies there were before in this step.
    pub number: u8,
    /// Where in the copy they begin.
    pub start: usize,
    /// How many bytes they are.
    pub len: usize,
}

/// The last message of a kind.
#[derive(Debug)]
struct KnownKind {
    said: Said,
    /// What tells the kind in a step: a number, and that of the sensor.
    code: (u8, Option<[u8; 2]>),
    words: LastWords,
}

/// The last messages of every kind.
#[derive(Debug, Default)]
struct Known(Vec<KnownKind>);

impl Known {
    #[inline]
    fn of(&mut self, said: Said) -> Option<&mut KnownKind> {
        let known = self.0.iter().position(|known| known.said == said);
        if known.is_none() {
            self.0.push(KnownKind { said, code: code_of(said), words: LastWords::default() });
        }
        let idx = known.unwrap_or(self.0.len() - 1);
        self.0.get_mut(idx)
    }
}

/// Words that count or tell the time.
fn clocks(said: Said) -> &'static [usize] {
    match said {
        Said::Observation(..) => &[1],
        Said::Estimate | Said::Command => &[0],
        Said::Step => &[0, 1],
        Said::Order | Said::Map | Said::Path | Said::Event => &[],
    }
}

/// Packs steps.
#[derive(Debug, Default)]
pub struct StepPacker {
    known: Known,
    is_open: bool,
}

impl StepPacker {
    /// Head of the message and the length of its only field.
    const HEAD: usize = ENCODING.len() + 4;

    /// Adds a message to the step that stands in `to`; where there is a copy for viewers, `message` ends before the
    /// readings.
    pub fn add(&mut self, said: Said, message: &[u8], copy: Option<ViewerCopy>, to: &mut CdrWriter) {
        let Some(known) = self.known.of(said) else { return };
        if !self.is_open {
            self.is_open = true;
            to.begin().length(0);
        }
        let (out, own) = (to.room(), message.get(ENCODING.len()..).unwrap_or_default());
        let is_other = own.len() != known.words.n_bytes();
        let length = if is_other { OTHER_LENGTH } else { 0 };
        let how = length | if copy.is_some() { COPIED } else { 0 };
        match known.code {
            (number, None) => out.put([number, how]),
            (number, Some([low, high])) => out.put([number, low, high, how]),
        }
        if is_other {
            put_length(out, own.len());
            known.words.fit(own.len());
        }
        if let Some(copy) = copy {
            out.put([copy.number]);
            put_length(out, copy.start);
            put_length(out, copy.len);
        }
        known.words.pack(own, clocks(said), out);
    }

    /// Closes the message; without one there was nothing to say. The next one begins another step.
    pub fn finish(&mut self, to: &mut CdrWriter) {
        if std::mem::take(&mut self.is_open) {
            let len = to.bytes().len();
            let start = to.room().len() - len;
            let packed = u32::try_from(len - Self::HEAD).unwrap_or(u32::MAX);
            to.room().set(start + ENCODING.len(), &packed.to_le_bytes());
        }
    }
}

fn put_length(out: &mut Room, len: usize) {
    out.put(u32::try_from(len).unwrap_or(u32::MAX).to_le_bytes());
}

fn length(packed: &mut &[u8]) -> Result<usize, CdrError> {
    Ok(u32::from_le_bytes(take(packed)?) as usize)
}

/// The number of a kind, and that of the sensor.
fn code_of(said: Said) -> (u8, Option<[u8; 2]>) {
    if let Said::Observation(sensor, kind) = said {
        let known = OBSERVATIONS.iter().zip(FIRST_OBSERVATION..).find(|((known, _), _)| *known == kind);
        (known.map_or(u8::MAX, |(_, number)| number), Some(sensor.0.to_le_bytes()))
    } else {
        let known = FIXED.iter().zip(0..).find(|(known, _)| **known == said);
        (known.map_or(u8::MAX, |(_, number)| number), None)
    }
}

fn said(packed: &mut &[u8]) -> Result<Said, CdrError> {
    let [number] = take(packed)?;
    if let Some(said) = FIXED.get(usize::from(number)) {
        return Ok(*said);
    }
    let found = || CdrError::Value {
        field: "kind of message",
        found: number.to_string(),
        expected: "a kind that this program knows",
    };
    let known = number.checked_sub(FIRST_OBSERVATION).and_then(|idx| OBSERVATIONS.get(usize::from(idx)));
    let (kind, _) = known.ok_or_else(found)?;
    Ok(Said::Observation(SensorId(u16::from_le_bytes(take(packed)?)), *kind))
}

/// Unpacks steps, in the order in which they were packed.
#[derive(Debug, Default)]
pub struct StepUnpacker {
    known: Known,
}

impl StepUnpacker {
    /// Gives every message of a step to `say`; `copies` are what viewers got before it.
    pub fn unpack(
        &mut self,
        mut packed: &[u8],
        copies: &[Vec<u8>],
        mut say: impl FnMut(Said, Vec<u8>) -> Result<(), CdrError>,
    ) -> Result<(), CdrError> {
        while !packed.is_empty() {
            let said = said(&mut packed)?;
            let [how] = take(&mut packed)?;
            let Some(known) = self.known.of(said) else { return Ok(()) };
            if how & OTHER_LENGTH != 0 {
                let len = length(&mut packed)?;
                // Every 64 bytes have a byte that says which of them changed: no more room is made for a length that lies.
                let wanted = len.div_ceil(64);
                if wanted > packed.len() {
                    return Err(CdrError::Short { len: packed.len(), wanted });
                }
                known.words.fit(len);
            }
            let readings = if how & COPIED != 0 { copied(&mut packed, copies)? } else { &[] };
            let mut message = Vec::with_capacity(ENCODING.len() + known.words.n_bytes() + 8 + readings.len());
            message.extend_from_slice(&ENCODING);
            packed = known.words.unpack(packed, clocks(said), &mut message)?;
            message.extend_from_slice(readings);
            say(said, message)?;
        }
        Ok(())
    }
}

fn copied<'a>(packed: &mut &[u8], copies: &'a [Vec<u8>]) -> Result<&'a [u8], CdrError> {
    let [number] = take(packed)?;
    let (start, len) = (length(packed)?, length(packed)?);
    let readings = copies.get(usize::from(number)).and_then(|copy| copy.get(start..start.checked_add(len)?));
    readings.ok_or_else(|| CdrError::Value {
        field: "readings",
        found: format!("not in the {} messages for viewers of this step", copies.len()),
        expected: "there: a recording of which topics were taken away cannot be replayed",
    })
}
