//! A bag on its way: what is read ahead, in the order of the stamps, and what has become due.

use std::collections::{BTreeMap, VecDeque};

use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Observation, ObservationKind};
use rumbo_core::stages::{Advance, Truth, WorldError};
use rumbo_core::time::{Span, Time};

use super::source::{BagMoment, BagSource, odometry_in};
use crate::log::channel::{Channel, Lent};
use crate::log::truth::KnownTruth;

/// A bag on its way.
#[derive(Debug)]
pub struct BagPlayback {
    source: BagSource,
    name: String,
    now: Time,
    ahead: VecDeque<BagMoment>,
    is_read: bool,
    channels: BTreeMap<String, (ObservationKind, Channel)>,
    lent: Lent,
    known: KnownTruth,
    recorded: Option<Truth>,
    n_late: u64,
    notices: VecDeque<String>,
}

impl BagPlayback {
    /// Messages that are farther out of order than this are left out.
    const WINDOW: Span = Span(2_000_000_000);

    /// A bag at its first stamp; `name` stands in what it tells.
    pub fn new(source: BagSource, name: String, known: KnownTruth) -> BagPlayback {
        let mut playback = BagPlayback {
            source,
            name,
            now: Time::ZERO,
            ahead: VecDeque::new(),
            is_read: false,
            channels: BTreeMap::new(),
            lent: Lent::default(),
            known,
            recorded: None,
            n_late: 0,
            notices: VecDeque::new(),
        };
        playback.read_ahead();
        playback.recorded = playback.ahead.front().and_then(|moment| moment.truth);
        playback.known.advance(Time::ZERO);
        playback
    }

    /// What was run, in a recording of ours; where time begins.
    pub fn source(&self) -> &BagSource {
        &self.source
    }

    /// The time it is, since the first stamp.
    pub fn now(&self) -> Time {
        self.now
    }

    /// When the next observation is due; at the end of the bag now, so that the end is met at once.
    pub fn next(&self) -> Time {
        self.ahead.front().map_or(self.now, |moment| moment.stamp.max(self.now))
    }

    /// Where the robot really is: from a file of poses, else as the run knew it.
    pub fn truth(&self) -> Option<&Truth> {
        self.known.now().or(self.recorded.as_ref())
    }

    /// The first pose of a file of poses and its time.
    pub fn first_truth(&self) -> Option<(Time, Pose2)> {
        self.known.first()
    }

    /// The odometer's first pose, if it is not far ahead.
    pub fn first_odometry(&self) -> Option<Pose2> {
        self.ahead.iter().find_map(odometry_in)
    }

    /// Lets time pass; what was recorded up to `to` becomes due.
    ///
    /// # Errors
    /// [`WorldError::Backwards`] when `to` is over already.
    pub fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        if to < self.now {
            return Err(WorldError::Backwards { now: self.now, to });
        }
        if self.ahead.is_empty() {
            return Ok(Advance::Ended);
        }
        self.now = to;
        while let Some(moment) = self.ahead.pop_front_if(|moment| moment.stamp <= to) {
            self.recorded = moment.truth;
            if let Some(observation) = moment.observation {
                let kind = observation.data.kind();
                let channel = self.channels.entry(moment.channel).or_insert((kind, Channel::default()));
                channel.1.push(observation);
            }
            self.read_ahead();
        }
        self.known.advance(to);
        Ok(Advance::Reached(to))
    }

    /// What a channel has recorded since it was asked last; nothing where it is not known (yet).
    pub fn take(&mut self, channel: &str) -> &[Observation] {
        match self.channels.get_mut(channel) {
            Some((_, channel)) => channel.take(&mut self.lent),
            None => &[],
        }
    }

    /// This channel had anything so far.
    pub fn has_seen(&self, channel: &str) -> bool {
        self.channels.contains_key(channel)
    }

    /// The only channel of this kind so far; none where there are two.
    pub fn only(&self, kind: ObservationKind) -> Option<String> {
        let seen = self.channels.iter().filter(|(_, (other, _))| *other == kind).map(|(name, _)| name);
        let is_it = |moment: &&BagMoment| {
            moment.observation.as_ref().is_some_and(|observation| observation.data.kind() == kind)
        };
        let ahead = self.ahead.iter().filter(is_it).map(|moment| &moment.channel);
        let mut names: Vec<&String> = seen.chain(ahead).collect();
        names.sort_unstable();
        names.dedup();
        match names.as_slice() {
            [only] => Some((*only).clone()),
            _ => None,
        }
    }

    /// What people should know, each thing once.
    pub fn take_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    /// Adds something that people should know.
    pub fn notify(&mut self, sentence: &str) {
        self.notices.push_back(format!("{}: {sentence}", self.name));
    }

    fn read_ahead(&mut self) {
        while !self.is_read {
            let ends = self.ahead.front().zip(self.ahead.back());
            if ends.is_some_and(|(first, last)| last.stamp - first.stamp > Self::WINDOW) {
                return;
            }
            let Some(moment) = self.source.read_on() else { return self.end() };
            if moment.stamp < self.now {
                self.n_late += 1;
                continue;
            }
            let place = self.ahead.partition_point(|other| other.stamp <= moment.stamp);
            self.ahead.insert(place, moment);
        }
    }

    fn end(&mut self) {
        self.is_read = true;
        for sentence in self.source.sentences() {
            self.notify(&sentence);
        }
        if self.n_late > 0 {
            self.notify(&format!("left out {} messages that came more than 2 s out of order", self.n_late));
        }
    }
}
