//! The messages of a step in few bytes: of each, the [words](super::packed_words) in which it differs from the message of
//! its kind before it.
//!
//! A robot's numbers change one by one: mounts, heights, empty rows of covariances and figures of a device stay as they
//! are. What a copy for viewers has already, ranges and points, is taken from there. All of it is exact: what comes out
//! has the same bytes as what went in.

use super::cdr::CdrError;
use super::layout::OBSERVATIONS;
use super::packed_words::{LastWords, take};
use super::step_encoder::Said;
use rumbo_core::messages::SensorId;
use std::ops::Range;

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

/// A copy for viewers that was written before the step.
#[derive(Debug, Clone)]
pub struct ViewerCopy<'a> {
    /// How many copies there were before in this step.
    pub number: usize,
    /// All of it.
    pub message: &'a [u8],
    /// Where in it the ranges or points are.
    pub readings: Range<usize>,
}

/// The last messages of every kind.
#[derive(Debug, Default)]
struct Known(Vec<(Said, LastWords)>);

impl Known {
    fn of(&mut self, said: Said) -> Option<&mut LastWords> {
        let known = self.0.iter().position(|(known, _)| *known == said);
        if known.is_none() {
            self.0.push((said, LastWords::default()));
        }
        let idx = known.unwrap_or(self.0.len() - 1);
        self.0.get_mut(idx).map(|(_, last)| last)
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
    packed: Vec<u8>,
}

impl StepPacker {
    /// Head of the message and the length of its only field.
    const HEAD: usize = ENCODING.len() + 4;

    /// Adds a message to the step.
    pub fn add(&mut self, said: Said, message: &[u8], copy: Option<ViewerCopy<'_>>) {
        let Some((known, out)) = self.known.of(said).zip(Some(&mut self.packed)) else { return };
        if out.is_empty() {
            out.resize(Self::HEAD, 0);
        }
        put_said(out, said);
        let body = message.get(ENCODING.len()..).unwrap_or_default();
        let copied = copy.and_then(|copy| {
            let own = body.strip_suffix(copy.message.get(copy.readings.clone())?)?;
            Some((u8::try_from(copy.number).ok()?, copy.readings, own))
        });
        let own = copied.as_ref().map_or(body, |(_, _, own)| own);
        let is_other = own.len() != known.n_bytes();
        let length = if is_other { OTHER_LENGTH } else { 0 };
        out.push(length | if copied.is_some() { COPIED } else { 0 });
        if is_other {
            put_length(out, own.len());
        }
        if let Some((number, readings, _)) = &copied {
            out.push(*number);
            put_length(out, readings.start);
            put_length(out, readings.len());
        }
        known.fit(own.len());
        known.pack(own, clocks(said), out);
    }

    /// The step as one message; none where there was nothing to say. The next message begins another.
    pub fn finish(&mut self, write: impl FnOnce(&[u8])) {
        let len = self.packed.len().saturating_sub(Self::HEAD);
        if let Some(head) = self.packed.first_chunk_mut::<{ Self::HEAD }>() {
            head[..4].copy_from_slice(&ENCODING);
            head[4..].copy_from_slice(&u32::try_from(len).unwrap_or(u32::MAX).to_le_bytes());
            write(&self.packed);
        }
        self.packed.clear();
    }
}

fn put_length(out: &mut Vec<u8>, len: usize) {
    out.extend_from_slice(&u32::try_from(len).unwrap_or(u32::MAX).to_le_bytes());
}

fn length(packed: &mut &[u8]) -> Result<usize, CdrError> {
    Ok(u32::from_le_bytes(take(packed)?) as usize)
}

fn put_said(out: &mut Vec<u8>, said: Said) {
    if let Said::Observation(sensor, kind) = said {
        let known = OBSERVATIONS.iter().zip(FIRST_OBSERVATION..).find(|((known, _), _)| *known == kind);
        out.push(known.map_or(u8::MAX, |(_, number)| number));
        out.extend_from_slice(&sensor.0.to_le_bytes());
    } else {
        let known = FIXED.iter().zip(0..).find(|(known, _)| **known == said);
        out.push(known.map_or(u8::MAX, |(_, number)| number));
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
                known.fit(len);
            }
            let readings = if how & COPIED != 0 { copied(&mut packed, copies)? } else { &[] };
            let mut message = Vec::with_capacity(ENCODING.len() + known.n_bytes() + 8 + readings.len());
            message.extend_from_slice(&ENCODING);
            packed = known.unpack(packed, clocks(said), &mut message)?;
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
