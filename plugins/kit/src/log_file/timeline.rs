//! The records of a log in the order of their stamps.
//!
//! Logs interleave their channels out of order: a scan is written after odometry that is newer than it, and clocks
//! jitter. Records are therefore held back until the log is [`Timeline::WINDOW`] further, and sorted. What is farther
//! out of order than that is no late record but a wrong stamp. Which of two neighbors has the wrong stamp is for the
//! record after them to say; so neither a stamp of zero nor one of next year costs more than itself.

use std::collections::BTreeMap;
use std::path::Path;

use rumbo_core::boundary::Buffer;
use rumbo_core::time::{Span, Time};

use super::beam_rule::BeamOverride;
use super::error::LogError;
use super::order_tally::OrderTally;
use super::reader::LogReader;
use super::record::{LaserSide, RecordedOdometry, RecordedScan, Told};
use super::tally::Tally;

/// A record that has a stamp.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// When, absolute.
    pub stamp: Time,
    /// Number of its line, from 1.
    pub line: u64,
    /// What was recorded.
    pub data: MomentData,
}

/// What a record with a stamp holds.
#[derive(Debug, Clone, PartialEq)]
pub enum MomentData {
    /// A scan.
    Scan(RecordedScan),
    /// A reading of the odometer.
    Odometry(RecordedOdometry),
}

/// A log in the order of its stamps; within a channel no two are equal.
#[derive(Debug)]
pub struct Timeline {
    reader: LogReader,
    held: BTreeMap<(Time, u64), Moment>,
    newest: Option<Time>,
    candidate: Option<Moment>,
    /// The first record, where the second contradicts it and the third has to say which of them is right.
    rival: Option<Moment>,
    released: [Option<Time>; 3],
    origin: Time,
    tally: OrderTally,
}

impl Timeline {
    /// Records up to this much out of order are sorted in.
    pub const WINDOW: Span = Span(2_000_000_000);
    /// A last or first record that is this far from all others has a wrong stamp.
    const LONE: Span = Span(3_600_000_000_000);
    /// A leap of more than this is a clock that was set: nothing behind it fits to what came before.
    const LEAP: Span = Span(86_400_000_000_000);
    /// Holds no more records than this, however dense they are.
    const MOST_HELD: usize = 4096;

    /// Opens a log and finds its first stamp.
    ///
    /// # Errors
    /// [`LogError`] for a file that is no log, or has no scan and no odometry.
    pub fn open(path: &Path, known: BeamOverride) -> Result<Timeline, LogError> {
        let reader = LogReader::open(path, known)?;
        let mut timeline = Timeline {
            reader,
            held: BTreeMap::new(),
            newest: None,
            candidate: None,
            rival: None,
            released: [None; 3],
            origin: Time::ZERO,
            tally: OrderTally::default(),
        };
        timeline.fill();
        match timeline.held.first_key_value() {
            Some((&(first, _), _)) => timeline.origin = first,
            None => {
                let found = "no scan and no odometry".to_owned();
                let (path, expected) = (path.to_owned(), "FLASER, ROBOTLASER1, ODOM, L or O lines");
                return Err(LogError::NoRecords { path, found, expected });
            }
        }
        Ok(timeline)
    }

    /// The first stamp: where the time of a run begins.
    pub fn origin(&self) -> Time {
        self.origin
    }

    /// What was skipped so far.
    pub fn tally(&self) -> &Tally {
        self.reader.tally()
    }

    /// How the stamps ran so far.
    pub fn order(&self) -> &OrderTally {
        &self.tally
    }

    /// Takes the ranges of a scan that nobody needs any more.
    pub fn recycle(&mut self, buffer: Buffer<f32>) {
        self.reader.recycle(buffer);
    }

