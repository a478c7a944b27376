//! What was skipped in a log, and why: counted by reason, with the first line of each.

use std::collections::BTreeMap;

use super::error::{Damage, FaultKind, LineFault};

/// How often, and where first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Count<T> {
    /// How often.
    pub n: u64,
    /// The first of them.
    pub first: T,
}

/// What was not read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tally {
    /// Lines that could not be read.
    pub faults: BTreeMap<FaultKind, Count<LineFault>>,
    /// Lines whose first word is no message that we know, with the number of the first line.
    pub unknown: BTreeMap<String, Count<u64>>,
    /// Scans whose number of beams is unusual, so that their spacing is a guess: the number of beams of the first.
    pub guessed: Option<Count<usize>>,
    /// Where reading ended too early.
    pub damage: Option<Damage>,
}

impl Tally {
    /// Different unknown words that are counted by name; garbage has no end of them.
    const MOST_WORDS: usize = 32;
    /// Name under which all others are counted.
    const OTHERS: &'static str = "others";

    /// Lines that could not be read, for any reason.
    pub fn n_faults(&self) -> u64 {
        self.faults.values().map(|count| count.n).sum()
    }

    /// Lines of unknown messages.
    pub fn n_unknown(&self) -> u64 {
        self.unknown.values().map(|count| count.n).sum()
    }

    /// One sentence for each thing that people should know, without the name of the file.
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences: Vec<String> = self.damage.iter().map(ToString::to_string).collect();
        for (kind, Count { n, first }) in &self.faults {
            let lines = if *n == 1 { "line" } else { "lines" };
            sentences.push(format!("skipped {n} {lines} with {}, first {first}", kind.name()));
        }
        if !self.unknown.is_empty() {
            let list: Vec<String> = self
                .unknown
                .iter()
                .map(|(word, Count { n, first })| format!("{word} ({n}, from line {first})"))
                .collect();
            sentences.push(format!("skipped messages that are not understood: {}", list.join(", ")));
        }
        if let Some(Count { n, first }) = self.guessed {
            sentences.push(format!(
                "the log does not say how far apart the {first} beams of {n} scans are; 180 degrees in all is a guess, \
                 set first_bearing_deg and bearing_step_deg"
            ));
        }
        sentences
    }

    pub(crate) fn count(&mut self, fault: &LineFault) {
        let first = || Count { n: 0, first: fault.clone() };
        self.faults.entry(fault.kind).or_insert_with(first).n += 1;
    }

    pub(super) fn count_unknown(&mut self, word: String, line: u64) {
        let is_listed = self.unknown.contains_key(&word) || self.unknown.len() < Self::MOST_WORDS;
        let name = if is_listed { word } else { Self::OTHERS.to_owned() };
        self.unknown.entry(name).or_insert(Count { n: 0, first: line }).n += 1;
    }
}
