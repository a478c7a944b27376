//! How the stamps of a log run: steps backward, records that had to be left out.

use rumbo_core::time::{Span, Time};

use super::tally::Count;

/// Steps backward of one channel, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Steps {
    last: Option<Time>,
    /// How often a stamp was smaller than the one before it.
    pub n: u64,
    /// Line of the first.
    pub first_line: u64,
    /// The largest of them.
    pub largest: Span,
}

impl Steps {
    pub(crate) fn see(&mut self, stamp: Time, line: u64) {
        if let Some(last) = self.last.replace(stamp).filter(|last| stamp < *last) {
            if self.n == 0 {
                self.first_line = line;
            }
            self.n += 1;
            self.largest = self.largest.max(last - stamp);
        }
    }
}

/// How the stamps of a log run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OrderTally {
    /// Steps backward among the scans of the front laser.
    pub front_laser: Steps,
    /// Steps backward among the scans of the rear laser.
    pub rear_laser: Steps,
    /// Steps backward among the odometer's own lines.
    pub odometry: Steps,
    /// Records far out of order, left out: the first line.
    pub stray: Option<Count<u64>>,
    /// Records with the same stamp as the one before them in their channel, left out: the first line.
    pub equal: Option<Count<u64>>,
}

impl OrderTally {
    pub(super) fn count_stray(&mut self, line: u64) {
        self.stray.get_or_insert(Count { n: 0, first: line }).n += 1;
    }

    pub(super) fn count_equal(&mut self, line: u64) {
        self.equal.get_or_insert(Count { n: 0, first: line }).n += 1;
    }

    /// One sentence for each thing that people should know, without the name of the file.
    pub fn sentences(&self) -> Vec<String> {
        let channels = [
            ("front laser", &self.front_laser),
            ("rear laser", &self.rear_laser),
            ("odometry", &self.odometry),
        ];
        let mut sentences = Vec::new();
        for (name, Steps { n, first_line, largest, .. }) in channels {
            if *n > 0 {
                let most_s = largest.as_secs();
                sentences.push(format!(
                    "{name}: stamps step backward {n} times, first in line {first_line}, at most {most_s:.3} s"
                ));
            }
        }
        if let Some(Count { n, first }) = self.stray {
            sentences.push(format!(
                "left out {n} records whose stamps are far out of order, the first in line {first}"
            ));
        }
        if let Some(Count { n, first }) = self.equal {
            sentences.push(format!(
                "left out {n} records with the stamp of the one before them, the first in line {first}"
            ));
        }
        sentences
    }
}