    /// Reads until the oldest record held is old enough to be given.
    fn fill(&mut self) {
        while !self.is_ripe() {
            match self.reader.next() {
                Some(Ok(record)) => {
                    let line = record.line;
                    match record.told {
                        Told::Scan(scan) => {
                            let steps = match scan.side {
                                LaserSide::Front => &mut self.tally.front_laser,
                                LaserSide::Rear => &mut self.tally.rear_laser,
                            };
                            steps.see(scan.stamp, line);
                            self.judge(Moment { stamp: scan.stamp, line, data: MomentData::Scan(scan) });
                        }
                        Told::Odometry(odometry) => {
                            let stamp = odometry.stamp;
                            self.tally.odometry.see(stamp, line);
                            self.judge(Moment { stamp, line, data: MomentData::Odometry(odometry) });
                        }
                        _ => {}
                    }
                }
                Some(Err(_)) => {}
                None => return self.close(),
            }
        }
    }

    /// The log is over: nothing confirms or contradicts its last record any more.
    fn close(&mut self) {
        self.rival.take().iter().for_each(|rival| self.tally.count_stray(rival.line));
        match self.candidate.take() {
            Some(last) if self.newest.is_none_or(|newest| last.stamp - newest <= Self::LONE) => {
                self.hold(last)
            }
            Some(stray) => self.tally.count_stray(stray.line),
            None => {}
        }
    }

    fn is_ripe(&self) -> bool {
        let oldest = self.held.first_key_value().map(|(&(stamp, _), _)| stamp);
        let is_old = oldest.zip(self.newest).is_some_and(|(oldest, newest)| newest - oldest >= Self::WINDOW);
        is_old || self.held.len() >= Self::MOST_HELD
    }

    /// Decides whether a record, or the odd one before it, has a stamp that fits.
    fn judge(&mut self, moment: Moment) {
        let stamp = moment.stamp;
        let is_near = |newest: Time| (stamp - newest).0.abs() <= Self::WINDOW.0;
        self.settle_first(stamp);
        if let Some(odd) = self.candidate.take() {
            if self.follows(&odd, stamp) {
                self.hold(odd);
            } else if self.newest.is_some_and(|newest| stamp < newest && !is_near(newest)) {
                // This one is behind both: it is the odd one itself.
                self.candidate = Some(odd);
            } else if self.newest.is_none() {
                self.rival = Some(odd);
            } else {
                self.tally.count_stray(odd.line);
            }
        }
        match self.newest {
            Some(newest) if is_near(newest) => self.hold(moment),
            Some(newest) if stamp < newest => self.tally.count_stray(moment.line),
            _ => self.candidate = Some(moment),
        }
    }

    /// Decides between the first two records, by a third.
    fn settle_first(&mut self, stamp: Time) {
        let Some(first) = self.rival.take() else { return };
        let second_fits = self.candidate.as_ref().is_some_and(|second| self.follows(second, stamp));
        let is_near = (stamp - first.stamp).0.abs() <= Self::WINDOW.0;
        if is_near || self.follows(&first, stamp) && !second_fits {
            self.candidate.take().iter().for_each(|second| self.tally.count_stray(second.line));
            self.hold(first);
        } else {
            self.tally.count_stray(first.line);
        }
    }

    /// The record after an odd one makes sense behind it, so that the odd one is right and the log has a gap there.
    fn follows(&self, odd: &Moment, next: Time) -> bool {
        let after = next - odd.stamp;
        let is_after = after.0 >= -Self::WINDOW.0;
        match self.newest {
            Some(newest) => is_after && odd.stamp - newest <= Self::LEAP,
            None => is_after && after <= Self::LONE,
        }
    }

    fn hold(&mut self, moment: Moment) {
        self.newest = self.newest.max(Some(moment.stamp));
        self.held.insert((moment.stamp, moment.line), moment);
    }
}

impl Iterator for Timeline {
    type Item = Moment;

    fn next(&mut self) -> Option<Moment> {
        loop {
            self.fill();
            let (_, moment) = self.held.pop_first()?;
            let channel = match &moment.data {
                MomentData::Scan(scan) => scan.side as usize,
                MomentData::Odometry(_) => 2,
            };
            let last = self.released.get_mut(channel)?;
            if last.is_none_or(|last| moment.stamp > last) {
                *last = Some(moment.stamp);
                return Some(moment);
            }
            self.tally.count_equal(moment.line);
        }
    }
}
