//! From bytes to fixes, with an account of everything that is none.

use std::collections::VecDeque;

use super::{Fix, Gga, Refusal, Sentences};

/// Talkers whose GGA is a position: GPS, several systems, GLONASS, Galileo, BeiDou.
const TALKERS: [&str; 5] = ["GP", "GN", "GL", "GA", "GB"];

/// What a line comes to.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// A fix, or that there is none.
    Gga(Gga),
    /// A good sentence about something else.
    Other,
    /// No good one.
    Refused(Refusal),
}

/// How many lines came to what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Fixes.
    pub n_fixes: u64,
    /// Sentences that say that there is no fix.
    pub n_without_fix: u64,
    /// Good sentences about something else.
    pub n_others: u64,
    /// Lines that broke off or have no beginning.
    pub n_cut_off: u64,
    /// Lines without a checksum, or with a wrong one.
    pub n_checksum: u64,
    /// Lines that are longer than any sentence.
    pub n_too_long: u64,
    /// Lines whose checksum is right, and whose content is not.
    pub n_content: u64,
}

impl Tally {
    /// Lines that were refused.
    pub fn n_refused(&self) -> u64 {
        self.n_cut_off + self.n_checksum + self.n_too_long + self.n_content
    }

    fn count(&mut self, heard: &Heard) {
        let counter = match heard {
            Heard::Gga(Gga::Fix(_)) => &mut self.n_fixes,
            Heard::Gga(Gga::NoFix { .. }) => &mut self.n_without_fix,
            Heard::Other => &mut self.n_others,
            Heard::Refused(Refusal::CutOff | Refusal::NoStart) => &mut self.n_cut_off,
            Heard::Refused(Refusal::NoChecksum | Refusal::Checksum { .. }) => &mut self.n_checksum,
            Heard::Refused(Refusal::TooLong) => &mut self.n_too_long,
            Heard::Refused(_) => &mut self.n_content,
        };
        *counter += 1;
    }
}

/// See [`Heard`].
#[derive(Debug, Clone, Default)]
pub struct Decoder {
    sentences: Sentences,
    heard: VecDeque<Heard>,
    tally: Tally,
}

impl Decoder {
    /// Takes bytes in, however they are cut.
    pub fn push(&mut self, bytes: &[u8]) {
        self.sentences.push(bytes);
        self.read();
    }

    /// The line is lost.
    pub fn break_off(&mut self) {
        self.sentences.break_off();
        self.read();
    }

    /// What the next line comes to.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Option<Heard> {
        self.heard.pop_front()
    }

    /// All lines so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn read(&mut self) {
        while let Some(sentence) = self.sentences.next() {
            let heard = match sentence {
                Err(refusal) => Heard::Refused(refusal),
                Ok(sentence) if sentence.kind() != "GGA" => Heard::Other,
                Ok(sentence) if !TALKERS.contains(&sentence.talker()) => {
                    Heard::Refused(Refusal::Talker(sentence.talker().to_owned()))
                }
                Ok(sentence) => Fix::of_fields(sentence.fields()).map_or_else(Heard::Refused, Heard::Gga),
            };
            self.tally.count(&heard);
            self.heard.push_back(heard);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
